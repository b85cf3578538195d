"""A thousand hammers: how the tip's gain depends on five parameters at once.

    python examples/thousand.py --out thousand.parquet   # resumes if stopped

Every combination of feed force, rock stiffness, unloading ratio, supply force and bit length is a
run of one second. The table is written to a Parquet file, and the figure into the same folder.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import VARIABLES, sweep
from dth_hammer.figures import BIT
from dth_hammer.figures.style import styled
from matplotlib.figure import Figure

#: Multiples of the FMU's own values, which are among them.
LEVELS: Mapping[str, Sequence[float]] = {
    "feed_force": (0.4, 0.7, 1.0, 1.5, 2.0),
    "rock.stiffness": (0.5, 1.0, 2.0, 4.0, 8.0),
    "rock.unloading_ratio": (0.5, 1.0, 1.5, 2.5),
    "drive.amplitude": (0.7, 0.85, 1.0, 1.15, 1.3),
    "bit.length": (1.0, 2.0),
}
NAMES = {
    "feed_force": "feed force",
    "rock.stiffness": "rock stiffness",
    "rock.unloading_ratio": "unloading ratio",
    "drive.amplitude": "supply force",
    "bit.length": "bit length",
}


def grid(levels: Mapping[str, Sequence[float]] = LEVELS) -> pd.DataFrame:
    """Returns one row per hammer; a longer bit has more elements of the same size."""
    points = pd.DataFrame(itertools.product(*levels.values()), columns=[*levels])
    elements = points["bit.length"] * (VARIABLES["bit.elements"].start or 0.0)
    for name in levels:
        points[name] *= VARIABLES[name].start or 0.0
    return points.assign(**{"bit.elements": elements.round().astype(int)})


def run(
    until: float = 1.0,
    levels: Mapping[str, Sequence[float]] = LEVELS,
    out: Path | None = None,
) -> pd.DataFrame:
    """Returns the sweep's table."""
    return sweep(grid(levels), until, out=out, progress=True)


def effects(table: pd.DataFrame, name: str) -> pd.DataFrame:
    """Returns the tip's mean rate over one parameter, relative to that at the FMU's own value.

    There is a column for each combination of the other parameters.
    """
    others = [other for other in LEVELS if other != name]
    curves = table.pivot(index=name, columns=others, values="tip_rate_mean")
    own = VARIABLES[name].start or 0.0
    curves.index = curves.index / own
    return curves / curves.loc[1.0]


def draw(table: pd.DataFrame) -> Figure:
    """Draws a panel per parameter: a line per combination of the others, and their median."""
    with styled(10.0, 3.6) as figure:
        panels = figure.subplots(1, len(NAMES), sharey=True)
        for axes, (name, label) in zip(panels, NAMES.items(), strict=True):
            curves = effects(table, name)
            axes.loglog(curves.index, curves, color=BIT, alpha=0.06, linewidth=0.8)
            axes.loglog(curves.index, curves.median(axis=1), "o-", color="black", ms=3.5)
            axes.set_xlabel(f"{label}\nover its own value")
            axes.set_xticks(curves.index, [f"{x:g}" for x in curves.index])
            axes.grid(color="0.92", linewidth=0.6)
        for axes in panels:
            axes.minorticks_off()
        panels[0].set_ylabel("tip's mean gain per time, over that at 1")
        ticks = (0.25, 0.5, 1.0, 2.0)
        panels[0].set_yticks(ticks, [f"{y:g}" for y in ticks])
    return figure


def powers(table: pd.DataFrame) -> pd.Series:
    """Returns the exponent of each parameter in the power law that fits all runs best."""
    drilled = table[table["tip_rate_mean"] > 0.0]
    columns = [np.log(drilled[name]) for name in LEVELS]
    design = np.column_stack([np.ones(len(drilled)), *columns])
    found = np.linalg.lstsq(design, np.log(drilled["tip_rate_mean"]), rcond=None)[0]
    return pd.Series(found[1:], index=[*LEVELS])


def main() -> None:
    """Sweeps, prints the exponents and draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("thousand.parquet"))
    options = parser.parse_args()
    table = run(out=options.out)
    print(powers(table).to_string(float_format="%.2f"))
    draw(table).savefig(options.out.with_suffix(".png"), dpi=160)


if __name__ == "__main__":
    main()
