"""Many rows on a Dask cluster: what a row costs, and what the client remembers.

    python evidence/bench/cluster.py 1000 10000 100000 1000000 > reports/cluster.md

Two ways, in processes of their own, on a cluster of this machine. *Rows to the client*:
`sweep(scheduler=client)`, whose table is the answer. *Partitions*: each task is a sweep of a part
of the grid, which its worker writes to a Parquet file of its own; the client hears of counts alone,
and asks for a few tasks more than there are workers. The runs are short, of rigid bodies: what is
measured is what surrounds them.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from itertools import islice
from pathlib import Path

import pandas as pd
from dask.distributed import Client, LocalCluster, as_completed
from dth_hammer import sweep

WORKERS = 2
#: Of a partition.
ROWS = 5000
#: More rows than this are not brought to the client.
MOST = 100_000
#: Of each run, s.
UNTIL = 0.1
RIGID = {"fidelity": "Rigid"}
OUTPUTS = ["hole_depth"]


def feeds(first: int, count: int) -> pd.DataFrame:
    """Feed forces that no other row has, N."""
    return pd.DataFrame({"feed_force": [4e3 + 1e-4 * k for k in range(first, first + count)]})


def part(first: int, count: int, folder: str) -> int:
    """A worker's sweep into a file of its own; the number of rows."""
    out = Path(folder) / f"rows-{first:09}.parquet"
    grid = feeds(first, count)
    return len(
        sweep(
            grid,
            UNTIL,
            parameters=RIGID,
            outputs=OUTPUTS,
            out=out,
            scheduler="threads",
            workers=1,
        )
    )


def partitions(client: Client, rows: int, folder: str) -> int:
    """All partitions, a few at a time; the number of rows."""
    parts = ((k, min(ROWS, rows - k), folder) for k in range(0, rows, ROWS))
    first = [client.submit(part, *one, pure=False) for one in islice(parts, 2 * WORKERS)]
    done, count = as_completed(first), 0
    for future in done:
        count += future.result()
        for one in islice(parts, 1):
            done.add(client.submit(part, *one, pure=False))
    return count


def to_client(client: Client, rows: int) -> int:
    """One table; the number of rows."""
    grid = feeds(0, rows)
    return len(sweep(grid, UNTIL, parameters=RIGID, outputs=OUTPUTS, scheduler=client))


def spent(who: int) -> float:
    """CPU seconds of this process or its children, s."""
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def peak() -> float:
    """Most memory of this process, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measured(way: str, rows: int) -> dict[str, float]:
    """One way with so many rows."""
    with tempfile.TemporaryDirectory() as folder:
        with (
            LocalCluster(
                n_workers=WORKERS, threads_per_worker=1, dashboard_address=None
            ) as cluster,
            Client(cluster) as client,
        ):
            before, begun, own = peak(), time.perf_counter(), spent(resource.RUSAGE_SELF)
            count = (
                partitions(client, rows, folder) if way == "partitions" else to_client(client, rows)
            )
            took, own = time.perf_counter() - begun, spent(resource.RUSAGE_SELF) - own
        if count != rows:
            raise SystemExit(f"{count} rows of {rows}")
        files = [*Path(folder).glob("*.parquet")]
        stored = sum(len(pd.read_parquet(file, columns=["hole_depth"])) for file in files)
    return {
        "seconds": took,
        "workers": spent(resource.RUSAGE_CHILDREN),
        "client": own,
        "grown": peak() - before,
        "stored": stored,
    }


def header() -> None:
    """What was measured, and the head of the table."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    print("# Rows on a Dask cluster: `python evidence/bench/cluster.py`\n")
    print(
        f"{WORKERS} workers on {os.cpu_count()} cores with {memory:.0f} GB; rigid runs of "
        f"{UNTIL} s; {ROWS} rows a partition. The load of the machine was "
        f"{os.getloadavg()[1]:.0f} at the start. A worker's CPU time has its start in it.\n"
    )
    print("| rows | way | s | client's CPU s | workers' CPU us a row | client's memory grows, MB |")
    print("|---:|---|---:|---:|---:|---:|", flush=True)


def main() -> None:
    """Measures each way and size in a process of its own, and prints a page."""
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measured(sys.argv[2], int(sys.argv[3]))))
        return
    header()
    last = {}
    for rows in map(int, sys.argv[1:]):
        for way in ("to the client", "partitions") if rows <= MOST else ("partitions",):
            command = [sys.executable, __file__, "--one", way, str(rows)]
            text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            found = json.loads(text.splitlines()[-1])
            last[way] = {name: number * 1e7 / rows for name, number in found.items()}
            print(
                f"| {rows} | {way} | {found['seconds']:.1f} | {found['client']:.1f} "
                f"| {1e6 * found['workers'] / rows:.0f} | {found['grown']:.0f} |",
                flush=True,
            )
    whole, parts = last["to the client"], last["partitions"]
    print(
        f"\nAt the cost of the last rows, 1e7 rows as one table would take "
        f"{whole['grown'] / 1e3:.0f} GB of the client and {whole['client'] / 3600:.1f} h of its "
        f"processor; as partitions they would take these workers {parts['seconds'] / 3600:.1f} h."
    )


if __name__ == "__main__":
    main()
