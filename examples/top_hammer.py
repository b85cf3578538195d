"""A drifter on one to eight rods, tight and loose: the energy that reaches the rock, and the pull.

    python examples/top_hammer.py --out top_hammer.png

A line shows the first wave of a blow alone, which the couplings break up: Lundberg's model of
extension rods (1987) with a piston of the rods' impedance, in closed form.
"""

from __future__ import annotations

import argparse
from math import comb
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import PRESETS, steady, waves
from dth_hammer.figures import BIT, PISTON
from dth_hammer.figures.style import styled
from dth_hammer.scene.variables import numbers, whole
from matplotlib.figure import Figure

PRESET = "top_hammer"
RODS = (1, 2, 3, 4, 6, 8)
#: Standard error of a mean rate, over the rate.
ERROR = 0.03
#: A loose joint: faces as stiff as 0.1 m of the rod, half a millimetre of play.
LOOSE = {"drill.joint.stiffness": 3e9, "drill.joint.slack": 5e-4}


def first_wave(rods: int) -> float:
    """Returns the share of the piston's energy that the first wave has below so many couplings.

    A coupling lets ``tau = 4 r / (1 + r)^2`` through at once, and ``1 - tau`` of what runs to and
    fro in it each time; a piston of the rods' impedance sends a rectangle twice its length.
    """
    hammer = whole(numbers(PRESET, {}))
    ratio = hammer["drill.coupling.area"] / hammer["drill.rod.area"]
    back = ((ratio - 1.0) / (ratio + 1.0)) ** 2
    late = np.arange(400)
    parts = np.array([comb(rods + int(k) - 1, int(k)) * back**k for k in late]) * (1 - back) ** rods
    # The share of its length by which two of the rectangles overlap.
    step = hammer["drill.coupling.length"] / hammer["piston.segment[1].length"]
    overlap = np.maximum(1.0 - step * np.abs(late[:, None] - late), 0.0)
    return float(parts @ overlap @ parts)


def string(rods: int, joint: dict[str, float] | None = None) -> dict[str, float]:
    """Returns the parameters of a string of so many rods, on a mesh for the forces in it."""
    # Finer than the preset's, which is for rates.
    return {"drill.rods": rods, "mesh.degree": 7, "bit.elements": 18 * rods + 6} | (joint or {})


def pull(parameters: dict[str, float]) -> float:
    """Returns the largest pull in a string after one blow, N."""
    after = waves(parameters, 0.5, preset=PRESET, times=np.arange(0.0, 0.018, 5e-5))
    # The rods are the thinnest part, so the largest stress is in one of them.
    return whole(numbers(PRESET, {}))["drill.rod.area"] * float(after.bit.stress.max())


def row(rods: int, joint: dict[str, float] | None = None, error: float = ERROR) -> dict[str, float]:
    """Returns means over blows with so many rods, and the largest pull after one blow (N)."""
    parameters = string(rods, joint)
    found = steady(parameters, preset=PRESET, error=error)
    mean = found.mean
    taken = mean["energy_rock_dissipated"] + mean["energy_viscous"]
    return {
        "rods": rods,
        "rate": mean["rop"],
        "error": found.error["rop"],
        "blows": mean["blow_frequency"],
        "share": taken / mean["energy_drive"],
        "first wave": first_wave(rods),
        "pull": pull(parameters),
    }


def run(rods: tuple[int, ...] = RODS, error: float = ERROR) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Returns a row for each number of rods, with tight and with loose joints."""
    tight, loose = (
        pd.DataFrame([row(count, joint, error) for count in rods]) for joint in (None, LOOSE)
    )
    return tight, loose


def preload(torque: float) -> float:
    """Returns a joint's axial force (N) for a torque (N m): ``T / (0.2 d)``, with d 45 mm."""
    return torque / (0.2 * 45e-3)


def draw(tight: pd.DataFrame, loose: pd.DataFrame) -> Figure:
    """Draws the rock's share of the drive's energy, and the first wave's, over the rods."""
    with styled(6.0, 3.6) as figure:
        axes = figure.subplots()
        for table, style, label in (
            (tight, {"fmt": "o-", "color": PISTON}, "taken by the rock"),
            (loose, {"fmt": "^:", "color": PISTON, "mfc": "white"}, "with 0.5 mm of slack a joint"),
        ):
            share = 100 * table["share"]
            error = 2 * share * table["error"] / table["rate"]
            axes.errorbar(table["rods"], share, error, ms=4, label=label, **style)
        rods, first = tight["rods"], 100 * tight["first wave"]
        axes.plot(rods, first, "s--", ms=3, color=BIT, label="first wave below all couplings")
        axes.set_xlabel("rods of 3.66 m")
        axes.set_ylabel("part of a blow's energy (%)")
        axes.set_ylim(0.0, 105.0)
        axes.grid(color="0.92", linewidth=0.6)
        figure.legend(loc="outside upper center", ncols=2)
    return figure


def main() -> None:
    """Runs, prints and draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("top_hammer.png"))
    options = parser.parse_args()
    print(PRESETS[PRESET].description)
    tight, loose = run()
    for name, table in (("joints screwed tight", tight), ("joints loose by 0.5 mm", loose)):
        print(name, table.to_string(index=False), sep="\n")
    print(f"a joint tightened with 1 kN m holds {preload(1e3) / 1e3:.0f} kN")
    draw(tight, loose).savefig(options.out, dpi=160)


if __name__ == "__main__":
    main()
