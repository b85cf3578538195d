"""The rock law's five modes as a state diagram."""

from __future__ import annotations

from dth_hammer.figures import COLOURS, MODES
from dth_hammer.figures.style import styled
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

Point = tuple[float, float]
WIDTH, HEIGHT = 2.3, 0.95
PLACES: dict[str, Point] = {
    "FreeFlight": (0.0, 0.0),
    "DissipativeForward": (5.0, 1.9),
    "Forward": (10.0, 0.0),
    "Backward": (5.0, -1.9),
    "Standstill": (5.0, -4.9),
}
LAWS = {
    "FreeFlight": r"$F_R = 0$",
    "DissipativeForward": r"$K_R(p - u_l) + C_R\,\dot p$",
    "Forward": r"$K_R(p - u_l)$",
    "Backward": r"$\gamma K_R(p - u_u)$",
    "Standstill": r"$\gamma K_R(p - u_u)$",
}
# From, to, event, bend of the arrow, position of the text.
EVENTS: tuple[tuple[str, str, str, float, Point], ...] = (
    ("FreeFlight", "DissipativeForward", "touches the rock\n$p = u_l$", -0.15, (1.5, 1.85)),
    ("DissipativeForward", "Forward", "rock breaks\n" + r"$\psi = W_R$", -0.15, (8.6, 1.85)),
    ("Forward", "Backward", "turns back\n" + r"$\dot p = 0$", -0.15, (9.95, -1.6)),
    ("DissipativeForward", "Backward", "turns back\n" + r"$\dot p = 0$", -0.35, (6.55, 0.0)),
    (
        "Backward",
        "DissipativeForward",
        "advances again\n" + r"$\dot p = 0,\ \Delta p \geq \Delta p_s$",
        -0.35,
        (3.15, 0.0),
    ),
    ("Backward", "FreeFlight", "lifts off\n$p = u_u$", -0.15, (1.5, -1.85)),
    (
        "Backward",
        "Standstill",
        "too little gain\n" + r"$\dot p = 0,\ \Delta p < \Delta p_s$",
        -0.3,
        (6.5, -3.15),
    ),
    ("Standstill", "Backward", "leaves upward\n" + r"$\dot p = -v_s$", -0.3, (3.75, -3.4)),
    ("Standstill", "FreeFlight", "lifted slowly\n$p = u_u$", -0.3, (1.2, -3.9)),
    (
        "Standstill",
        "DissipativeForward",
        "leaves downward\n" + r"$\dot p = v_s$",
        1.15,
        (9.0, -3.75),
    ),
)


def draw() -> Figure:
    """Draws the diagram."""
    with styled(8.6, 5.2, layout=None) as figure:
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_xlim(-1.4, 11.4)
        axes.set_ylim(-5.6, 2.6)
        boxes = {name: _box(axes, name, centre) for name, centre in PLACES.items()}
        for start, end, text, bend, place in EVENTS:
            _arrow(axes, (start, end), bend, boxes)
            axes.text(*place, text, ha="center", va="center", fontsize=9, linespacing=1.4)
    return figure


def _box(axes: Axes, name: str, centre: Point) -> FancyBboxPatch:
    corner = (centre[0] - WIDTH / 2, centre[1] - HEIGHT / 2)
    style = "round,pad=0.05,rounding_size=0.2"
    box = FancyBboxPatch(
        corner, WIDTH, HEIGHT, boxstyle=style, fc="white", ec=COLOURS[name], lw=1.8, zorder=2
    )
    axes.add_patch(box)
    axes.text(centre[0], centre[1] + 0.2, MODES[name], ha="center", va="center", weight="bold")
    axes.text(centre[0], centre[1] - 0.22, LAWS[name], ha="center", va="center", fontsize=9.5)
    return box


def _arrow(
    axes: Axes, ends: tuple[str, str], bend: float, boxes: dict[str, FancyBboxPatch]
) -> None:
    start, end = ends
    arrow = FancyArrowPatch(
        PLACES[start],
        PLACES[end],
        connectionstyle=f"arc3,rad={bend}",
        arrowstyle="-|>",
        mutation_scale=13,
        patchA=boxes[start],
        patchB=boxes[end],
        shrinkA=1,
        shrinkB=2,
        lw=1.0,
        color="0.25",
        zorder=1,
    )
    axes.add_patch(arrow)
