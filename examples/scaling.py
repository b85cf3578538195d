"""How a sweep scales with workers: the same runs on one and on two, timed.

python examples/scaling.py --runs 200 --out scaling.md
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
from dask.distributed import Client, LocalCluster
from dth_hammer import sweep


def measure(
    runs: int, until: float, workers: Sequence[int] = (1, 2), repeats: int = 3
) -> pd.DataFrame:
    """One row a kind of worker and count: the best of some repeats."""
    grid = {"feed_force": np.linspace(3e3, 9e3, runs).tolist()}
    warm = {"feed_force": grid["feed_force"][:16]}
    rows = []
    for kind in ("processes", "threads"):
        best = dict.fromkeys(workers, np.inf)
        with ExitStack() as stack:
            clients = {n: stack.enter_context(_client(kind, n)) for n in workers}
            # The first use of a worker loads libraries: not what is asked here.
            for client in clients.values():
                sweep(warm, 0.01, scheduler=client, batch=1)
            # In turn, so that what else the machine does meets all alike.
            for _, n in itertools.product(range(repeats), workers):
                began = time.perf_counter()
                sweep(grid, until, scheduler=clients[n], batch=max(1, runs // 40))
                best[n] = min(best[n], time.perf_counter() - began)
        rows += [{"kind": kind, "workers": n, "seconds": best[n]} for n in workers]
    table = pd.DataFrame(rows)
    first = table.groupby("kind")["seconds"].transform("first")
    return table.assign(speedup=first / table["seconds"], rate=runs * until / table["seconds"])


@contextmanager
def _client(kind: str, count: int) -> Iterator[Client]:
    apart = kind == "processes"
    with (
        LocalCluster(
            n_workers=count if apart else 1,
            threads_per_worker=1 if apart else count,
            processes=apart,
            dashboard_address=":0",
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


def report(table: pd.DataFrame, runs: int, until: float) -> str:
    """The table as a page."""
    lines = [
        f"{runs} runs of {until:g} s each, best of some repeats, start of the workers not counted:",
        "",
        "| workers | number | s | speed-up | simulated s per s |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {r.kind} | {r.workers} | {r.seconds:.2f} | {r.speedup:.2f} | {r.rate:.0f} |"
        for r in table.itertuples()
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--until", type=float, default=1.0)
    parser.add_argument("--out", type=Path, default=Path("scaling.md"))
    options = parser.parse_args()
    text = report(measure(options.runs, options.until), options.runs, options.until)
    options.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
