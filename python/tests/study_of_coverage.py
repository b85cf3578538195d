"""How often the 95 % intervals of `calibrate` hold the truth: run it, it takes minutes.

    python python/tests/study_of_coverage.py coarse=100 rigid=100 reference=40

Each draw has a hammer of its own, whose parameters are anywhere within 30 %, and measurements with
an error of 1 % each; `calibrate` starts at the hammer in the middle and knows nothing of another
draw. Draws are kept in reports/coverage.csv, so that a second call adds what is missing;
reports/coverage.md is written from it.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import HammerWarning, calibrate, steady
from dth_hammer.variables import numbers, whole

#: Parameters of each hammer, preset, and the error of a mean.
HAMMERS = {
    "coarse": ({"piston.elements": 4, "bit.elements": 4, "contact.stiffness": 2e10}, None),
    "rigid": ({"fidelity": "Rigid"}, None),
    "reference": ({}, "reference"),
    "granite": ({}, "granite"),
    "hammer_3_inch": ({}, "hammer_3_inch"),
}
FREE = ("rock.stiffness", "drive.amplitude")
MEASURED = ("rop", "blow_frequency", "rebound_ratio", "blow_energy")
ERROR = 0.01
REPORTS = Path(__file__).parents[2] / "reports"


def pulls(hammer: str, draws: Iterable[int], free: tuple[str, ...] = FREE) -> pd.DataFrame:
    """A row a draw: how far each estimate is off, over its standard error."""
    parameters, preset = HAMMERS[hammer]
    middle = whole(numbers(preset, parameters))
    rows = []
    for draw in draws:
        noise = np.random.default_rng([17, draw])
        truth = {name: middle[name] * np.exp(noise.uniform(-0.3, 0.3)) for name in free}
        means = steady(parameters | truth, preset=preset, error=0.002).mean
        measured = {
            name: (means[name] * (1.0 + ERROR * noise.normal()), ERROR * means[name])
            for name in MEASURED
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", HammerWarning)
            found = calibrate(measured, free, parameters, preset=preset, seed=draw)
        off = (found.parameters - pd.Series(truth)) / found.errors
        wide = (found.errors / found.parameters).add_prefix("error of ")
        counts = {"chi_square": found.chi_square, "evaluations": found.evaluations}
        rows.append({"hammer": hammer, "draw": draw, **off, **wide, **counts})
    return pd.DataFrame(rows)


def covered(table: pd.DataFrame, free: tuple[str, ...] = FREE) -> pd.Series:
    """Part of the draws in which an interval of 1.96 standard errors holds the truth."""
    return (table[[*free]].abs() < 1.96).mean()


def report(table: pd.DataFrame) -> str:
    """The table of the guide."""
    lines = ["| hammer | draws | " + " | ".join(f"`{n}` held | its error" for n in FREE) + " |"]
    lines += ["|---" * (2 + 2 * len(FREE)) + "|"]
    for hammer, part in table.groupby("hammer", sort=False):
        cells = [f"{covered(part)[n]:.0%} | {part[f'error of {n}'].median():.1%}" for n in FREE]
        lines.append(f"| {hammer} | {len(part)} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main(wanted: list[str]) -> None:
    """Adds what is missing, a draw at a time, and writes the report."""
    rows = REPORTS / "coverage.csv"
    table = pd.read_csv(rows) if rows.exists() else pd.DataFrame(columns=["hammer", "draw"])
    for hammer, count in (word.split("=") for word in wanted):
        known = {*table.loc[table["hammer"] == hammer, "draw"]}
        for draw in (k for k in range(int(count)) if k not in known):
            table = pd.concat([table, pulls(hammer, [draw])], ignore_index=True)
            table.to_csv(rows, index=False, float_format="%.4g")
    (REPORTS / "coverage.md").write_text(report(table), encoding="utf-8")
    print(report(table), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
