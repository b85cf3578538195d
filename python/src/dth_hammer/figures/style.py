# ruff: noqa: E402, `need` must run first to report a missing matplotlib
"""The style of all figures, also when they are saved or shown in a notebook."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ..extras import need

need("matplotlib")

import matplotlib as mpl
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure

STYLE: dict[Any, Any] = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral", "DejaVu Serif"],
    "mathtext.fontset": "stix",
    "font.size": 10,
    "axes.titlesize": 10.5,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "axes.linewidth": 0.7,
    "lines.linewidth": 1.2,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "figure.dpi": 200,
    # Embed TrueType fonts, so that text stays text, as journals require.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
}


class StyledFigure(Figure):
    """A figure that applies the style when it is drawn, as matplotlib chooses fonts only then."""

    def draw(self, renderer: RendererBase) -> None:
        """Draws the figure in the style."""
        with mpl.rc_context(STYLE):
            super().draw(renderer)

    def savefig(self, *arguments: Any, **named: Any) -> None:
        """Saves the figure in the style."""
        with mpl.rc_context(STYLE):
            super().savefig(*arguments, **named)


@contextmanager
def styled(width: float, height: float, **named: Any) -> Iterator[StyledFigure]:
    """Opens a new figure of this size in inches; everything drawn in the block has the style."""
    with mpl.rc_context(STYLE):
        yield StyledFigure(figsize=(width, height), **{"layout": "constrained", **named})
