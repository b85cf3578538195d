"""How a sweep scales with threads: hammers of the thousand on one and on two, timed.

python examples/scaling.py --runs 100 --out scaling.md
"""

from __future__ import annotations

import argparse
import itertools
import platform
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import thousand
from dth_hammer import sweep


def measure(
    runs: int, until: float, workers: Sequence[int] = (1, 2), repeats: int = 10
) -> pd.DataFrame:
    """One row a count of threads and repeat: seconds, and the share of others' work."""
    whole = thousand.grid()
    # Spread over it: long bits cost more than short ones.
    grid = whole.iloc[np.linspace(0, len(whole) - 1, runs).astype(int)]
    rows = []
    # In turn, so that what else the machine does meets all alike.
    for repeat, n in itertools.product(range(repeats), workers):
        meanwhile = Meanwhile()
        sweep(grid, until, scheduler="threads", workers=n)
        row = {"workers": n, "repeat": repeat}
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


#: Share of the machine that others may take in a turn that counts.
QUIET = 0.1


def quiet(table: pd.DataFrame) -> pd.DataFrame:
    """The turns that others left alone; all, if they never did."""
    calm = table.groupby("repeat")["others"].transform("max") <= QUIET
    return table[calm] if calm.any() else table


def report(table: pd.DataFrame, runs: int, until: float) -> str:
    """The table as a page: the best time, and how much faster each turn was than with one."""
    lines = [
        f"{runs} runs of {until:g} s each, in turn with each number of threads. Of "
        f"{table['repeat'].nunique()} turns count those in which other "
        f"work took less than {QUIET:.0%} of the machine, or all if there is none. Best time; "
        "speed-up within each turn, its middle and its range:",
        "",
        "| threads | s | simulated s per s | speed-up | turns | other work |",
        "|---|---|---|---|---|---|",
    ]
    counted = quiet(table)
    seconds = counted.pivot(index="repeat", columns="workers", values="seconds")
    others = f"{counted['others'].min():.0%} to {counted['others'].max():.0%}"
    for number, times in seconds.items():
        gain = seconds.iloc[:, 0] / times
        row = f"{gain.median():.2f} ({gain.min():.2f} to {gain.max():.2f})"
        lines.append(
            f"| {number} | {times.min():.2f} | {runs * until / times.min():.0f} "
            f"| {row} | {len(times)} | {others} |"
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
