"""Figures of the settled cycle, and of the transient before it."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from ..errors import DthHammerError, TooFewBlowsError
from ..frames import np, pd
from ..scene.hammers import Hammerlike, Rocklike
from ..scene.variables import whole
from ..simulation.run import Run, simulate
from .marks import BIT, COLOURS, DARK, MODES, PISTON, PRESSURES, ROCK
from .style import styled


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
