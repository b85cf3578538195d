"""How a sweep scales with workers: hammers of the thousand on one and on two, timed.

python examples/scaling.py --runs 100 --out scaling.md
"""

from __future__ import annotations

import argparse
import itertools
import platform
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import psutil
import thousand
from dask.distributed import Client, LocalCluster
from dth_hammer import sweep


def measure(
    runs: int, until: float, workers: Sequence[int] = (1, 2), repeats: int = 10
) -> pd.DataFrame:
    """One row a kind of worker, count and repeat: seconds, and the share of others' work."""
    whole = thousand.grid()
    # Spread over it: long bits cost more than short ones.
    grid = whole.iloc[np.linspace(0, len(whole) - 1, runs).astype(int)]
    warm = grid.iloc[:16]
    rows = []
    for kind in ("processes", "threads"):
        with ExitStack() as stack:
            ways = {n: stack.enter_context(_way(kind, n)) for n in workers}
            # The first use of a worker loads libraries: not what is asked here.
            for way in ways.values():
                sweep(warm, 0.01, **way, batch=1)
            # In turn, so that what else the machine does meets all alike.
            for repeat, n in itertools.product(range(repeats), workers):
                meanwhile = Meanwhile()
                sweep(grid, until, **ways[n])
                row = {"kind": kind, "workers": n, "repeat": repeat}
                rows.append(row | {"seconds": meanwhile.seconds(), "others": meanwhile.others()})
    return pd.DataFrame(rows)


class Meanwhile:
    """What the machine does beside this program and its workers, from now on."""

    def __init__(self) -> None:
        self.began, self.work = time.perf_counter(), self._work()

    def seconds(self) -> float:
        """Time passed."""
        return time.perf_counter() - self.began

    def others(self) -> float:
        """Share of all cores that other work took."""
        every, own = (now - before for now, before in zip(self._work(), self.work, strict=True))
        return max(0.0, every - own) / (self.seconds() * (psutil.cpu_count() or 1))

    @staticmethod
    def _work() -> tuple[float, float]:
        """Processor seconds so far: of the whole machine, and of this program and its workers."""
        machine = psutil.cpu_times()
        every = sum(machine) - machine.idle - getattr(machine, "iowait", 0.0)
        # Linux counts guests' time among the users'.
        every -= getattr(machine, "guest", 0.0) + getattr(machine, "guest_nice", 0.0)
        own = 0.0
        here = psutil.Process()
        for process in (here, *here.children(recursive=True)):
            spent = process.cpu_times()
            own += spent.user + spent.system
            # Of workers that have ended.
            own += getattr(spent, "children_user", 0.0) + getattr(spent, "children_system", 0.0)
        return every, own


@contextmanager
def _way(kind: str, count: int) -> Iterator[dict[str, Any]]:
    """Options of `sweep`; processes are started before and ended after."""
    if kind == "threads":
        yield {"scheduler": kind, "workers": count}
        return
    shape = {"n_workers": count, "threads_per_worker": 1, "dashboard_address": ":0"}
    with LocalCluster(**shape) as cluster, Client(cluster) as client:
        yield {"scheduler": client}


#: Share of the machine that others may take in a turn that counts.
QUIET = 0.1


def quiet(table: pd.DataFrame) -> pd.DataFrame:
    """Of each kind, the turns that others left alone; all, if they never did."""
    parts = []
    for _, part in table.groupby("kind", sort=False):
        calm = part.groupby("repeat")["others"].transform("max") <= QUIET
        parts.append(part[calm] if calm.any() else part)
    return pd.concat(parts)


def report(table: pd.DataFrame, runs: int, until: float) -> str:
    """The table as a page: the best time, and how much faster each turn was than with one."""
    lines = [
        f"{runs} runs of {until:g} s each, in turn with each number of workers, the start of the "
        f"workers not counted. Of {table['repeat'].nunique()} turns count those in which other "
        f"work took less than {QUIET:.0%} of the machine, or all if there is none. Best time; "
        "speed-up within each turn, its middle and its range:",
        "",
        "| workers | number | s | simulated s per s | speed-up | turns | other work |",
        "|---|---|---|---|---|---|---|",
    ]
    counted = quiet(table)
    fewest = counted["workers"].min()
    for kind, part in counted.groupby("kind", sort=False):
        seconds = part.pivot(index="repeat", columns="workers", values="seconds")
        others = f"{part['others'].min():.0%} to {part['others'].max():.0%}"
        for number, times in seconds.items():
            gain = seconds[fewest] / times
            shown = f"{gain.median():.2f} ({gain.min():.2f} to {gain.max():.2f})"
            shown = "1" if number == fewest else shown
            lines.append(
                f"| {kind} | {number} | {times.min():.2f} | {runs * until / times.min():.0f} "
                f"| {shown} | {len(times)} | {others} |"
            )
    lines += ["", f"{psutil.cpu_count()} cores ({platform.machine()})."]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--until", type=float, default=1.0)
    parser.add_argument("--out", type=Path, default=Path("scaling.md"))
    options = parser.parse_args()
    text = report(measure(options.runs, options.until), options.runs, options.until)
    options.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
