"""Changes the colours of a figure for a page with a dark background."""

import colorsys
from typing import Any

from matplotlib.collections import Collection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.spines import Spine
from matplotlib.text import Text

#: Background colour that replaces white.
PAPER = "#1e2129"
#: The ``gid`` of artists that are drawn over coloured areas. They keep their colour, because the
#: areas keep theirs.
ON_COLOUR = "on colour"
#: A colour whose channels differ by less than `GREY` is a grey, which is inverted. Any other colour
#: gets at least the lightness `LIGHT`.
GREY, LIGHT = 0.12, 0.6


def darken(figure: Figure) -> Figure:
    """Changes a figure's colours in place for a dark page: inverts greys and lightens colours.

    Areas coloured by a colour map keep their colours, so that they still match the colour scale.

    Example:
        >>> from matplotlib.colors import to_hex
        >>> from matplotlib.figure import Figure
        >>> from dth_hammer import figures
        >>> figure = Figure()
        >>> title = figure.suptitle("black on white")
        >>> before = title.get_color()
        >>> after = figures.darken(figure).get_suptitle() and title.get_color()
        >>> print(before, to_hex(after))
        black #ebebeb
    """
    for artist in figure.findobj():
        if artist.get_gid() == ON_COLOUR:
            continue
        if isinstance(artist, (Line2D, Text)):
            artist.set_color(_dark_colour(artist.get_color()))
        if isinstance(artist, Line2D):
            artist.set_markerfacecolor(_dark_colour(artist.get_markerfacecolor()))
            artist.set_markeredgecolor(_dark_colour(artist.get_markeredgecolor()))
        elif isinstance(artist, (Patch, Spine)):
            artist.set_edgecolor(_dark_colour(artist.get_edgecolor()))
            artist.set_facecolor(_dark_colour(artist.get_facecolor()))
        elif isinstance(artist, Collection) and artist.get_array() is None:
            artist.set_edgecolor([_dark_colour(c) for c in artist.get_edgecolor()])
            artist.set_facecolor([_dark_colour(c) for c in artist.get_facecolor()])
    for axes in figure.get_axes():
        # Matplotlib creates the ticks again at each drawing, so their colour must be a parameter.
        axes.tick_params(
            which="both", color=_dark_colour("black"), labelcolor=_dark_colour("black")
        )
    return figure


def _dark_colour(colour: Any) -> Any:
    if isinstance(colour, str) and colour in ("none", "auto"):
        return colour
    red, green, blue, alpha = to_rgba(colour)
    hue, light, saturation = colorsys.rgb_to_hls(red, green, blue)
    if max(red, green, blue) - min(red, green, blue) < GREY:
        paper = to_rgba(PAPER)
        return (*(p + (1.0 - light) * (0.92 - p) for p in paper[:3]), alpha)
    return (*colorsys.hls_to_rgb(hue, max(light, LIGHT), saturation), alpha)
