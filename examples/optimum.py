"""Three practical questions, answered by `optimise` and compared with a grid of hammers.

    python examples/optimum.py --out optimum.png           # minutes: three grids of hammers
    python examples/optimum.py stroke --out stroke.png     # bore and stroke alone

* ports: where should an air hammer's drive chamber close its supply and open its exhaust, for a
  given compressor?
* stroke: which bore and stroke are best at a fixed pressure, with a limit on the blow's energy?
* feed: what is the least feed at which a hammer in its casing drills at a given rate?

Both the optimum and each point of a grid are means over hammers that differ by up to one per cent.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import Steady, optimise, steady
from dth_hammer.figures import PISTON
from dth_hammer.figures.style import styled
from dth_hammer.study.optimisation import Optimum
from matplotlib.axes import Axes
from matplotlib.figure import Figure

#: Of each free number, a part of it, and the middles of its three parts.
TOLERANCE = 0.01
PARTS = (-2.0 / 3.0, 0.0, 2.0 / 3.0)
#: Standard error of a rate, over it.
ERROR = 0.01
HOUR, MINUTE = 3600.0, 60.0
#: Labels of the free numbers on an axis, with the factors from SI units.
LABELS = {
    "air.drive.supply": ("supply closes (mm above the bit)", -1e3),
    "air.drive.exhaust": ("exhaust opens (mm above the bit)", -1e3),
    "bore": ("bore (mm)", 1e3),
    "stroke": ("stroke (mm)", 1e3),
    "feed_force": ("feed force (kN)", 1e-3),
}
#: Settings for a quick example.
COARSE: Mapping[str, float | str] = {
    "piston.elements": 4,
    "bit.elements": 4,
    "contact.stiffness": 2e10,
}
RIGID: Mapping[str, float | str] = {"fidelity": "Rigid"}
#: A strong drive in a casing, which it lifts off with too little feed.
STRONG: Mapping[str, float | str] = {
    **RIGID,
    "casing.mass": 40.0,
    "rock.stiffness": 3e8,
    "drive.amplitude": 3e3,
    "drive.stroke": 0.08,
}


def bore(chosen: Mapping[str, float]) -> dict[str, float]:
    """Returns the parameters of a drive at 20 bar."""
    force = 20e5 * 0.25 * np.pi * chosen["bore"] ** 2
    return {"drive.amplitude": force, "drive.stroke": chosen["stroke"]}


def feed(found: Steady) -> float:
    """Returns the feed force, N."""
    return found["feed_force"]


@dataclass(frozen=True)
class Case:
    """A design to find."""

    title: str
    free: Mapping[str, tuple[float, float]]
    limits: Mapping[str, tuple[float | None, float | None]]
    others: Mapping[str, float | str] = field(default_factory=dict)
    preset: str | None = None
    design: Callable[[Mapping[str, float]], Mapping[str, float]] = dict
    goal: str | Callable[[Steady], float] = "rop"
    least: bool = False

    def found(self) -> Optimum:
        """Returns the optimum that `optimise` finds."""
        return optimise(
            self.others,
            self.goal,
            self.free,
            least=self.least,
            limits=self.limits,
            preset=self.preset,
            design=self.design,
            tolerance=TOLERANCE,
            error=ERROR,
        )

    def brute(self, count: int) -> pd.DataFrame:
        """Returns mean rates over the tolerance on a grid, and which of them satisfy the limits."""
        axes = [np.linspace(low, high, count) for low, high in self.free.values()]
        points = np.array([*itertools.product(*axes)])
        off = 1.0 + TOLERANCE * np.array([*itertools.product(PARTS, repeat=len(axes))])
        near = (points[:, None] * off).reshape(-1, len(axes))
        designs = [self.design(dict(zip(self.free, row, strict=True))) for row in near.tolist()]
        table = steady([{**self.others, **d} for d in designs], preset=self.preset, error=ERROR)
        read = [*dict.fromkeys(["rop", *self.limits])]
        means = table[read].to_numpy(float).reshape(len(points), len(off), -1).mean(axis=1)
        grid = pd.DataFrame(means, columns=pd.Index(read))
        sides = [
            grid[n].between(low or 0.0, high or np.inf) for n, (low, high) in self.limits.items()
        ]
        return grid.assign(
            within=np.all(sides, axis=0), **dict(zip(self.free, points.T, strict=True))
        )


CASES = {
    "ports": Case(
        "drive chamber's ports, air up to 18.5 m³/min",
        {"air.drive.supply": (-0.05, -0.038), "air.drive.exhaust": (-0.034, -0.02)},
        {"air_flow": (None, 18.5 / MINUTE)},
        RIGID,
        "air_4_inch",
    ),
    "stroke": Case(
        "drive at 20 bar, blows up to 240 J",
        {"bore": (0.028, 0.04), "stroke": (0.03, 0.06)},
        {"blow_energy": (None, 240.0)},
        COARSE,
        design=bore,
    ),
    "feed": Case(
        "casing of 40 kg, least feed for 27 m/h",
        {"feed_force": (1.5e3, 4e3)},
        {"rop": (27.0 / HOUR, None)},
        STRONG,
        goal=feed,
        least=True,
    ),
}

Answer = tuple[Case, Optimum, pd.DataFrame]


def run(count: int = 9, names: Iterable[str] = CASES) -> list[Answer]:
    """Returns each case with its optimum and its grid."""
    return [(CASES[name], CASES[name].found(), CASES[name].brute(count)) for name in names]


def draw(found: list[Answer]) -> Figure:
    """Draws the grids, with a star at the optimum."""
    with styled(max(4.5, 3.6 * len(found)), 3.4) as figure:
        panels = figure.subplots(1, len(found), squeeze=False)
        for axes, (case, best, grid) in zip(panels[0], found, strict=True):
            names = [*case.free]
            star = [LABELS[name][1] * best.parameters[name] for name in names]
            if len(names) == 1:
                _curve(axes, case, names[0], grid)
                star.append(HOUR * best.steady["rop"])
            else:
                _map(axes, names, grid)
            axes.plot(*star, "k*", ms=12, mec="white")
            axes.set_xlabel(LABELS[names[0]][0])
            axes.set_title(f"{case.title}\n{in_words(case, best, grid)}")
    return figure


def _curve(axes: Axes, case: Case, name: str, grid: pd.DataFrame) -> None:
    axes.plot(LABELS[name][1] * grid[name], HOUR * grid["rop"], "o-", ms=3, color=PISTON)
    for limit in case.limits["rop"]:
        if limit is not None:
            axes.axhline(HOUR * limit, color="0.6", lw=0.8)
    axes.set_ylabel("rate of penetration (m/h)")


def _map(axes: Axes, names: list[str], grid: pd.DataFrame) -> None:
    table = grid.assign(rate=HOUR * grid["rop"].where(grid["within"]))
    wide = table.pivot_table(index=names[1], columns=names[0], values="rate", dropna=False)
    scales = [
        LABELS[name][1] * of for name, of in zip(names, (wide.columns, wide.index), strict=True)
    ]
    drawn = axes.pcolormesh(*scales, wide.to_numpy(), shading="nearest")
    axes.set_ylabel(LABELS[names[1]][0])
    axes.figure.colorbar(drawn, ax=axes, label="rate (m/h); white: beyond the limit")


def in_words(case: Case, best: Optimum, grid: pd.DataFrame) -> str:
    """Returns the optimum and the best point of the grid as text, in field units."""
    within = grid[grid["within"]]
    if case.least:
        return f"found {best.value / 1e3:.2f} kN, grid {within['feed_force'].min() / 1e3:.2f} kN"
    return f"found {HOUR * best.value:.2f}, grid {HOUR * within['rop'].max():.2f} m/h"


def main() -> None:
    """Finds, prints and draws the named cases, or all."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}")
    parser.add_argument("--count", type=int, default=9, help="points of the grid along a side")
    parser.add_argument("--out", type=Path, default=Path("optimum.png"))
    asked = parser.parse_args()
    if unknown := {*asked.names} - {*CASES}:
        parser.error(f"no case is called {', '.join(unknown)}")
    found = run(asked.count, asked.names or CASES)
    for case, best, grid in found:
        print(f"{case.title}: {in_words(case, best, grid)}", end="")
        print(f", {best.hammers} hammers and {len(grid)} points")
        for name, value in best.parameters.items():
            label, factor = LABELS[str(name)]
            print(f"    {label}: {factor * value:.2f}")
        print(f"    {best.message}")
    draw(found).savefig(asked.out, dpi=160)


if __name__ == "__main__":
    main()
