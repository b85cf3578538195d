"""Many runs over a grid of parameters, on Dask; resumable; one row a run."""

from __future__ import annotations

import hashlib
import itertools
import json
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import dask
import pandas as pd
from dask.distributed import Client, LocalCluster, as_completed
from tqdm import tqdm

from .errors import DthHammerError, RefusedError, UnknownNameError
from .hammer import Hammer
from .package import Package, load
from .variables import Value

Grid = Mapping[str, Sequence[Value]] | pd.DataFrame
#: What a row tells about a run's end unless other outputs are asked for.
RESULTS = (
    "blow_count",
    "blow_period",
    "blow_speed",
    "blow_energy",
    "blow_penetration",
    "rop",
    "rop_mean",
    "hole_depth",
    "energy_drive",
    "energy_residual",
    "stalled",
)
RUN, ERROR = "run", "error"


def sweep(
    grid: Grid,
    until: float,
    *,
    parameters: Mapping[str, Value] | None = None,
    preset: str | None = None,
    outputs: Iterable[str] = RESULTS,
    out: str | Path | None = None,
    scheduler: str | Client = "processes",
    workers: int | None = None,
    batch: int = 4,
    fmu: str | Path | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Runs every point of a grid and returns one row a run.

    Args:
        grid: values by parameter (all combinations), or a DataFrame with one row a run.
        until: seconds of each run.
        parameters: what all runs share, laid over the preset.
        preset: parameter set to start from.
        outputs: what to read at the end of a run.
        out: Parquet file for the table. Until it is complete the rows are kept beside it
            in parts: the same call made again runs only what is missing.
        scheduler: ``"processes"``, ``"threads"``, the address of a Dask scheduler, or a
            Dask client. With an address the FMU must be at the same path for the workers.
        workers: how many, for processes and threads; as many as there are cores if None.
        batch: runs a task: a part file and a tick of the progress bar.
        fmu: file to use instead of the one found.
        progress: shows a progress bar.

    A run that the FMU refuses has its message in the column ``error``.
    """
    package, names = load(fmu), list(outputs)
    common = package.values(preset, parameters)
    points = [package.values(None, point) for point in _points(grid)]
    for name in names:
        package.variables[name]
    runs = {_key(package, common | point, until, names): point for point in points}
    store = _Store(Path(out)) if out else None
    done = store.rows() if store else pd.DataFrame()
    known = set(done[RUN]) if len(done) else set()
    open_runs = [(key, common | point) for key, point in runs.items() if key not in known]
    tables = [done[done[RUN].isin(list(runs))]] if len(done) else []
    if open_runs:
        with (
            _client(scheduler, workers) as client,
            tqdm(
                total=len(runs),
                initial=len(runs) - len(open_runs),
                unit="run",
                disable=not progress,
            ) as bar,
        ):
            tasks = [
                client.submit(_run_all, part, until, names, str(package.path), pure=False)
                for part in _batches(open_runs, batch)
            ]
            # On this client's own loop: the default is that of the last client made.
            for _, rows in as_completed(tasks, loop=client.loop, with_results=True):
                tables.append(pd.DataFrame(rows))
                bar.update(len(rows))
                if store:
                    store.add(tables[-1])
    table = _ordered(pd.concat(tables, ignore_index=True), runs)
    swept = [*points[0]] if points else []
    table.attrs |= _provenance(package, swept, names, until, common)
    if store:
        store.finish(table)
    return table


class _Store:
    """The table's file, and the folder of parts while it is not complete."""

    def __init__(self, path: Path) -> None:
        self.path, self.parts = path, path.with_suffix(path.suffix + ".parts")
        path.parent.mkdir(parents=True, exist_ok=True)

    def rows(self) -> pd.DataFrame:
        files = [self.path] if self.path.is_file() else []
        files += sorted(self.parts.glob("*.parquet"))
        tables = [pd.read_parquet(file) for file in files]
        for table in tables:
            table.attrs = {}
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    def add(self, table: pd.DataFrame) -> None:
        self.parts.mkdir(exist_ok=True)
        # Written aside and renamed: a part that is there is whole.
        part = self.parts / f"{table[RUN].iloc[0]}.parquet"
        table.to_parquet(part.with_suffix(".new"))
        part.with_suffix(".new").rename(part)

    def finish(self, table: pd.DataFrame) -> None:
        new = self.path.with_suffix(".new")
        table.to_parquet(new)
        new.rename(self.path)
        shutil.rmtree(self.parts, ignore_errors=True)


def _points(grid: Grid) -> Iterator[dict[str, Any]]:
    if isinstance(grid, pd.DataFrame):
        yield from ({str(k): v for k, v in row.items()} for row in grid.to_dict("records"))
    else:
        yield from (
            dict(zip(grid, values, strict=True)) for values in itertools.product(*grid.values())
        )


def _key(package: Package, point: Mapping[str, float], until: float, names: Sequence[str]) -> str:
    """What makes a run the same run: the model, all that is set, how long, what is read."""
    text = json.dumps([package.version, sorted(point.items()), until, list(names)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _batches(items: list[Any], size: int) -> Iterator[list[Any]]:
    for start in range(0, len(items), size):
        yield items[start : start + size]


def _run_all(
    runs: list[tuple[str, dict[str, float]]], until: float, names: list[str], fmu: str
) -> list[dict[str, Any]]:
    return [{RUN: key} | point | _run(point, until, names, fmu) for key, point in runs]


def _run(point: Mapping[str, float], until: float, names: list[str], fmu: str) -> dict[str, Any]:
    # One communication step: the result does not depend on it.
    try:
        with Hammer(point, fmu=fmu) as hammer:
            hammer.advance(until)
            return hammer.get(names) | {ERROR: ""}
    except RefusedError as error:
        return dict.fromkeys(names, float("nan")) | {ERROR: str(error)}


@contextmanager
def _client(scheduler: str | Client, workers: int | None) -> Iterator[Client]:
    if isinstance(scheduler, Client):
        yield scheduler
    elif scheduler in ("processes", "threads"):
        apart = scheduler == "processes"
        shape = {"n_workers": workers} if apart else {"n_workers": 1}
        threads = 1 if apart else (workers or dask.system.CPU_COUNT)
        with (
            LocalCluster(
                **shape, threads_per_worker=threads, processes=apart, dashboard_address=":0"
            ) as cluster,
            Client(cluster) as client,
        ):
            yield client
    else:
        with _connect(scheduler) as client:
            yield client


def _connect(address: str) -> Client:
    if ":" not in address:
        raise UnknownNameError("scheduler", address, ("processes", "threads"))
    try:
        return Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise DthHammerError(f"no Dask scheduler answers at {address}: {error}") from None


def _ordered(table: pd.DataFrame, runs: Mapping[str, Any]) -> pd.DataFrame:
    return table.set_index(RUN).loc[list(runs)].reset_index()


def _provenance(
    package: Package,
    swept: list[str],
    names: list[str],
    until: float,
    common: Mapping[str, float],
) -> dict[str, Any]:
    units = {name: package.variables[name].unit for name in [*swept, *common, *names]}
    return {"units": units, "until": until, "swept": swept, "fmu": package.version}
