"""Many runs over a grid of parameters; resumable; one row per run."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, nullcontext
from pathlib import Path
from typing import Any, TypeAlias, TypeGuard

from ..contract import typed
from ..errors import DomainError, InterruptedSweepError, LostWorkerError, UnknownNameError, warn
from ..extras import bar
from ..frames import np, pd
from ..scene import quantities
from ..scene.band import SIDES, with_sides
from ..scene.hammers import Hammerlike, Rocklike, scene_of
from ..scene.variables import VARIABLES, Value, model
from ..scene.variables import numbers as checked
from ..simulation.hammer import Hammer
from . import longrun
from .cases import CASE, ERROR, MODEL, PASSING, UNTIL, WARNING, Case, Job, planned
from .longrun import KIND, MEANS, Wanted, unit
from .store import RUN, TEXTS, Store
from .workers import parts_of

#: An executor, or the number of the engine's threads.
Workers = tuple[Executor | None, int | None]

Grid: TypeAlias = (
    "Mapping[str, Value | Collection[Value]] | Sequence[Mapping[str, Value]] | pd.DataFrame"
)
#: Columns of a long-run response in addition to its means.
LONG: Mapping[str, Any] = {KIND: str, "blows": "Int64", "reached": "boolean"}
RESULTS = (
    "blow_count",
    "blow_period",
    "blow_speed",
    "blow_energy",
    "blow_penetration",
    "rop",
    "rop_mean",
    "tip_rate",
    "tip_rate_mean",
    "tip_depth",
    "energy_drive",
    "energy_residual",
    "stalled",
)


@typed()
def sweep(
    hammers: Grid,
    until: float | str,
    *,
    base: Hammerlike = None,
    preset: str | None = None,
    rock: Rocklike = None,
    cases: Mapping[str, Hammerlike] | None = None,
    control: Callable[[Hammer], None] | None = None,
    step: float | str | None = None,
    version: int | str | None = None,
    outputs: Iterable[str] | None = None,
    out: str | Path | None = None,
    scheduler: Executor | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Runs every hammer of a grid and returns one row per run. For long-run means, use `steady`.

    The columns ``rop_low`` and ``rop_high`` are the range of the rate of penetration due to that of
    the rock's specific energy.

    Args:
        hammers: values by parameter (all combinations; a single value is shared by all), or one row
            per run: a DataFrame, or a list of parameters by name.
        until: duration of each run, s, or text with a unit.
        base: the hammer, as for `simulate`, whose parameters and inputs all runs share unless the
            grid overrides them.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        cases: variants of the base by name, for each of which the grid is run: a rock, a preset, a
            `Scene` with its inputs. The column ``case`` has the name.
        control: called with the hammer before each step; each run has its own copy.
        step: communication step of inputs and control; by default that of `simulate`.
        version: version of your functions; with ``out``, it is required if an input or the control
            is a function, so that rows of old and new code are not mixed.
        outputs: names to read at the end of a run.
        out: Parquet or CSV file for the rows. Until the sweep is complete, they are stored in a
            folder next to it. The same call later runs only the missing rows, and another grid adds
            its rows to the file.
        scheduler: an executor of `concurrent.futures`: a pool of processes, or a Dask client's
            (``client.get_executor()``). By default the engine's threads make the runs, and Python
            makes those with inputs or controllers one after the other.
        workers: number of the engine's threads; by default one per core.
        progress: shows a progress bar.

    Raises:
        OutputError: ``out`` cannot be written, or another sweep is writing it.
        LostWorkerError: a worker was killed; the message says which rows are saved.

    If the engine refuses a run, its message is in the column ``error``; warnings are in
    ``warning``. An exception of an input or a controller is also in ``error``; such a row is not
    saved in ``out``, so the same call tries it again.

    Example:
        >>> from dth_hammer import sweep
        >>> read = ["blow_count", "blow_speed"]
        >>> table = sweep({"feed_force": [4e3, 8e3]}, "200 ms", outputs=read)
        >>> print(table[["feed_force", *read]].round(2).to_string(index=False))
         feed_force  blow_count  blow_speed
             4000.0           5       11.55
             8000.0           5       11.37
    """
    end, by = quantities.duration(until, "until"), (scheduler, workers)
    shared, made = scene_of(base, rock, preset), {}
    for name, hammer in ({"": None} if cases is None else cases).items():
        case = scene_of(hammer)
        inputs = {**shared.inputs, **case.inputs}
        made[name] = Case(case.over(shared.numbers), inputs, control, step, version)
    named = cases is not None
    return table_of(
        hammers, end, made, named=named, outputs=outputs, out=out, by=by, progress=progress
    )


def table_of(
    grid: Grid,
    end: float | Wanted,
    cases: Mapping[str, Case],
    *,
    named: bool = False,
    outputs: Iterable[str] | None = None,
    out: str | Path | None = None,
    by: Workers = (None, None),
    progress: bool = False,
) -> pd.DataFrame:
    """Returns a row for each point of a grid, as `sweep` does."""
    names = columns(outputs, steady=isinstance(end, Wanted))
    if by[1] is not None and by[1] < 1:
        raise DomainError(f"workers = {by[1]} is not a whole number above 0")
    rows: Iterable[object] = itertools.count(1)
    if isinstance(grid, pd.DataFrame) and grid.index.name == "row":
        rows = [*grid.index]
    points = [_checked(row, point) for row, point in zip(rows, _points(grid), strict=False)]
    if not cases:
        raise DomainError("cases is empty: give at least one, or leave it out")
    stored = out is not None
    plan = [
        run
        for name, case in cases.items()
        for run in planned(name, case, points, until=end, names=names, stored=stored)
    ]
    keys = [run.key for run in plan]
    runs = {run.key: run for run in plan}
    settings = [*dict.fromkeys(name for run in plan for name in run.numbers)]
    listed = with_sides(names)
    store = Store(Path(out)) if out is not None else None
    with store.alone() if store else nullcontext():
        done = pd.DataFrame()
        if store:
            written = [UNTIL, *listed, ERROR, WARNING, MODEL]
            done = store.whole({key: [*run.numbers, *written] for key, run in runs.items()})
        tables = _run(runs, done, store, by, progress)
        if store:
            store.finish()
    table = _whole(tables, keys, [CASE, *settings] if named else settings, listed)
    table.attrs |= _provenance([*points[0]], listed, settings)
    if isinstance(end, Wanted):
        del table[UNTIL]
    else:
        table.attrs |= {"until": end, "units": table.attrs["units"] | {UNTIL: "s"}}
    for text, rows in table[table[WARNING] != ""].groupby(WARNING, sort=False):
        warn(f"{len(rows)} of {len(table)} runs: {text}")
    return table


def columns(outputs: Iterable[str] | None, *, steady: bool) -> list[str]:
    """Returns the outputs to read from a run, or the columns of a long-run response."""
    if not steady:
        return [VARIABLES[name].name for name in (RESULTS if outputs is None else outputs)]
    means = [longrun.named(name) for name in (MEANS if outputs is None else outputs)]
    return [*LONG, *means, *(f"{name}_error" for name in means)]


def unit_of(name: str) -> str:
    """Returns the unit of a column."""
    if name in LONG:
        return "1"
    return unit(output_of(name)) if output_of(name) in MEANS else VARIABLES[output_of(name)].unit


def output_of(column: str) -> str:
    """Returns the output to which a column of errors or ranges belongs, or the column itself."""
    name = column.removesuffix("_error")
    for side in SIDES:
        name = name.removesuffix(side)
    return name


def _run(
    runs: Mapping[str, Job],
    done: pd.DataFrame,
    store: Store | None,
    by: Workers,
    progress: bool,
) -> list[pd.DataFrame]:
    """Returns the rows that are done, and runs and stores the missing ones."""
    tables = [done[done[RUN].isin(runs)].drop_duplicates(RUN)] if len(done) else []
    known = set(tables[0][RUN]) if tables else set()
    missing = [run for key, run in runs.items() if key not in known]
    if not missing:
        return tables
    counts = {"total": len(runs), "initial": len(known), "unit": "run", "leave": True}
    progress_bar = bar(progress, **counts) or nullcontext()
    # Closing it stops the workers after Ctrl-C.
    with progress_bar as shown, closing(parts_of(missing, *by)) as parts:
        try:
            for rows in parts:
                if shown is not None:
                    shown.update(len(rows))
                passing = [row.pop(PASSING, False) for row in rows]
                tables.append(pd.DataFrame(rows))
                if store and not all(passing):
                    store.add(tables[-1][~np.array(passing)])
        except (KeyboardInterrupt, LostWorkerError) as error:
            if isinstance(error, LostWorkerError):
                raise LostWorkerError(f"{error}; {_stored_in_words(runs, store)}") from None
            raise InterruptedSweepError(f"stopped; {_stored_in_words(runs, store)}") from None
    return tables


def _stored_in_words(runs: Mapping[str, Job], store: Store | None) -> str:
    """Returns how many of these runs are stored, and how to continue."""
    if store is None:
        return "nothing is kept: give a file to keep runs in"
    # Counted again, because a part may have been complete when the interrupt came.
    found = store.rows()
    count = int(found[RUN].isin(runs).sum()) if len(found) else 0
    beside = f"runs are kept beside {store.path}"
    return f"{count} of {len(runs)} {beside}: the same call goes on from there"


def _whole(
    tables: list[pd.DataFrame],
    keys: list[str],
    settings: list[str],
    names: list[str],
) -> pd.DataFrame:
    """Returns one row per grid point, in order, with the columns that exist."""
    table = pd.concat(tables, ignore_index=True) if len(tables) > 1 else tables[0]
    table = table.set_index(RUN).loc[keys].reset_index()
    table = table[[RUN, *settings, UNTIL, *names, ERROR, WARNING, MODEL]]
    for name in (RUN, *settings, UNTIL, ERROR, WARNING, MODEL):
        dtype: Any = str if name in TEXTS else float
        table[name] = table[name].astype(dtype)
        if dtype is float and name != UNTIL:
            # If only other cases set a parameter, this case has its start value.
            table[name] = table[name].fillna(VARIABLES[name].start)
    for name in names:
        kind: Any = LONG.get(name, float)
        if name in VARIABLES:
            kind = "boolean" if VARIABLES[name].kind == "Boolean" else kind
            kind = "Int64" if VARIABLES[name].counts else kind
        table[name] = table[name].astype(kind if kind is str else float).astype(kind)
    return table


def _checked(row: object, point: Mapping[str, Any]) -> dict[str, float]:
    """Returns the checked numbers of a row of a table; an error names the row."""
    try:
        return checked(None, point)
    except UnknownNameError:
        raise
    except DomainError as error:
        raise DomainError(f"row {row}: {error}") from None


def _points(grid: Grid) -> list[dict[str, Any]]:
    if isinstance(grid, pd.DataFrame):
        if len(twice := grid.columns[grid.columns.duplicated()]):
            raise DomainError(f"two columns of the table are {twice[0]}: leave one out")
        points = [{str(k): v for k, v in row.items()} for row in grid.to_dict("records")]
    elif not isinstance(grid, Mapping):
        points = [{**point} for point in grid if isinstance(point, Mapping)]
        if len(points) < len(grid) or any({*point} != {*points[0]} for point in points):
            raise DomainError("the rows of the grid must be parameters by name, the same in each")
    else:
        axes = {n: quantities.alike(v, n) if several(v) else [v] for n, v in grid.items()}
        for name, listed in axes.items():
            if not listed:
                raise DomainError(f"{name} has no value in the grid")
        points = [dict(zip(axes, p, strict=True)) for p in itertools.product(*axes.values())]
    if not points or not points[0]:
        raise DomainError("the grid is empty: name at least one parameter and its values")
    return points


def several(values: Value | Collection[Value]) -> TypeGuard[Collection[Value]]:
    """Returns whether these are several values of a parameter, not one."""
    listed = isinstance(values, Collection) and not isinstance(values, str | bytes | Mapping)
    return listed and getattr(values, "ndim", 1) > 0


def _provenance(varied: list[str], names: list[str], settings: list[str]) -> dict[str, Any]:
    outputs = {name: output_of(name) for name in [*settings, *names]}
    display = {n: VARIABLES[own].display_unit for n, own in outputs.items() if own in VARIABLES}
    return {
        "units": {name: unit_of(name) for name in outputs},
        "display_units": {name: unit for name, unit in display.items() if unit},
        "swept": varied,
        "model": model(),
    }
