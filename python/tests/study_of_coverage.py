"""How often the 95 % intervals of `calibrate` hold the truth: run it, it takes minutes.

    python python/tests/study_of_coverage.py rigid=20 "light and viscous=20"

Each draw has a hammer of its own, whose parameters are anywhere within 30 %, and measurements with
an error of 1 % each; `calibrate` starts at the hammer in the middle and knows nothing of another
draw. Of a ridge only the rate is measured: that fixes the specific energy times the square of the
hole's diameter, and neither of them alone. Without arguments forty hammers are drawn. Draws are
kept in reports/coverage.csv, each with the engine that made it, so that a second call adds what is
missing; reports/coverage.md is written from it.
"""

import subprocess
import sys
import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import HammerWarning, calibrate, steady
from dth_hammer.scene.variables import numbers, whole

ROCK = ("rock.stiffness", "rock.unloading_ratio")
BOTH = ("rock.stiffness", "drive.amplitude")
RIGID = {"fidelity": "Rigid"}
COARSE = {"piston.elements": 4, "bit.elements": 4, "contact.stiffness": 2e10}
#: Parameters of each hammer, its preset, and the parameters to estimate.
HAMMERS: dict[str, tuple[dict[str, float | str], str | None, tuple[str, ...]]] = {
    "coarse": (COARSE, None, BOTH),
    "rigid": (RIGID, None, BOTH),
    "light and viscous": (RIGID | {"piston.length": 0.1, "rock.viscosity": 1e4}, None, ROCK),
    "casing": (RIGID | {"casing.mass": 60.0}, None, BOTH),
    "reference": ({}, "reference", BOTH),
    "air": (RIGID, "air_4_inch", ("rock.stiffness", "air.supply_area")),
    "ridge": (RIGID, None, ("rock.specific_energy", "hole.diameter")),
}
#: Number of draws of each, unless the command line has others.
DRAWS = ("ridge=10", "rigid=10", "casing=6", "light and viscous=8", "coarse=6")
#: The measurement of a ridge, and the powers of its parameters in the product that it determines.
RATE, POWERS = ("rop",), {"rock.specific_energy": 1.0, "hole.diameter": 2.0}
MEASURED = ("tip_rate", "blow_frequency", "rebound_ratio", "blow_energy")
#: Relative error of a measured mean.
ERROR = 0.01
REPORTS = Path(__file__).parents[2] / "reports"


def intervals(hammer: str, draws: Iterable[int]) -> pd.DataFrame:
    """Returns a row per draw and parameter: 95 % interval over hidden value, standard error."""
    parameters, preset, free = HAMMERS[hammer]
    middle = whole(numbers(preset, parameters))
    rows = []
    for draw in draws:
        noise = np.random.default_rng([17, draw])
        truth = {name: middle[name] * np.exp(noise.uniform(-0.3, 0.3)) for name in free}
        means = steady(parameters | truth, preset=preset, error=0.002).mean
        measured = {
            name: (means[name] * (1.0 + ERROR * noise.normal()), ERROR * means[name])
            for name in (RATE if hammer == "ridge" else MEASURED)
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", HammerWarning)
            found = calibrate(parameters, measured, free, preset=preset, seed=draw)
        logs = np.log(found.samples / pd.Series(truth))
        if hammer == "ridge":
            logs["rock.specific_energy hole.diameter^2"] = logs[[*POWERS]] @ [*POWERS.values()]
        for name, values in logs.items():
            low, high = np.exp(values.quantile([0.025, 0.975]))
            row = {"hammer": hammer, "draw": draw, "parameter": name, "low": low, "high": high}
            row |= {"error": values.std(), "modes": len(found.modes)}
            rows.append(row | {"evaluations": found.evaluations})
    return pd.DataFrame(rows)


def held(table: pd.DataFrame) -> pd.Series:
    """Returns whether each interval contains the hidden value."""
    return (table["low"] <= 1.0) & (table["high"] >= 1.0)


def report(table: pd.DataFrame) -> str:
    """Returns the table of the guide, under its own heading."""
    lines = ["# How often intervals of `calibrate` hold", ""]
    lines += ["| hammer | parameter | intervals that hold | median error | hammers simulated |"]
    lines += ["|---" * 5 + "|"]
    for (hammer, name), part in table.groupby(["hammer", "parameter"], sort=False):
        counts = f"{held(part).sum()} of {len(part)} | {part['error'].median():.1%}"
        lines.append(f"| {hammer} | `{name}` | {counts} | {part['evaluations'].median():.0f} |")
    return "\n".join(lines) + "\n"


def main(wanted: list[str]) -> None:
    """Adds the missing draws of this engine, one at a time, and writes the report."""
    rows = REPORTS / "coverage.csv"
    command = ["git", "rev-parse", "HEAD:hammer/src"]
    engine = subprocess.run(
        command, cwd=REPORTS, check=True, capture_output=True, text=True
    ).stdout[:12]
    table = pd.DataFrame(columns=["engine", "hammer", "draw"])
    if rows.exists():
        # A draw of another engine says nothing about this one.
        table = pd.concat([table, pd.read_csv(rows).query("engine == @engine")], ignore_index=True)
    for hammer, count in (word.split("=") for word in wanted):
        known = {*table.loc[table["hammer"] == hammer, "draw"]}
        for draw in (k for k in range(int(count)) if k not in known):
            found = intervals(hammer, [draw]).assign(engine=engine)
            table = pd.concat([table, found], ignore_index=True)
            table.to_csv(rows, index=False, float_format="%.4g")
    (REPORTS / "coverage.md").write_text(report(table), encoding="utf-8")
    print(report(table), end="")


if __name__ == "__main__":
    main(sys.argv[1:] or [*DRAWS])
