"""A hammer that water drives, in a model of its own: both pressures and the piston's motion.

    python examples/coupled.py --out water.png                # a table of blows, a figure

The model is `dth_hammer.models.hydraulic`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import pandas as pd
from dth_hammer import Coupling, Hammer
from dth_hammer.figures import BIT, DARK, PISTON
from dth_hammer.figures.style import styled
from dth_hammer.models.hydraulic import WaterDrive
from matplotlib.figure import Figure

SAMPLING = 5e-4  # s: how often pressures are noted, finer than a blow
WINDOW = 0.15  # s: the end of a run that is drawn
NAMES = ["relative_position", "blow_count", "blow_time", "blow_period", "blow_speed", "rop"]


def run(until: float, step: float = 2e-5) -> pd.DataFrame:
    """The coupled hammer's blows, and both pressures every half millisecond."""
    drive, rows = WaterDrive(), []
    with Hammer(drive.water.parameters()) as hammer:
        coupling = Coupling(hammer, drive, step)
        while hammer.time < until:
            coupling.advance(min(until, hammer.time + SAMPLING))
            rows.append({"time": hammer.time} | drive.outputs() | hammer.get(NAMES))
    return pd.DataFrame(rows).set_index("time")


def draw(frame: pd.DataFrame) -> Figure:
    """Both pressures and the piston's position over the last blows."""
    part = frame[frame.index > frame.index[-1] - WINDOW]
    with styled(7.0, 4.5) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        for name, colour, label in (
            ("drive_pressure", PISTON, "drive"),
            ("return_pressure", BIT, "return"),
        ):
            upper.plot(part.index, part[name] * 1e-5, color=colour, label=label)
        upper.set_ylabel("pressure (bar)")
        figure.legend(loc="outside upper center", ncols=2)
        lower.plot(part.index, part["relative_position"] * 1e3, color=DARK)
        lower.set_ylabel("piston over bit (mm)")
        lower.set_xlabel("time (s)")
    return figure


def main() -> None:
    """Runs it, prints its blows, draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--until", type=float, default=0.5, help="seconds")
    parser.add_argument("--out", type=Path, default=Path("coupled.png"), help="figure to write")
    options = parser.parse_args()
    frame = run(options.until)
    print(frame.loc[frame["blow_count"].diff() > 0, NAMES[1:]].to_string(index=False))
    draw(frame).savefig(options.out)


if __name__ == "__main__":
    main()
