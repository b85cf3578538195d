"""Many runs over a grid of parameters, on Dask; resumable; one row per run."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from dask.base import tokenize
from dask.distributed import Client, as_completed
from tqdm import tqdm

from . import quantities
from .errors import DomainError, InterruptedSweepError, RefusedError
from .hammer import Hammer
from .instance import keep_loaded, warn
from .package import Package, load
from .run import Signal, instants_of, play, signals_of
from .store import TEXTS, Store
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
RUN, CASE, UNTIL, MODEL, ERROR, DOUBT = "run", "case", "until", "fmu", "error", "doubt"


@dataclass(frozen=True)
class Case:
    """What a run is made of beside its point of the grid; any part may be missing.

    Inputs and the controller act at communication points, so a case that has one of them has
    a ``step`` too: the FMU's proposal if it gives none.
    """

    #: Laid over those that all runs share; the point of the grid is laid over these.
    parameters: Mapping[str, Value] = field(default_factory=dict)
    preset: str | None = None
    #: Inputs over time, as `simulate` takes them.
    inputs: Mapping[str, Signal] = field(default_factory=dict)
    #: Called with the hammer before each step. Each run has a copy of its own.
    control: Callable[[Hammer], None] | None = None
    step: float | str | None = None

    @property
    def moves(self) -> bool:
        """Whether something acts on the way."""
        return bool(self.inputs) or self.control is not None

    def digest(self) -> str:
        """What tells its inputs and its controller from others, code and all."""
        return str(tokenize(dict(self.inputs), self.control, self.step)) if self.moves else ""


def sweep(
    grid: Grid,
    until: float | str,
    *,
    parameters: Mapping[str, Value] | None = None,
    preset: str | None = None,
    cases: Mapping[str, Case] | None = None,
    outputs: Iterable[str] = RESULTS,
    out: str | Path | None = None,
    scheduler: str | Client = "processes",
    workers: int | None = None,
    batch: int = 4,
    fmu: str | Path | Package | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Runs every point of a grid and returns one row per run.

    Args:
        grid: values by parameter (all combinations), or a DataFrame with one row per run.
        until: seconds of each run, or text with a unit.
        parameters: what all runs share, laid over the preset.
        preset: parameter set to start from.
        cases: by name, what is done with every point of the grid: rocks, inputs over time,
            controllers. The table has the name in the column ``case``.
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
    chosen = {"": Case()} if cases is None else dict(cases)
    if not chosen:
        raise DomainError("cases has no case")
    plan = [
        _Run(package, case, point, name=name, common=common, until=end, names=names)
        for name, case in chosen.items()
        for point in points
    ]
    keys = [run.key for run in plan]
    runs = {run.key: run for run in plan}
    store = Store(Path(out)) if out is not None else None
    done = store.rows() if store else pd.DataFrame()
    tables = [done[done[RUN].isin(keys)].drop_duplicates(RUN)] if len(done) else []
    known = set(tables[0][RUN]) if tables else set()
    missing = [run for key, run in runs.items() if key not in known]
    if missing:
        bar = tqdm(total=len(runs), initial=len(known), unit="run", disable=not progress)
        with bar, client_of(scheduler, workers) as client:
            try:
                for part in _results(client, list(_batches(missing, batch)), str(package.path)):
                    bar.update(len(part))
                    tables.append(part)
                    if store:
                        store.add(part, RUN)
            except KeyboardInterrupt:
                # As they are found again: a part may have come while it was being written.
                found = store.rows() if store else done
                kept = int(found[RUN].isin(keys).sum()) if len(found) else 0
                raise InterruptedSweepError(kept, len(runs), store and store.path) from None
    settings = [*dict.fromkeys(name for run in plan for name in run.numbers)]
    table = _whole(
        tables, keys, [CASE, *settings] if cases is not None else settings, names, package
    )
    table.attrs |= _provenance(package, [*points[0]], names, end, settings)
    if store:
        store.finish()
    _tell(table)
    return table


def counts(**numbers: Any) -> None:
    """Refuses what is no number of things."""
    for name, number in numbers.items():
        if number is not None and (not isinstance(number, int) or number < 1):
            raise DomainError(f"{name} = {number!r} is not a whole number above 0")


def _results(client: Client, batches: list[list[_Run]], fmu: str) -> Iterator[pd.DataFrame]:
    futures = [client.submit(_run_all, part, fmu, pure=False) for part in batches]
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
    for name in (RUN, *settings, UNTIL, ERROR, DOUBT, MODEL):
        kept: Any = str if name in TEXTS else float
        table[name] = table[name].astype(kept)
        if kept is float and name != UNTIL:
            # What one case sets and another does not is there the FMU's own.
            table[name] = table[name].fillna(package.variables[name].start)
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


class _Run:
    """One run of a sweep: all that a worker must know of it."""

    def __init__(
        self,
        package: Package,
        case: Case,
        point: Mapping[str, float],
        *,
        name: str,
        common: Mapping[str, float],
        until: float,
        names: Sequence[str],
    ) -> None:
        self.name, self.case, self.until, self.names = name, case, until, [*names]
        own = package.values(case.preset, case.parameters)
        self.numbers = dict(common) | own | dict(point)
        for text in {*case.inputs} & {*point}:
            raise DomainError(f"{text} is in the grid and an input of the case {name!r}")
        if case.moves:
            signals_of(package, case.inputs)
            instants_of(package, until, case.step)
        #: What makes a run the same run: the model, all that is set, how long, what is read.
        text = json.dumps(
            [ROWS, package.version, sorted(self.numbers.items()), until, names, name, case.digest()]
        )
        self.key = hashlib.sha256(text.encode()).hexdigest()[:16]

    def row(self, fmu: str) -> dict[str, Any]:
        """Runs it, and tells its end."""
        package = load(fmu)
        row = {RUN: self.key, CASE: self.name} | self.numbers
        row |= {UNTIL: self.until, MODEL: package.version}
        try:
            return row | self._end(package)
        except RefusedError as error:
            said = str(error)
        except Exception as error:
            # Only what a user wrote, an input or a controller, raises anything else.
            if not self.case.moves:
                raise
            said = f"{type(error).__name__}: {error}"
        return row | dict.fromkeys(self.names, math.nan) | {ERROR: said, DOUBT: ""}

    def _end(self, package: Package) -> dict[str, Any]:
        signals = signals_of(package, self.case.inputs)
        start = {name: signal(0.0) for name, signal in signals.items()} | self.numbers
        with Hammer(start, fmu=package, quiet=True) as hammer:
            if self.case.moves:
                instants = instants_of(package, self.until, self.case.step)
                for _ in play(hammer, instants, signals, deepcopy(self.case.control)):
                    pass
            else:
                # One communication step: the result does not depend on it.
                hammer.advance(self.until)
            return hammer.get(self.names) | {ERROR: "", DOUBT: "; ".join(hammer.doubts)}


def _batches(items: list[_Run], size: int) -> Iterator[list[_Run]]:
    for start in range(0, len(items), size):
        yield items[start : start + size]


def _run_all(runs: list[_Run], fmu: str) -> list[dict[str, Any]]:
    keep_loaded(load(fmu))
    return [run.row(fmu) for run in runs]


def _tell(table: pd.DataFrame) -> None:
    """Warns once of what is doubtful in all or some runs."""
    for text, rows in table[table[DOUBT] != ""].groupby(DOUBT, sort=False):
        warn(f"{len(rows)} of {len(table)} runs: {text}")


def _provenance(
    package: Package,
    swept: list[str],
    names: list[str],
    until: float,
    settings: list[str],
) -> dict[str, Any]:
    variables = [package.variables[name] for name in [*settings, *names]]
    return {
        "units": {v.name: v.unit for v in variables} | {UNTIL: "s"},
        "display_units": {v.name: v.display_unit for v in variables if v.display_unit},
        "until": until,
        "swept": swept,
        "fmu": package.version,
    }
