"""A compressor and a hose supply the hammer: what a compressor that is too small costs.

    python examples/compressor.py --out compressor.png

fmpy steps the hammer's FMU; the compressor is `dth_hammer.models.compressor`. Each millisecond the
hammer gets the pressure at the hose's end, and the compressor gets the mass of air that the hammer
has taken.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from pathlib import Path

import pandas as pd
from dth_hammer.figures import BIT, DARK, PISTON
from dth_hammer.figures.style import styled
from dth_hammer.fmu import configure
from dth_hammer.models.compressor import Compressor, Supply
from fmpy.fmi2 import FMU2Slave
from matplotlib.figure import Figure
from valve_master import made

PRESET = "air_4_inch"
STEP = 1e-3  # s
READ = ("air_mass", "air_flow", "blow_count", "blow_energy", "blow_period", "rop")
#: Capacities to compare, m3/min of free air: one that is enough, and two that are not.
CAPACITIES = (20.0, 16.0, 12.0)


def run(compressor: Compressor, until: float, step: float = STEP) -> pd.DataFrame:
    """Returns a row per step: the hammer's outputs, its supply pressure, the air in the hose."""
    supply = Supply(compressor)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "hammer.fmu")
        configure(None, file, preset=PRESET)
        hammer, reference = made(FMU2Slave, file)
    asked = [reference[name] for name in READ]
    hammer.instantiate()
    hammer.setupExperiment(startTime=0.0)
    hammer.enterInitializationMode()
    hammer.setReal([reference["supply_pressure"]], [supply.pressure])
    hammer.exitInitializationMode()
    rows = []
    for k in range(round(until / step)):
        pressure = supply.pressure
        hammer.setReal([reference["supply_pressure"]], [pressure])
        hammer.doStep(k * step, step)
        answers = dict(zip(READ, hammer.getReal(asked), strict=True))
        supply.advance(step, answers["air_mass"])
        held = {"delivered": supply.delivered, "held": supply.held}
        rows.append({"time": (k + 1) * step, "supply_pressure": pressure, **answers, **held})
    hammer.terminate()
    hammer.freeInstance()
    shutil.rmtree(hammer.unzipDirectory, ignore_errors=True)
    return pd.DataFrame(rows).set_index("time")


def table(runs: dict[float, pd.DataFrame]) -> pd.DataFrame:
    """Returns the last blow for each capacity, in field units."""
    rows = [
        {
            "compressor (m3/min)": capacity,
            "pressure (bar)": 1e-5 * last["supply_pressure"],
            "air taken (m3/min)": 60.0 * last["air_flow"],
            "blow energy (J)": last["blow_energy"],
            "blows (1/s)": 1.0 / last["blow_period"],
            "rate (m/h)": 3600.0 * last["rop"],
        }
        for capacity, last in ((c, frame.iloc[-1]) for c, frame in runs.items())
    ]
    return pd.DataFrame(rows)


def draw(runs: dict[float, pd.DataFrame]) -> Figure:
    """Draws the pressure at the hammer and the rate of penetration over time for each capacity."""
    with styled(7.0, 4.5) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        for (capacity, frame), colour in zip(runs.items(), (DARK, PISTON, BIT), strict=False):
            upper.plot(
                frame.index,
                1e-5 * frame["supply_pressure"],
                color=colour,
                label=f"{capacity:g} m³/min",
            )
            blown = frame[frame["blow_count"] > 1]
            lower.plot(blown.index, 3600.0 * blown["rop"], color=colour)
        upper.set_ylabel("pressure at the hammer (bar)")
        lower.set(xlabel="time (s)", ylabel="rate of penetration (m/h)", ylim=(0.0, None))
        figure.legend(loc="outside upper center", ncols=3)
    return figure


def main() -> None:
    """Runs, prints and draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--until", type=float, default=4.0, help="seconds")
    parser.add_argument("--out", type=Path, default=Path("compressor.png"), help="figure to write")
    options = parser.parse_args()
    runs = {c: run(Compressor(capacity=c / 60.0), options.until) for c in CAPACITIES}
    print(table(runs).round(2).to_string(index=False))
    draw(runs).savefig(options.out)


if __name__ == "__main__":
    main()
