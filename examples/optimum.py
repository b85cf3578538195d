"""Three designs, each found by `optimise` and beside it by brute force.

    python examples/optimum.py --out optimum.png     # minutes: three grids of hammers
    python examples/optimum.py --air --out ports.png # where an air hammer's ports are best

* the shape of a stepped piston of fixed mass and length,
* bore and stroke of a drive at fixed pressure, with a limit on the blow's energy,
* the feed force that drills fastest,
* apart from these, the place of an air hammer's exhaust port for a compressor that is given.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from dth_hammer import VARIABLES, Optimum, optimise
from dth_hammer.figures import PISTON
from dth_hammer.longrun import Wanted, numbers_of, responses
from dth_hammer.style import styled
from dth_hammer.variables import Value
from matplotlib.axes import Axes
from matplotlib.figure import Figure

#: Enough to show how it goes, and quick.
COARSE: Mapping[str, Value] = {
    "piston.elements": 4,
    "bit.elements": 4,
    "contact.stiffness": 2e10,
}
LENGTH, AREA = (float(VARIABLES[n].start or 0.0) for n in ("piston.length", "cross_section"))
PRESSURE = 20e5  # Pa
#: What is free, on an axis.
LABELS = {
    "upper_length": "length of the upper section over the whole",
    "upper_over_lower": "area, upper over lower",
    "bore": "bore (m)",
    "stroke": "stroke (m)",
    "feed": "feed force (N)",
    "exhaust": "drive chamber's exhaust opens at (m, above the bit)",
}
#: Standard error of a rate, over it: the rate jumps by as much from design to design.
ERROR = 0.01


def shape(chosen: Mapping[str, float]) -> dict[str, Value]:
    """A piston of two sections with the mass and length of the uniform one."""
    part, ratio = chosen["upper_length"], chosen["upper_over_lower"]
    lower = AREA / (part * ratio + (1.0 - part))
    return {
        "piston.segments": 2,
        "piston.segment[1].length": part * LENGTH,
        "piston.segment[2].length": (1.0 - part) * LENGTH,
        "piston.segment[1].area": ratio * lower,
        "piston.segment[2].area": lower,
    }


def bore(chosen: Mapping[str, float]) -> dict[str, Value]:
    """A drive at a fixed pressure."""
    force = PRESSURE * 0.25 * np.pi * chosen["bore"] ** 2
    return {"drive.amplitude": force, "drive.stroke": chosen["stroke"]}


def feed(chosen: Mapping[str, float]) -> dict[str, Value]:
    """The feed force alone."""
    return {"feed_force": chosen["feed"]}


def ports(chosen: Mapping[str, float]) -> dict[str, Value]:
    """An air hammer whose drive chamber is vented lower or higher."""
    return {"air.drive.exhaust": -chosen["exhaust"]}


@dataclass(frozen=True)
class Case:
    """A design to be found."""

    title: str
    design: Callable[[Mapping[str, float]], dict[str, Value]]
    free: Mapping[str, tuple[float, float]]
    energy: float | None = None  # J, at most
    air: float | None = None  # m3/s of free air, at most
    preset: str | None = None

    def found(self) -> Optimum:
        """By `optimise`."""
        given = {"blow_energy": self.energy, "air_flow": self.air}
        limits = {name: (None, most) for name, most in given.items() if most}
        asked: dict[str, Any] = {"limits": limits, "design": self.design, "error": ERROR}
        return optimise("rop", self.free, self.others, preset=self.preset, **asked)

    @property
    def others(self) -> Mapping[str, Value]:
        """What is not free."""
        return {} if self.preset else COARSE

    def brute(self, count: int) -> pd.DataFrame:
        """The rate on a grid; not a number where the limit is passed."""
        axes = [np.linspace(low, high, count) for low, high in self.free.values()]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        table = pd.DataFrame(points, columns=pd.Index([*self.free]))
        designs = [self.design(dict(row)) for row in table.to_dict("records")]
        scenes = [numbers_of({**self.others, **design}, self.preset) for design in designs]
        for row, found in responses(scenes, Wanted(error=ERROR)):
            past = (
                isinstance(found, str)
                or found["blow_energy"] > (self.energy or np.inf)
                or found["air_flow"] > (self.air or np.inf)
            )
            table.loc[row, "rop"] = np.nan if past else found["rop"]
        return table


CASES = (
    Case(
        "shape at fixed mass",
        shape,
        {"upper_length": (0.2, 0.8), "upper_over_lower": (0.4, 2.5)},
    ),
    Case(
        "drive at fixed pressure",
        bore,
        {"bore": (0.028, 0.04), "stroke": (0.03, 0.06)},
        energy=240.0,
    ),
    Case("feed", feed, {"feed": (1e3, 25e3)}),
)


#: Of a compressor of 18.5 m3/min.
AIR = Case("ports at given air", ports, {"exhaust": (0.02, 0.036)}, None, 18.5 / 60, "air_4_inch")


def run(count: int = 9, cases: Sequence[Case] = CASES) -> list[tuple[Case, Optimum, pd.DataFrame]]:
    """Each case, found and by brute force."""
    return [(case, case.found(), case.brute(count)) for case in cases]


def draw(found: list[tuple[Case, Optimum, pd.DataFrame]]) -> Figure:
    """The grids, and a star where `optimise` ended."""
    with styled(max(4.5, 3.3 * len(found)), 3.6) as figure:
        panels = figure.subplots(1, len(found), squeeze=False)[0]
        for axes, (case, best, grid) in zip(panels, found, strict=True):
            _panel(axes, case, best, grid)
    return figure


def _panel(axes: Axes, case: Case, best: Optimum, grid: pd.DataFrame) -> None:
    names = [*case.free]
    if len(names) == 1:
        axes.plot(grid[names[0]], 3600 * grid["rop"], "o-", ms=3, color=PISTON)
        axes.plot(best.parameters[names[0]], 3600 * best.value, "k*", ms=12)
        axes.set_ylabel("rate of penetration (m/h)")
    else:
        table = 3600 * grid.pivot_table(
            index=names[1], columns=names[0], values="rop", dropna=False
        )
        drawn = axes.pcolormesh(table.columns, table.index, table.to_numpy(), shading="nearest")
        axes.plot(*best.parameters[names], "k*", ms=12, mec="white")
        axes.set_ylabel(LABELS[names[1]])
        axes.figure.colorbar(drawn, ax=axes, label="m/h")
    axes.set_xlabel(LABELS[names[0]])
    top = 3600 * grid["rop"].max()
    white = f" (white: above {case.energy:.0f} J)" if case.energy else ""
    text = f"{case.title}{white}\nfound {3600 * best.value:.2f}, grid {top:.2f} m/h"
    axes.set_title(text, fontsize=9)


def main() -> None:
    """Finds all, prints and draws them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=9, help="points of the grid along a side")
    parser.add_argument("--out", type=Path, default=Path("optimum.png"))
    parser.add_argument("--air", action="store_true", help="the air hammer's ports alone")
    asked = parser.parse_args()
    found = run(asked.count, [AIR] if asked.air else CASES)
    for case, best, grid in found:
        print(f"{case.title}: {3600 * best.value:.2f} m/h by {best.evaluations} hammers, ", end="")
        print(f"{3600 * grid['rop'].max():.2f} on a grid of {len(grid)}; {best.message}")
        print(best.parameters.to_string())
    draw(found).savefig(asked.out, dpi=160)


if __name__ == "__main__":
    main()
