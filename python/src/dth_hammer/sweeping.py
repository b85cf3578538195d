"""Many runs over a grid of parameters, on Dask; resumable; one row a run."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from dask.distributed import Client, as_completed
from tqdm import tqdm

from . import quantities
from .errors import DomainError, InterruptedSweepError, RefusedError
from .hammer import Hammer
from .instance import warn
from .package import Package, load
from .store import Store
from .variables import Value
from .workers import client_of

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
#: Columns beside parameters and outputs: what tells runs apart, how long one is, of which
#: model, what it was refused for, and what was doubtful.
ROWS = 2  # version of what a row has
RUN, UNTIL, MODEL, ERROR, DOUBT = "run", "until", "fmu", "error", "doubt"


def sweep(
    grid: Grid,
    until: float | str,
    *,
    parameters: Mapping[str, Value] | None = None,
    preset: str | None = None,
    outputs: Iterable[str] = RESULTS,
    out: str | Path | None = None,
    scheduler: str | Client = "processes",
    workers: int | None = None,
    batch: int = 4,
    fmu: str | Path | Package | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Runs every point of a grid and returns one row a run.

    Args:
        grid: values by parameter (all combinations), or a DataFrame with one row a run.
        until: seconds of each run, or text with a unit.
        parameters: what all runs share, laid over the preset.
        preset: parameter set to start from.
        outputs: what to read at the end of a run.
        out: Parquet or CSV file for the rows. They are kept beside it in parts as they come:
            the same call made again runs only what is missing, and another grid adds its
            rows to those that are there.
        scheduler: ``"processes"``, ``"threads"``, the address of a Dask scheduler, or a
            Dask client. With an address the FMU must be at the same path for the workers.
        workers: how many, for processes and threads; as many as there are cores if None.
        batch: runs a task: a part file and a tick of the progress bar.
        fmu: file to use instead of the one found.
        progress: shows a progress bar.

    A run that the FMU refuses has its message in the column ``error``; what is doubtful in one
    is in ``doubt``.
    """
    package, names = load(fmu), list(outputs)
    end = quantities.duration(until, "until")
    counts(workers=workers, batch=batch)
    common = package.values(preset, parameters)
    points = [package.values(None, point) for point in _points(grid)]
    for name in names:
        package.variables[name]
    keys = [_key(package, common | point, end, names) for point in points]
    runs = {key: common | point for key, point in zip(keys, points, strict=True)}
    store = Store(Path(out)) if out is not None else None
    done = store.rows() if store else pd.DataFrame()
    tables = [done[done[RUN].isin(keys)].drop_duplicates(RUN)] if len(done) else []
    known = set(tables[0][RUN]) if tables else set()
    missing = [(key, runs[key]) for key in runs if key not in known]
    if missing:
        bar = tqdm(total=len(runs), initial=len(known), unit="run", disable=not progress)
        with bar, client_of(scheduler, workers) as client:
            task = (end, names, str(package.path))
            try:
                for part in _results(client, list(_batches(missing, batch)), task):
                    bar.update(len(part))
                    tables.append(part)
                    if store:
                        store.add(part, RUN)
            except KeyboardInterrupt:
                kept = sum(map(len, tables)) if store else 0
                raise InterruptedSweepError(kept, len(runs), store and store.path) from None
    table = _whole(tables, keys, [*{n for p in runs.values() for n in p}], names, package)
    table.attrs |= _provenance(package, [*points[0]], names, end, common)
    if store:
        store.finish()
    _tell(table)
    return table


def counts(**numbers: Any) -> None:
    """Refuses what is no number of things."""
    for name, number in numbers.items():
        if number is not None and (not isinstance(number, int) or number < 1):
            raise DomainError(f"{name} = {number!r} is not a whole number above 0")


def _results(
    client: Client, batches: list[Any], task: tuple[float, list[str], str]
) -> Iterator[pd.DataFrame]:
    futures = [client.submit(_run_all, part, *task, pure=False) for part in batches]
    try:
        # On this client's own loop: the default is that of the last client made.
        for _, rows in as_completed(futures, loop=client.loop, with_results=True):
            yield pd.DataFrame(rows)
    except KeyboardInterrupt:
        client.cancel(futures, force=True)
        raise


def _whole(
    tables: list[pd.DataFrame],
    keys: list[str],
    settings: list[str],
    names: list[str],
    package: Package,
) -> pd.DataFrame:
    """One row a point of the grid, in its order, with the columns that it has."""
    table = pd.concat(tables, ignore_index=True) if len(tables) > 1 else tables[0]
    table = table.set_index(RUN).loc[keys].reset_index()
    table = table[[RUN, *settings, UNTIL, *names, ERROR, DOUBT, MODEL]]
    for name in (RUN, ERROR, DOUBT, MODEL):
        table[name] = table[name].astype(str)
    for name in (*settings, UNTIL):
        table[name] = table[name].astype(float)
    for name in names:
        variable = package.variables[name]
        kind: Any = "boolean" if variable.kind == "Boolean" else float
        if variable.counts:
            kind = "Int64"
        # Rows just computed and rows read again differ in how they write what is missing.
        numbers = [math.nan if pd.isna(v) else float(v) for v in table[name]]
        table[name] = pd.Series(numbers, dtype=float).astype(kind)
    return table


def _points(grid: Grid) -> list[dict[str, Any]]:
    if isinstance(grid, pd.DataFrame):
        points = [{str(k): v for k, v in row.items()} for row in grid.to_dict("records")]
    else:
        for name, values in grid.items():
            if isinstance(values, str) or not isinstance(values, Iterable):
                raise DomainError(f"{name} = {values!r} in the grid is not a list of values")
        axes = {name: list(values) for name, values in grid.items()}
        for name, listed in axes.items():
            if not listed:
                raise DomainError(f"{name} has no value in the grid")
        points = [dict(zip(axes, p, strict=True)) for p in itertools.product(*axes.values())]
    if not points or not points[0]:
        raise DomainError("the grid is empty: name at least one parameter and its values")
    return points


def _key(package: Package, point: Mapping[str, float], until: float, names: Sequence[str]) -> str:
    """What makes a run the same run: the model, all that is set, how long, what is read."""
    text = json.dumps([ROWS, package.version, sorted(point.items()), until, list(names)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _batches(items: list[Any], size: int) -> Iterator[list[Any]]:
    for start in range(0, len(items), size):
        yield items[start : start + size]


def _run_all(
    runs: list[tuple[str, dict[str, float]]], until: float, names: list[str], fmu: str
) -> list[dict[str, Any]]:
    model = load(fmu).version
    return [
        {RUN: key} | point | {UNTIL: until, MODEL: model} | _run(point, until, names, fmu)
        for key, point in runs
    ]


def _run(point: Mapping[str, float], until: float, names: list[str], fmu: str) -> dict[str, Any]:
    # One communication step: the result does not depend on it.
    try:
        with Hammer(point, fmu=fmu, quiet=True) as hammer:
            hammer.advance(until)
            return hammer.get(names) | {ERROR: "", DOUBT: "; ".join(hammer.doubts)}
    except RefusedError as error:
        return dict.fromkeys(names, float("nan")) | {ERROR: str(error), DOUBT: ""}


def _tell(table: pd.DataFrame) -> None:
    """Warns once of what is doubtful in all or some runs."""
    for text, rows in table[table[DOUBT] != ""].groupby(DOUBT, sort=False):
        warn(f"{len(rows)} of {len(table)} runs: {text}")


def _provenance(
    package: Package,
    swept: list[str],
    names: list[str],
    until: float,
    common: Mapping[str, float],
) -> dict[str, Any]:
    variables = [package.variables[name] for name in [*swept, *common, *names]]
    return {
        "units": {v.name: v.unit for v in variables} | {UNTIL: "s"},
        "display_units": {v.name: v.display_unit for v in variables if v.display_unit},
        "until": until,
        "swept": swept,
        "fmu": package.version,
    }
