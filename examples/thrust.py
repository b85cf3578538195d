"""The thrust curve without a casing and in one: mean rate of penetration over the feed force.

    python examples/thrust.py --out thrust.png
    python examples/thrust.py --air --out air.png
    python examples/thrust.py --elastic

Every run of the curve starts with a feed that holds the casing down; within 1 ms the feed falls to
that of the run. The second command draws the curve of a hammer with its own air, with the feed that
makers recommend for its class. The third prints what changes if the reference hammer's casing is
elastic, without a drill string and with one.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from dth_hammer import PRESETS, RefusedError, simulate
from dth_hammer.figures import BIT, PISTON, ROCK
from dth_hammer.figures.style import styled
from dth_hammer.models.compressor import FREE
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from collections.abc import Mapping

#: A hammer with a strong drive in hard rock.
HAMMER: Mapping[str, float] = {
    "rock.stiffness": 3e8,
    "drive.amplitude": 3e3,
    "drive.stroke": 0.08,
}
#: Columns to draw.
SCENES: Mapping[str, Mapping[str, float]] = {
    "no casing": {},
    "casing of 40 kg": {"casing.mass": 40.0},
    "casing of 40 kg that vents": {"casing.mass": 40.0, "chuck.idle_travel": 0.01},
}
FEEDS = tuple(np.linspace(0.0, 5e3, 21))  # N
#: Feed at the start, N, and when it starts to fall, s.
HELD, RELEASED = 4e3, 0.1
#: Duration that is averaged, s, and number of batches.
FROM, UNTIL, BATCHES = 1.0, 5.0, 8


def run(feeds: tuple[float, ...] = FEEDS) -> pd.DataFrame:
    """Returns a row per scene and feed: mean rate (m/s) and its standard error, mean forces (N)."""

    def row(name: str, feed: float) -> dict[str, float | str]:
        fall = pd.Series([HELD, HELD, feed], index=[0.0, RELEASED, RELEASED + 1e-3])
        run = simulate({**HAMMER, **SCENES[name]}, until=UNTIL, inputs={"feed_force": fall})
        edges = np.linspace(FROM, UNTIL, BATCHES + 1)
        depth, drive = run["drilled_length"], run["applied_drive_force"]
        depths = np.interp(edges, depth.index, depth)
        rates = np.diff(depths) / np.diff(edges)
        return {
            "scene": name,
            "feed": feed,
            "rop": rates.mean(),
            "error": rates.std(ddof=1) / np.sqrt(BATCHES),
            "drive": drive[drive.index >= FROM].mean(),
        }

    asked = [(name, feed) for name in SCENES for feed in feeds]
    with ThreadPoolExecutor() as pool:
        return pd.DataFrame(list(pool.map(lambda pair: row(*pair), asked)))


#: The same 40 kg as a rigid casing and as a steel bar of 1 m, and endless strings above, N s/m.
CASINGS: Mapping[str, Mapping[str, float]] = {
    "rigid": {"casing.mass": 40.0},
    "elastic": {
        "casing.segments": 1,
        "casing.segment[1].length": 1.0,
        "casing.segment[1].area": 40.0 / 7850.0,
    },
}
STRINGS = (0.0, 2e4)


def elasticity() -> pd.DataFrame:
    """A row for each casing and string: means after FROM, by blow where it is of a blow."""

    def row(casing: str, string: float) -> dict[str, float | str]:
        scene = {**CASINGS[casing], "casing.impedance": string}
        found = simulate(scene, until=UNTIL)
        frame, struck = found.frame, found.blows[found.blows["blow_time"] >= FROM]
        run = frame[frame.index >= FROM]
        totals = run[["blow_count", "energy_damping"]]
        blows, lost = totals.iloc[-1] - totals.iloc[0]
        depth = run["drilled_length"]
        return {
            "casing": casing,
            "string (N s/m)": string,
            "rate (m/h)": 3600 * (depth.iloc[-1] - depth.iloc[0]) / (UNTIL - FROM),
            "blow energy (J)": run["blow_energy"].mean(),
            "chuck peak (kN)": 1e-3 * struck["chuck_force_peak"].max(),
            "lost beside the rock (J a blow)": lost / blows,
        }

    return pd.DataFrame([row(casing, string) for string in STRINGS for casing in CASINGS])


#: A hammer that air drives, its feeds (N), and the feed that a maker recommends for 80 mm at up to
#: 17 bar (SPM, *DTH Hammers (Medium Air Pressure)*), N.
AIR = "air_3_5_inch"
AIR_FEEDS = (2e3, 3e3, 4e3, 5e3, 6e3, 7e3, 8e3, 9e3, 10e3, 12e3, 15e3)
RECOMMENDED = (5.4e3, 11.8e3)


def run_air(feeds: tuple[float, ...] = AIR_FEEDS, until: float = UNTIL) -> pd.DataFrame:
    """Returns a row per feed: rate (m/s) and its standard error, blows per second, free air (m3/s).

    Numbers are missing if the feed is so small that a chamber has no volume, because the air then
    has no solution.
    """
    names = ["drilled_length", "blow_count", "air_mass"]

    def row(feed: float) -> dict[str, float]:
        held = PRESETS[AIR].values["feed_force"]
        fall = pd.Series([held, held, feed], index=[0.0, RELEASED, RELEASED + 1e-3])
        given: Mapping[str, pd.Series] = {"feed_force": fall}
        try:
            run = simulate({}, until, preset=AIR, inputs=given, step="1 ms", outputs=names)
        except RefusedError:
            return dict.fromkeys(("rop", "error", "blows", "air"), np.nan) | {"feed": feed}
        edges = np.linspace(4 * RELEASED, until, BATCHES + 1)
        totals = [np.interp(edges, run.frame.index, run.frame[name]) for name in names]
        rates, blows, air = np.diff(totals) / np.diff(edges)
        means = {"rop": rates.mean(), "blows": blows.mean(), "air": air.mean() / FREE}
        return {"feed": feed, "error": rates.std(ddof=1) / np.sqrt(BATCHES), **means}

    with ThreadPoolExecutor() as pool:
        return pd.DataFrame(list(pool.map(row, feeds)))


def knee(table: pd.DataFrame) -> float:
    """Returns the least feed (N) from which on the rate is within a tenth of the highest."""
    enough = table["rop"] >= 0.9 * table["rop"].max()
    return float(table["feed"][enough[::-1].cummin()[::-1]].min())


def draw_air(table: pd.DataFrame) -> Figure:
    """Draws rate (with a band of two standard errors) and blows over feed, and advised feeds."""
    with styled(6.0, 4.4) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        feed, rate, error = 1e-3 * table["feed"], 3600 * table["rop"], 7200 * table["error"]
        upper.plot(feed, rate, "o-", ms=3, color=ROCK)
        upper.fill_between(feed, rate - error, rate + error, color=ROCK, alpha=0.2, lw=0.0)
        upper.set_ylabel("rate of penetration (m/h)")
        lower.plot(feed, table["blows"], "o-", ms=3, color=PISTON)
        lower.set(xlabel="feed force (kN)", ylabel="blows a second")
        for axes in (upper, lower):
            axes.axvspan(*(1e-3 * f for f in RECOMMENDED), color="0.93", label="recommended, 80 mm")
            axes.axvline(1e-3 * knee(table), color="0.4", lw=0.8, ls="--", label="knee")
            axes.set_ylim(bottom=0.0)
        handles, labels = upper.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2)
    return figure


def draw(table: pd.DataFrame) -> Figure:
    """Draws means with bands of two standard errors, and the feed that the mean drive requires."""
    with styled(6.0, 4.0) as figure:
        axes = figure.subplots()
        scenes = table.groupby("scene", sort=False)
        for (name, part), colour in zip(scenes, (ROCK, PISTON, BIT), strict=True):
            feed, rate, error = 1e-3 * part["feed"], 3600 * part["rop"], 7200 * part["error"]
            axes.plot(feed, rate, "o-", ms=3, color=colour, label=name)
            axes.fill_between(feed, rate - error, rate + error, color=colour, alpha=0.2, lw=0.0)
        knee, dashes = 1e-3 * least(table), {"color": "0.4", "lw": 0.8, "ls": "--"}
        axes.axvline(knee, label="mean drive less weight", **dashes)
        axes.set_xlabel("feed force (kN)")
        axes.set_ylabel("mean rate of penetration (m/h)")
        axes.set_ylim(bottom=0.0)
        axes.grid(color="0.92", linewidth=0.6)
        figure.legend(loc="outside upper center", ncols=2)
    return figure


def least(table: pd.DataFrame) -> float:
    """Returns the feed that the chuck needs: the mean drive force minus the casing's weight, N."""
    free = table[table["scene"] == "casing of 40 kg"]
    weight = 9.81 * SCENES["casing of 40 kg"]["casing.mass"]
    return float(free["drive"].iloc[-1]) - weight


def main() -> None:
    """Runs, prints and draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("thrust.png"))
    parser.add_argument("--elastic", action="store_true", help="the elastic casing instead")
    parser.add_argument("--air", action="store_true", help="a hammer with its air inside")
    options = parser.parse_args()
    if options.air:
        table = run_air()
        print(table.to_string(index=False))
        draw_air(table).savefig(options.out, dpi=160)
        return
    if options.elastic:
        print(elasticity().round(3).to_string(index=False))
        return
    table = run()
    print(table.to_string(index=False))
    draw(table).savefig(options.out, dpi=160)


if __name__ == "__main__":
    main()
