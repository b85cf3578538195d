"""A pneumatic hammer in piecewise form: `drive.source = Chambers` beside the gas model.

    python examples/chambers.py          # a table, and both indicator diagrams as a figure

The hammer coupled with `dth_hammer.models.pneumatic` runs until it repeats itself. The pressures
of its last cycle are fitted, chamber by chamber, by straight lines in time that begin where the
piston passes a port. With these numbers the FMU runs alone, without a partner or a communication
step.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import Coupling, Hammer
from dth_hammer.figures import BIT, DARK, PISTON
from dth_hammer.models.pneumatic import Air, PneumaticDrive
from dth_hammer.style import styled
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]
SAMPLING = 5e-5  # s: how often pressures are noted
STEP = 2e-5  # s: of the coupling
CHAMBERS = ("drive", "return")
PORTS = ("supply", "exhaust")
#: +1 if the port is open where the piston is below it, by chamber and port.
SIDES = {"drive": (-1.0, 1.0), "return": (1.0, -1.0)}
READ = ["relative_position", "blow_time", "blow_period", "blow_speed", "blow_energy", "rop"]
#: Pressures are fitted in units of a bar, times in milliseconds.
BAR, MS = 1e5, 1e-3
#: Lowest level, bar.
EMPTY = 0.1
#: Weight of a cycle's work and impulse over that of its pressures.
SURE = 1.0


def coupled(air: Air, until: float) -> pd.DataFrame:
    """The gas model and the FMU step by step: pressures, position and blows."""
    drive, rows = PneumaticDrive(air), []
    with Hammer(air.parameters()) as hammer:
        drive.start(hammer["relative_position"])
        coupling = Coupling(hammer, drive, STEP)
        for k in range(1, round(until / SAMPLING) + 1):
            coupling.advance(k * SAMPLING)
            rows.append({"time": hammer.time} | drive.outputs() | hammer.get(READ))
    return pd.DataFrame(rows).set_index("time")


def alone(chambers: dict[str, float | str], until: float) -> pd.DataFrame:
    """The FMU with chambers of its own, looked at as often."""
    names = {f"{chamber}_chamber_pressure": f"{chamber}_pressure" for chamber in CHAMBERS}
    rows = []
    with Hammer(chambers) as hammer:
        for k in range(1, round(until / SAMPLING) + 1):
            hammer.step(k * SAMPLING - hammer.time)
            rows.append({"time": hammer.time} | hammer.get([*READ, *names]))
    return pd.DataFrame(rows).set_index("time").rename(columns=names)


def last_cycle(frame: pd.DataFrame) -> pd.DataFrame:
    """From the last blow but one to the last."""
    end, period = frame[["blow_time", "blow_period"]].iloc[-1]
    cycle: pd.DataFrame = frame[(frame.index > end - period) & (frame.index <= end)]
    return cycle


def positions(air: Air, chamber: str) -> tuple[float, float]:
    """Of supply and exhaust, m: where half of the port's height is open."""
    edges = (getattr(air, f"{chamber}_supply"), getattr(air, f"{chamber}_exhaust"))
    half = air.port_height / 2
    supply, exhaust = (x + side * half for x, side in zip(edges, SIDES[chamber], strict=True))
    return supply, exhaust


def turns(cycle: pd.DataFrame, air: Air, chamber: str) -> list[tuple[float, str]]:
    """Where the ports turn: times after the cycle's start, s, and what each does, in order."""
    time, x = cycle.index.to_numpy(), cycle["relative_position"].to_numpy()
    found = []
    for port, side, place in zip(PORTS, SIDES[chamber], positions(air, chamber), strict=True):
        for k in np.flatnonzero(np.diff(np.sign(x - place))):
            share = (place - x[k]) / (x[k + 1] - x[k])
            opens = (x[k + 1] > x[k]) == (side > 0)
            at = time[k] + share * (time[k + 1] - time[k]) - time[0]
            found.append((at, f"{port}.{'open' if opens else 'shut'}"))
    return sorted(found)


def line(time: Array, order: list[tuple[float, str]], numbers: Array) -> Array:
    """The pressure of a chamber over a cycle that repeats itself, Pa."""
    first, second = np.split(numbers, 2)
    levels, spans = first * BAR, second * MS
    starts = np.array([at for at, _ in order])
    period = time[-1] + time[1] - time[0]
    shares = np.minimum(np.diff([*starts, starts[0] + period]) / np.maximum(spans, 1e-9), 1.0)
    pressure, before = levels[-1], np.empty_like(levels)
    for _ in range(2):  # The first time round finds what the cycle begins with.
        for k, level in enumerate(levels):
            before[k] = pressure
            pressure += (level - pressure) * shares[k]
    # Before the first port turns, the last of the cycle before goes on.
    at = np.searchsorted(starts, time, side="right") - 1
    since = time - starts[at] + period * (at < 0)
    part: Array = np.minimum(since / np.maximum(spans[at], 1e-9), 1.0)
    pressures: Array = before[at] + (levels - before)[at] * part
    return pressures


def fitted(cycle: pd.DataFrame, air: Air) -> dict[str, float | str]:
    """The FMU's parameters for chambers like those of the gas model."""
    found: dict[str, float | str] = air.parameters() | {"drive.source": "Chambers"}
    time = cycle.index.to_numpy() - cycle.index[0]
    for chamber in CHAMBERS:
        wanted = cycle[f"{chamber}_pressure"].to_numpy()
        order = turns(cycle, air, chamber)
        ends = [np.interp(at, time, wanted) for at, _ in [*order[1:], order[0]]]
        gaps = np.diff([*(at for at, _ in order), order[0][0] + time[-1]])
        first = np.concatenate([np.array(ends) / BAR, gaps / MS])
        speed = np.gradient(cycle["relative_position"].to_numpy(), time)

        def residuals(
            numbers: Array, o: list[tuple[float, str]] = order, w: Array = wanted, v: Array = speed
        ) -> Array:
            off = (line(time, o, numbers) - w) / BAR
            # Work and impulse of the cycle are to be those of the gas.
            exact = [SURE * np.mean(off * v) / np.abs(v).mean(), SURE * off.mean()]
            return np.concatenate([off / np.sqrt(len(off)), exact])

        # A level that is never reached tends to none, but a chamber is not emptied.
        least = np.repeat([EMPTY, 0.0], len(order))
        fit = least_squares(residuals, first, bounds=(least, np.inf))
        for (_, turn), level, span in zip(order, *np.split(fit.x, 2), strict=True):
            found[f"chambers.{chamber}.{turn}_pressure"] = float(level * BAR)
            found[f"chambers.{chamber}.{turn}_time"] = float(span * MS)
        for port, place in zip(PORTS, positions(air, chamber), strict=True):
            found[f"chambers.{chamber}.{port}.position"] = place
    return found


def table(gas: pd.DataFrame, chambers: pd.DataFrame) -> pd.DataFrame:
    """Both, by what a driller reads."""
    rows = {}
    for name, frame in (("gas model", gas), ("chambers", chambers)):
        last = frame.iloc[-1]
        rows[name] = {
            "frequency (Hz)": 1.0 / last["blow_period"],
            "impact speed (m/s)": last["blow_speed"],
            "energy per blow (J)": last["blow_energy"],
            "rop (m/h)": 3600 * last["rop"],
        }
    both = pd.DataFrame(rows).T
    both.loc["difference (%)"] = 100.0 * (both.iloc[1] / both.iloc[0] - 1.0)
    return both


def draw(gas: pd.DataFrame, chambers: pd.DataFrame) -> Figure:
    """Pressure over the piston's position, one cycle of each, and over time."""
    with styled(8.0, 4.2) as figure:
        left, right = figure.subplots(1, 2, sharey=True)
        for frame, style, label in ((gas, "--", "gas model"), (chambers, "-", "chambers")):
            cycle = last_cycle(frame)
            time = (cycle.index - cycle.index[0]) * 1e3
            for chamber, colour in zip(CHAMBERS, (PISTON, BIT), strict=True):
                pressure = cycle[f"{chamber}_pressure"] / BAR
                left.plot(cycle["relative_position"] * 1e3, pressure, style, color=colour)
                right.plot(time, pressure, style, color=colour)
            left.plot([], [], style, color=DARK, label=label)
        for colour, chamber in ((PISTON, "drive chamber"), (BIT, "return chamber")):
            left.plot([], [], color=colour, label=chamber)
        left.set(xlabel="piston over bit (mm)", ylabel="pressure (bar)")
        right.set(xlabel="time after the blow (ms)")
        figure.legend(loc="outside upper center", ncols=4)
    return figure


def main() -> None:
    """Fits, runs both, prints the table, draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--until", type=float, default=0.6, help="seconds of each run")
    parser.add_argument("--out", type=Path, default=Path("chambers.png"), help="figure to write")
    options = parser.parse_args()
    air = Air()
    gas = coupled(air, options.until)
    numbers = fitted(last_cycle(gas), air)
    for name, value in numbers.items():
        print(f"{name:<40} {value if isinstance(value, str) else format(value, '.4g')}")
    chambers = alone(numbers, options.until)
    print(table(gas, chambers).round(3).to_string())
    draw(gas, chambers).savefig(options.out)


if __name__ == "__main__":
    main()
