"""Stress in piston and bit over place and time."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..frames import np, pd
from ..scene.variables import Array
from ..simulation.diagram import Waves
from ..study.fatigue import Life
from .dark import ON_COLOUR
from .marks import COLOURS, MODES, apart
from .style import styled


def wave_diagram(waves: Waves, life: Life | None = None) -> Figure:
    """Draws the stress in piston and bit over position and time, with contact and rock mode.

    If ``life`` is given, a line marks the position that breaks first.

    Example:
        >>> from dth_hammer import figures, waves
        >>> figures.wave_diagram(waves(until="100 ms")).savefig("waves.png")
    """
    time = waves.time * 1e6
    with styled(7.5, 6.2) as figure:
        plane, strip = figure.subplots(1, 2, sharey=True, width_ratios=(1, 0.045))
        bars = (waves.piston, waves.bit)
        # The scale is symmetric, so that white means zero stress.
        limit = max(float(np.abs(bar.stress).max()) for bar in bars) * 1e-6
        for bar in bars:
            mesh = plane.pcolormesh(
                bar.nodes * 1e3,
                _edges(time),
                bar.stress * 1e-6,
                cmap="RdBu_r",
                vmin=-limit,
                vmax=limit,
                rasterized=True,
            )
        ends = (waves.piston.nodes[0] * 1e3, waves.bit.nodes[-1] * 1e3)
        _contact_line(plane, time, waves.beside["contact_closed"].to_numpy(bool), ends)
        _mode_strip(strip, time, waves.beside["rock_mode"].astype(str).to_numpy())
        plane.set_xlim(*ends)
        plane.set_ylim(time[0], time[-1])
        plane.set_xlabel("position below the contact (mm)")
        plane.set_ylabel("time since impact (µs)")
        plane.set_title("piston", loc="left")
        plane.set_title("bit", loc="right")
        if life is not None:
            _worst_place(plane, life.worst, ends)
        scale = figure.colorbar(mesh, ax=plane, location="top", aspect=45, pad=0.02)
        scale.set_label("axial stress (MPa), tension positive")
        if "front" in waves.notes:
            _mark(scale.ax, -waves.notes["front"] * 1e-6, "first front in the bit")
    return figure


def _worst_place(axes: Axes, worst: pd.Series, ends: tuple[float, float]) -> None:
    """Marks the position that breaks first by a line, labelled on the side with more room."""
    place = worst["position"] * 1e3
    axes.axvline(place, color="black", linewidth=1.2, linestyle=":", gid=ON_COLOUR)
    left = place > 0.5 * ends[worst["body"] == "bit"]
    where: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}
    axes.annotate(
        f"breaks first: {worst['hours']:.4g} h",
        (place, 0.97),
        xytext=(-4 if left else 4, 0),
        **where,
        ha="right" if left else "left",
        va="top",
        fontsize=8,
        bbox=box,
        gid=ON_COLOUR,
    )


def _mark(scale: Axes, value: float, text: str) -> None:
    """Marks a value on a colour scale by a line with a label below."""
    scale.axvline(value, color="black", linewidth=1.2, gid=ON_COLOUR)
    place: dict[str, Any] = {"xytext": (0, -3), "textcoords": "offset points"}
    scale.annotate(text, (value, 0.0), **place, ha="center", va="top", fontsize=8)


def _edges(points: Array) -> Array:
    """Returns the bounds of the intervals around points, halfway between neighbours."""
    middle = 0.5 * (points[1:] + points[:-1])
    return np.concatenate((points[:1], middle, points[-1:]))


def _contact_line(axes: Axes, time: Array, closed: Array, ends: tuple[float, float]) -> None:
    """Draws a thick line while the bodies touch, and dashed lines at the ends of each contact."""
    axes.axvline(0.0, color="0.4", linewidth=0.6, gid=ON_COLOUR)
    axes.plot(np.where(closed, 0.0, np.nan), time, color="black", linewidth=2.2, gid=ON_COLOUR)
    events = np.flatnonzero(np.diff(closed.astype(int)))
    left, span = 0.985 * ends[0] + 0.015 * ends[1], time[-1] - time[0]
    # A label is on the side of its line on which the contact is closed. Labels of short contacts
    # keep their order and are spread out.
    wanted_places = np.maximum.accumulate(
        [time[i] + (-0.016 if closed[i] else 0.016) * span for i in events]
    )
    places = apart(wanted_places.tolist(), 0.03 * span, time[-1] - 0.016 * span)
    for index, place in zip(events, places, strict=True):
        change = "opens" if closed[index] else "closes"
        dashes: Any = (0, (6, 3))
        axes.axhline(time[index], color="black", linewidth=0.6, linestyle=dashes, gid=ON_COLOUR)
        axes.text(left, place, f"contact {change}", va="center", fontsize=8, gid=ON_COLOUR)


def _mode_strip(axes: Axes, time: Array, modes: Array) -> None:
    """Draws the rock law's mode over time as a coloured strip, labelled where there is room."""
    bounds = np.flatnonzero(modes[1:] != modes[:-1]) + 1
    for start, end in zip([0, *bounds], [*bounds, len(time) - 1], strict=True):
        mode, height = modes[start], time[end] - time[start]
        axes.axhspan(time[start], time[end], color=COLOURS[mode], linewidth=0, gid=ON_COLOUR)
        if height > 0.03 * (time[-1] - time[0]):
            middle = 0.5 * (time[start] + time[end])
            alignment: dict[str, Any] = {"ha": "center", "va": "center"}
            axes.text(0.5, middle, MODES[mode], **alignment, fontsize=8, gid=ON_COLOUR)
    axes.set_xlim(0.0, 1.0)
    axes.set_xticks([])
    axes.tick_params(axis="y", length=0)
    axes.set_title("rock", fontsize=9)
