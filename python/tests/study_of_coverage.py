"""How often the 95 % intervals of `calibrate` hold the truth: run it, it takes minutes.

    python python/tests/study_of_coverage.py coarse 100

Each draw has a hammer of its own, whose parameters are anywhere within 30 %, and measurements with
an error of 1 % each; `calibrate` starts at the hammer in the middle and knows nothing of another
draw.
"""

from __future__ import annotations

import sys
import warnings

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


def pulls(hammer: str, draws: int, free: tuple[str, ...] = FREE, first: int = 0) -> pd.DataFrame:
    """A row a draw: how far each estimate is off, over its standard error."""
    parameters, preset = HAMMERS[hammer]
    middle = whole(numbers(preset, parameters))
    rows = []
    for draw in range(first, first + draws):
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
        rows.append({**off, "chi_square": found.chi_square, "evaluations": found.evaluations})
    return pd.DataFrame(rows)


def covered(table: pd.DataFrame, free: tuple[str, ...] = FREE) -> pd.Series:
    """Part of the draws in which an interval of 1.96 standard errors holds the truth."""
    return (table[[*free]].abs() < 1.96).mean()


if __name__ == "__main__":
    found = pulls(sys.argv[1], int(sys.argv[2]))
    print(found.describe())
    print(covered(found))
