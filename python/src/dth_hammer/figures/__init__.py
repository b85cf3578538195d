# ruff: noqa: E402, `need` must run first to report a missing matplotlib
"""Figures of a run of `dth_hammer.simulate`: each returns a matplotlib figure."""

import itertools
import re
from collections.abc import Mapping
from typing import Any

from ..extras import need

need("matplotlib")

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from ..errors import DthHammerError, TooFewBlowsError
from ..run.diagram import Waves
from ..run.run import Run, simulate
from ..scene.hammers import Hammerlike, Rocklike
from ..scene.variables import Array, whole
from ..study.fatigue import Life
from .dark import ON_COLOUR, darken
from .style import styled

__all__ = [
    "at_blows",
    "convergence",
    "cycle",
    "darken",
    "indicator",
    "ledger",
    "rock_cycles",
    "settled_cycle",
    "wave_diagram",
]
# Colours that remain distinct in print and to colour-blind readers (Okabe and Ito).
PISTON, BIT, ROCK, DARK = "#d55e00", "#0072b2", "#8c6d31", "#444444"
COLOURS = {
    "FreeFlight": "#999999",
    "DissipativeForward": "#d55e00",
    "Forward": "#e69f00",
    "Backward": "#56b4e9",
    "Standstill": "#009e73",
}
#: Abbreviations of the rock law's modes as in the paper, from the free bit to the bit at rest.
MODES = dict(zip(COLOURS, ("FF", "DFC", "FC", "BC", "SS"), strict=True))
PRESSURES = {
    "drive_chamber_pressure": ("drive chamber", PISTON),
    "return_chamber_pressure": ("return chamber", BIT),
}
WORKS = {"energy_drive": "drive", "energy_gravity": "gravity", "energy_feed": "feed"}
SINKS = {
    "energy_rock_dissipated": "rock, elastic loading",
    "energy_viscous": "rock, viscous",
    "energy_damping": "material damping",
}
INTO_COLOURS = ("#0072b2", "#009e73", "#56b4e9", "#f0e442")
OUT_COLOURS = ("#8c6d31", "#d55e00", "#cc79a7", "#999999")
STORES = ("energy_kinetic", "energy_strain", "energy_contact", "energy_rock_stored")


def settled_cycle(
    hammer: Hammerlike = None,
    until: float | str | None = None,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    outlook: float = 4e-3,
    fine: float = 1e-6,
) -> Run:
    """Simulates a hammer and returns the last complete blow period before ``until``.

    Time 0 is the impact at which the period begins. Outputs are recorded every ``fine`` seconds for
    ``outlook`` seconds after the impact, and every ``50 * fine`` seconds in the rest of the period.
    ``notes["period"]`` is the length of the period, s.

    Example:
        >>> from dth_hammer import figures
        >>> run = figures.settled_cycle(until="300 ms")
        >>> print(f"{1e3 * run.notes['period']:.2f} ms")
        45.61 ms
    """
    run = simulate(hammer, until, preset=preset, rock=rock, outputs=["blow_count"])
    table = run.blows
    if len(table) < 2:
        raise TooFewBlowsError(f"{len(table)} blows in {run.time[-1]:g} s: too few for a period")
    period = float(table["blow_period"].iloc[-1])
    impact = float(table["blow_time"].iloc[-1]) - period
    before = np.arange(-0.03 * period, -10 * fine, 50 * fine)
    close = np.arange(-10 * fine, 1.02 * outlook, fine)
    after = np.arange(1.02 * outlook, 1.03 * period, 50 * fine)
    times = np.concatenate((before, close, after))
    close_up = simulate(run, times=impact + times)
    gap = whole(run.parameters)["contact.initial_gap"]
    notes = {"period": period, "outlook": outlook, "impact": impact, "gap": gap}
    return close_up.since(impact, notes)


def cycle(run: Run) -> Figure:
    """Draws displacements, velocities and modes of a `settled_cycle`, as in the paper's Figure 3.

    Example:
        >>> from dth_hammer import figures
        >>> figures.cycle(figures.settled_cycle(until="300 ms")).savefig("cycle.png")
    """
    frame, notes = _settled(run)
    period, outlook = notes["period"], notes["outlook"]
    with styled(7.5, 7.2) as figure:
        grid = figure.subplots(3, 2, sharex="col", height_ratios=(1, 1, 1.15))
        for column, (start, end) in enumerate(((-0.03 * period, 1.03 * period), (0.0, outlook))):
            frame_part = frame[(frame.index >= start - 1e-5) & (frame.index <= end)]
            base = np.interp(0.0, frame.index, frame["tip_depth"])
            _displacements(grid[0, column], frame_part, base, notes["gap"])
            _velocities(grid[1, column], frame_part)
            _modes(grid[2, column], frame_part)
            for letter, axes in zip("abc", grid[:, column], strict=True):
                axes.set_title(f"({letter}{column + 1})", loc="left", pad=3)
                axes.set_xlim(start * 1e3, end * 1e3)
            grid[-1, column].set_xlabel("time since impact (ms)")
        bit = (frame_part["bit_position"] - base) * 1e3
        margin = float(np.ptp(bit))
        grid[0, 1].set_ylim(bit.min() - margin, bit.max() + 0.4 * margin)
        grid[0, 0].set_title("one blow period")
        grid[0, 1].set_title("after the impact")
        for axes, label in zip(
            grid[:, 0],
            ("displacement (mm)", "mean velocity (m/s)", "contact  |  bit/rock mode"),
            strict=True,
        ):
            axes.set_ylabel(label)
        figure.align_ylabels(grid[:, 0])
        handles = [
            Line2D([], [], color=PISTON, label="piston"),
            Line2D([], [], color=BIT, label="bit"),
            Line2D([], [], color=ROCK, dashes=(4, 1.5), label="rock surface"),
        ]
        figure.legend(handles=handles, loc="outside upper center", ncols=3)
    return figure


def _settled(run: Run) -> tuple[pd.DataFrame, Mapping[str, float]]:
    """Returns the frame in SI units and the notes of a run that `settled_cycle` made."""
    if not {"period", "outlook", "gap"} <= run.notes.keys():
        raise DthHammerError(
            "this figure shows one settled cycle: give it what settled_cycle makes"
        )
    return run.convert("si").frame, run.notes


def _displacements(axes: Axes, part: pd.DataFrame, base: float, gap: float) -> None:
    time = part.index * 1e3
    axes.plot(time, (part["piston_position"] - gap - base) * 1e3, color=PISTON)
    axes.plot(time, (part["bit_position"] - base) * 1e3, color=BIT)
    axes.plot(time, (part["tip_depth"] - base) * 1e3, color=ROCK, dashes=(4, 1.5))


def _velocities(axes: Axes, part: pd.DataFrame) -> None:
    axes.axhline(0.0, color="0.75", linewidth=0.6, zorder=0)
    axes.plot(part.index * 1e3, part["piston_velocity"], color=PISTON)
    axes.plot(part.index * 1e3, part["bit_velocity"], color=BIT)


def _modes(axes: Axes, part: pd.DataFrame) -> None:
    lanes = {name: level for level, name in enumerate(MODES)}
    level = part["rock_mode"].astype(str).map(lanes)
    time = part.index * 1e3
    axes.step(time, level, where="post", color=BIT, linewidth=1.0)
    axes.axhline(-0.75, color="0.6", linewidth=0.6)
    closed = np.where(part["contact_closed"], -1.25, -2.25)
    axes.step(time, closed, where="post", color=DARK, linewidth=1.0)
    axes.set_yticks([-2.25, -1.25, *lanes.values()], ["open", "closed", *MODES.values()])
    axes.tick_params(axis="y", length=2)
    axes.set_ylim(-2.75, len(lanes) - 0.5)


def rock_cycles(run: Run) -> Figure:
    """Draws the rock force over the penetration after an impact, as in the bilinear rock law.

    Example:
        >>> from dth_hammer import figures
        >>> figures.rock_cycles(figures.settled_cycle(until="300 ms")).savefig("rock.png")
    """
    frame, notes = _settled(run)
    end = notes["outlook"]
    part = frame[(frame.index >= 0.0) & (frame.index <= end)]
    depth = (part["bit_tip_position"] - part["tip_depth"].iloc[0]).to_numpy() * 1e3
    force = part["rock_force"].to_numpy() * 1e-3
    mode = part["rock_mode"].astype(str).to_numpy()
    with styled(6.0, 4.2) as figure:
        axes = figure.subplots()
        for name in MODES:
            # A line segment has the colour of the mode at its start. A jump of the force occurs
            # where the viscous mode begins or ends, so it has that mode's colour.
            jump = (mode[:-1] == "DissipativeForward") | (mode[1:] == "DissipativeForward")
            owner = np.where(jump, "DissipativeForward", mode[:-1])
            inside = np.append(owner == name, False)
            displayed = inside | np.append(False, inside[:-1])
            x, y = np.where(displayed, depth, np.nan), np.where(displayed, force, np.nan)
            axes.plot(x, y, color=COLOURS[name], label=re.sub(r"\B[A-Z]", r" \g<0>", name).lower())
        axes.set_xlabel("penetration below the hole bottom before the blow (mm)")
        axes.set_ylabel("rock force (kN)")
        axes.set_ylim(bottom=min(0.0, force.min()) - 0.02 * np.ptp(force))
        figure.legend(loc="outside upper center", ncols=len(MODES))
    return figure


def indicator(run: Run) -> Figure:
    """Draws the driving force over the piston's height, and the pressures of air chambers.

    The area enclosed by the force is the work that the drive does in one blow.

    Example:
        >>> from dth_hammer import figures
        >>> figures.indicator(figures.settled_cycle("air_4_inch", "0.3 s")).savefig("air.png")
    """
    frame, notes = _settled(run)
    part = frame[(frame.index >= 0.0) & (frame.index <= notes["period"])]
    position, force = part["relative_position"].to_numpy(), part["applied_drive_force"].to_numpy()
    work = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(position)))
    chambers = [name for name in PRESSURES if name in part and part[name].max() > 0.0]
    panels = 2 if chambers else 1
    with styled(6.0, 3.6 * panels) as figure:
        *above, axes = figure.subplots(panels, sharex=True, squeeze=False)[:, 0]
        for name, upper in itertools.product(chambers, above):
            label, colour = PRESSURES[name]
            upper.plot(-1e3 * position, 1e-5 * part[name], color=colour, label=label)
        for upper in above:
            upper.set_ylabel("pressure (bar)")
            upper.legend()
        # The cycle begins and ends with the piston on the bit, so the curve is closed.
        axes.fill(-1e3 * position, 1e-3 * force, color=PISTON, alpha=0.12, lw=0)
        axes.plot(-1e3 * position, 1e-3 * force, color=PISTON)
        axes.axhline(0.0, color=DARK, lw=0.6)
        axes.set_xlabel("height of the piston above the bit (mm)")
        axes.set_ylabel("driving force, down (kN)")
        axes.set_title(f"{work:.0f} J a blow", loc="left")
    return figure


def at_blows(
    hammer: Hammerlike = None,
    until: float | str | None = None,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
) -> Run:
    """Simulates a hammer and returns its outputs at the instants of the blows, for `ledger`.

    Example:
        >>> from dth_hammer import figures
        >>> print(len(figures.at_blows(until="300 ms").frame), "rows")
        7 rows
    """
    run = simulate(hammer, until, preset=preset, rock=rock, outputs=["blow_count"])
    table = run.blows
    if len(table) < 2:
        raise TooFewBlowsError(f"{len(table)} blows: too few for an energy ledger")
    return simulate(run, times=table["blow_time"].to_numpy())


def ledger(run: Run) -> Figure:
    """Draws the energy of each blow of a run that `at_blows` made: work done, and where it went.

    The last blow is drawn again at the right, enlarged and with its numbers.

    Example:
        >>> from dth_hammer import figures
        >>> figures.ledger(figures.at_blows(until="300 ms")).savefig("ledger.png")
    """
    frame = run.convert("si").frame
    if len(frame) < 2:
        raise TooFewBlowsError(f"{len(frame)} rows: too few for an energy ledger, see at_blows")
    spent = {c: frame[c].diff().to_numpy()[1:] for c in (*WORKS, *SINKS, *STORES)}
    into = {label: spent[c] for c, label in WORKS.items()}
    if frame["energy_retuned"].any():
        into["change of rock"] = frame["energy_retuned"].diff().to_numpy()[1:]
    out = {label: spent[c] for c, label in SINKS.items()}
    out["change of stored energy"] = np.sum([spent[c] for c in STORES], axis=0)
    numbers = np.arange(1, len(frame))
    with styled(8.5, 4.4) as figure:
        every, last = figure.subplots(1, 2, sharey=True, width_ratios=(1.25, 1))
        bounds = [
            _stack(every, numbers - 0.2, into, INTO_COLOURS, 0.36),
            _stack(every, numbers + 0.2, out, OUT_COLOURS, 0.36),
        ]
        # Matplotlib adds no margin beyond stacked bars, so set the limits explicitly.
        low, high = min(b[0] for b in bounds), max(b[1] for b in bounds)
        every.set_ylim(1.05 * low, 1.08 * high)
        every.set_xlabel("blow (left: work done, right: where it went)")
        every.set_ylabel("energy (J)")
        every.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        for side, parts, colours in ((-1, into, INTO_COLOURS), (1, out, OUT_COLOURS)):
            ending = {label: values[-1:] for label, values in parts.items()}
            _stack(last, np.array([0.26 * side]), ending, colours, 0.46)
            _name_parts(last, side, ending, colours, 0.11 * (high - low))
        last.set_xlim(-2.2, 2.9)
        last.set_xticks([])
        last.tick_params(axis="y", length=0)
        last.spines[:].set_visible(False)
        last.set_xlabel(f"blow {numbers[-1]}, enlarged")
        for axes in (every, last):
            axes.axhline(0.0, color=DARK, linewidth=0.6)
    return figure


def _stack(
    axes: Axes, positions: Array, parts: Mapping[str, Any], colours: tuple[str, ...], width: float
) -> tuple[float, float]:
    top, bottom = np.zeros(len(positions)), np.zeros(len(positions))
    for (label, values), colour in zip(parts.items(), colours, strict=False):
        base = np.where(values >= 0, top, bottom)
        axes.bar(positions, values, width=width, bottom=base, color=colour, label=label)
        top, bottom = top + np.maximum(values, 0), bottom + np.minimum(values, 0)
    return float(bottom.min()), float(top.max())


def _name_parts(
    axes: Axes, side: int, parts: Mapping[str, Any], colours: tuple[str, ...], room: float
) -> None:
    """Writes names and numbers of its parts beside a bar, spread out where the parts are thin."""
    values = {label: float(v[0]) for label, v in parts.items()}
    middles, top, bottom = [], 0.0, 0.0
    for value in values.values():
        middles.append((top if value >= 0 else bottom) + 0.5 * value)
        top, bottom = top + max(value, 0.0), bottom + min(value, 0.0)
    label_places = _apart(middles, room, top)
    total = sum(values.values())
    for (label, value), middle, place, colour in zip(
        values.items(), middles, label_places, colours, strict=False
    ):
        axes.annotate(
            f"{label}\n{value:.1f} J, {100 * value / total:.1f} %",
            xy=(0.49 * side, middle),
            xytext=(0.85 * side, place),
            ha="left" if side > 0 else "right",
            va="center",
            fontsize=8.5,
            arrowprops={
                "arrowstyle": "-",
                "color": colour,
                "shrinkA": 2,
                "shrinkB": 0,
                "relpos": (0.0 if side > 0 else 1.0, 0.5),
            },
        )


def _apart(wanted: list[float], room: float, top: float) -> list[float]:
    """Returns positions close to those wanted, at least ``room`` apart and none above ``top``."""
    from_below = sorted(range(len(wanted)), key=wanted.__getitem__)
    places = list(wanted)
    for below, above in itertools.pairwise(from_below):
        places[above] = max(places[above], places[below] + room)
    ceiling = top
    for index in reversed(from_below):
        places[index] = min(places[index], ceiling)
        ceiling = places[index] - room
    return places


def convergence(run: Run) -> Figure:
    """Draws the relative difference of each blow from the last one while the hammer settles.

    Example:
        >>> from dth_hammer import figures, simulate
        >>> figures.convergence(simulate(until="400 ms")).savefig("convergence.png")
    """
    table = run.convert("si").blows
    if len(table) < 3:
        raise TooFewBlowsError(f"{len(table)} blows: too few to see them converge")
    with styled(6.0, 3.8) as figure:
        axes = figure.subplots()
        series = (
            ("blow_period", "period", PISTON, "o"),
            ("blow_speed", "impact speed", BIT, "s"),
            ("rop", "rate of penetration", ROCK, "^"),
        )
        for column, label, colour, marker in series:
            values = table[column][1:]
            distance = (values / values.iloc[-1] - 1.0).abs()[:-1]
            axes.semilogy(distance.index, distance, color=colour, marker=marker, ms=4, label=label)
        axes.set_xlabel("blow")
        axes.set_ylabel("relative distance from the last blow")
        axes.grid(color="0.9", linewidth=0.6)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        figure.legend(loc="outside upper center", ncols=3)
    return figure


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
    places = _apart(wanted_places.tolist(), 0.03 * span, time[-1] - 0.016 * span)
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
