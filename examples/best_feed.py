"""The feed force that drills fastest, in three rocks.

    python examples/best_feed.py --out feed.parquet   # a second's run, resumes if stopped

The table goes to a Parquet file, the figure beside it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import rock, sweep
from dth_hammer.figures import BIT, PISTON, ROCK
from dth_hammer.style import styled
from matplotlib.figure import Figure

#: From soft to hard.
ROCKS = ("R3", "R4", "granite")
FEEDS = tuple(np.linspace(1e3, 25e3, 25))  # N


def run(
    feeds: tuple[float, ...] = FEEDS,
    until: float = 1.0,
    out: Path | None = None,
    scheduler: str = "processes",
) -> pd.DataFrame:
    """One row a rock and feed force."""
    grid = pd.DataFrame(
        [{**rock(n, hole="90 mm"), "feed_force": feed} for n in ROCKS for feed in feeds]
    )
    table = sweep(grid, until, out=out, scheduler=scheduler, progress=True)
    table["rock"] = np.repeat(ROCKS, len(feeds))
    return table


def best(table: pd.DataFrame) -> pd.DataFrame:
    """The row with the highest mean rate of penetration, for each rock."""
    rows = table.loc[table.groupby("rock", sort=False)["rop_mean"].idxmax()]
    return rows[["rock", "feed_force", "rop_mean", "blow_period", "blow_energy"]]


def draw(table: pd.DataFrame) -> Figure:
    """Draws the mean rate of penetration over the feed force."""
    with styled(6.0, 4.0) as figure:
        axes = figure.subplots()
        for (name, part), colour in zip(
            table.groupby("rock", sort=False), (ROCK, PISTON, BIT), strict=True
        ):
            feed, speed = part["feed_force"] * 1e-3, part["rop_mean"] * 3600
            axes.plot(feed, speed, "o-", ms=3, color=colour, label=str(name))
        axes.set_xlabel("feed force (kN)")
        axes.set_ylabel("mean rate of penetration (m/h)")
        axes.set_ylim(bottom=0.0)
        axes.grid(color="0.92", linewidth=0.6)
        figure.legend(loc="outside upper center", ncols=len(ROCKS))
    return figure


def main() -> None:
    """Sweeps, prints the best, draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("feed.parquet"))
    options = parser.parse_args()
    table = run(out=options.out)
    print(best(table).to_string(index=False))
    draw(table).savefig(options.out.with_suffix(".png"), dpi=160)


if __name__ == "__main__":
    main()
