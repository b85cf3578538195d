# ruff: noqa: E402, what a plain install lacks is named before it is imported
"""The one style of all figures, also where a file is written or a page shows them."""

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
    # Letters stay letters, which a journal asks for.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
}


class StyledFigure(Figure):
    """A figure that keeps its style: matplotlib resolves fonts and ticks only when it draws."""

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
    """A new figure of this size, inches; what is drawn inside is in the style."""
    with mpl.rc_context(STYLE):
        yield StyledFigure(figsize=(width, height), **{"layout": "constrained", **named})
