"""From parameters to a table: `simulate`, and one row per blow: `blows`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from tqdm import tqdm

from . import journal, quantities
from .errors import DomainError, DthHammerError
from .gradients import column
from .hammer import Hammer
from .instance import warn
from .mesh import members
from .package import Package, load
from .variables import Array, Value, Variable

#: An input over time: a number, a function of time, or a table that is interpolated.
Signal = float | str | Callable[[float], float] | pd.Series
#: Most points that a run may have: beyond, a unit is likely wrong.
POINTS = 1e8
#: What a table of blows takes from the outputs.
PER_BLOW = ("blow_time", "blow_period", "blow_speed", "blow_energy", "blow_penetration", "rop")


def simulate(
    parameters: Mapping[str, Value] | None = None,
    until: float | str | None = None,
    inputs: Mapping[str, Signal] | None = None,
    *,
    preset: str | None = None,
    step: float | str | None = None,
    times: Sequence[float | str] | Array | None = None,
    outputs: Iterable[str] | None = None,
    waves: bool = False,
    gradient: Iterable[str] = (),
    control: Callable[[Hammer], None] | None = None,
    fmu: str | Path | Package | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Runs a hammer and returns its outputs over time, units in ``attrs["units"]``.

    Args:
        parameters: by dotted name: a number in the declared unit, a label of an
            enumeration, or text with a unit (``"60 mm"``). What is not given is the
            FMU's own start value.
        until: seconds to simulate, or text with a unit (``"500 ms"``); the FMU's proposal
            if not given.
        inputs: over time: a number, a function of time, or a Series over rising instants
            (held before its first and after its last). Between communication points they
            are straight lines, handed over as derivatives.
        preset: parameter set to start from, see `dth-hammer info`.
        step: communication step, as ``until``; the FMU's proposal if not given. The
            physics does not depend on it: it is how often one looks.
        times: instants to look at instead of a step.
        outputs: names to read; all outputs and local variables if not given.
        waves: reads also stress and velocity along piston and bit, as many columns as the
            mesh needs; `dth_hammer.waves` makes a diagram of them.
        gradient: parameters and inputs by which the outputs are differentiated, exactly and
            through every event; an input stands for a constant added to it all along. The
            derivatives are columns ``"rop per rock.stiffness"``; `dth_hammer.gradient` sorts
            them out. Those of energies, impulses and peaks cost more, and are there if
            ``outputs`` names them.
        control: called with the hammer at each communication point before the step,
            for instance to set tunable parameters by depth.
        fmu: file to use instead of the one found.
        progress: shows a progress bar.
    """
    package = load(fmu)
    instants = instants_of(package, until, step, times)
    named = [package.variables[n] for n in outputs] if outputs else []
    chosen = named or package.variables.of("output", "local")
    if waves:
        along = members(package, package.values(preset, parameters))
        chosen = [*({v.name: v for v in [*chosen, *along]}.values())]
    signals = signals_of(package, inputs)
    start = {n: s(0.0) for n, s in signals.items()} | dict(parameters or {})
    rows, slopes = [], []
    by = [*dict.fromkeys(gradient)]
    kept: dict[str, list[float]] = {name: [] for name in package.journal}
    asked = [v.name for v in chosen] if named else []
    with Hammer(start, preset=preset, fmu=package, gradient=by, gradient_of=asked) as hammer:
        read = hammer.reader([v.name for v in chosen])
        smooth = hammer.slopes.differentiable(v.name for v in chosen) if by else []
        for _ in _bar(play(hammer, instants, signals, control), len(instants), progress):
            rows.append(read())
            for name, values in hammer.step_blows().items():
                kept[name].extend(values)
            if by:
                slopes.append(hammer.slopes.of(smooth))
        whole = all(len(values) == hammer["blow_count"] for values in kept.values())
        told = [*hammer.doubts]
    frame = _frame(instants, rows, chosen, package, package.values(preset, parameters))
    frame.attrs["doubts"] = told
    # Not whole: a step had more blows than the FMU keeps, or `control` made steps of its own.
    if kept and whole:
        frame.attrs[journal.KEY] = package.journal.attributes(kept)
    return _with_slopes(frame, slopes, smooth, by, package) if by else frame


def _with_slopes(
    frame: pd.DataFrame, slopes: list[Array], smooth: list[str], by: list[str], package: Package
) -> pd.DataFrame:
    """The table with its derivatives, and the values that elasticities need."""
    table = np.array(slopes)
    columns = {
        column(output, name): table[:, i, k]
        for i, output in enumerate(smooth)
        for k, name in enumerate(by)
    }
    starts = {name: package.variables[name].start or 0.0 for name in by}
    whole = pd.concat([frame, pd.DataFrame(columns, index=frame.index)], axis=1)
    given = frame.attrs["parameters"]
    whole.attrs = frame.attrs | {"gradient": {n: given.get(n, starts[n]) for n in by}}
    return whole


def blows(frame: pd.DataFrame) -> pd.DataFrame:
    """One row a blow of a run, in the units that its table has.

    The FMU tells `simulate` every blow, so that the rows do not depend on how often one looked,
    nor on the outputs read. A table of another origin needs the output ``blow_count``: where it
    rises by more than 1 from row to row, the last blow is all that is known, and a warning says so.
    """
    if journal.KEY in frame.attrs and frame.index.name == "time":
        return journal.table(frame, PER_BLOW)
    if "blow_count" not in frame:
        raise DthHammerError("no blow_count in the table: blows are told from it")
    risen = frame["blow_count"].diff()
    last = risen.fillna(frame["blow_count"]) > 0
    if hidden := int((risen[risen > 1] - 1).sum()):
        warn(f"{hidden} blows are missing: between two rows only the last one is known")
    # A period and a penetration belong to the blow that completes them.
    table = frame.loc[last, [c for c in PER_BLOW if c in frame]].reset_index(drop=True)
    table.index = pd.Index(frame.loc[last, "blow_count"].astype(int), name="blow")
    table.attrs = frame.attrs | {"units": {c: unit(frame, c) for c in map(str, table)}}
    return table


def unit(frame: pd.DataFrame, column: str) -> str:
    """Unit of a column."""
    return str(frame.attrs.get("units", {}).get(column, ""))


def instants_of(
    package: Package,
    until: float | str | None,
    step: float | str | None,
    times: Sequence[float | str] | Array | None = None,
) -> Array:
    """The communication points of a run, s."""
    if times is not None:
        return _rising(times, "times", twice=True)
    end = package.stop if until is None else quantities.duration(until, "until")
    size = package.step if step is None else quantities.duration(step, "step")
    if end / size > POINTS:
        raise DomainError(f"{end:g} s in steps of {size:g} s are more than {POINTS:.0e} points")
    # Points k * step, the last one exactly at the end.
    count = max(1, int(np.ceil(end / size - 1e-9)))
    return np.append(np.arange(count) * size, end)


def _rising(times: Iterable[Any], name: str, twice: bool = False) -> Array:
    """Instants in seconds, from numbers, text with units, or timedeltas."""
    index = pd.Index(times)
    if isinstance(index, pd.TimedeltaIndex):
        instants = index.total_seconds().to_numpy()
    elif isinstance(index, pd.DatetimeIndex):
        raise DomainError(f"{name} must be seconds since the start, not dates")
    else:
        instants = np.array([quantities.seconds(t, f"{name}[{i}]") for i, t in enumerate(index)])
    if not len(instants):
        raise DomainError(f"{name} has no instant")
    if twice and instants[0] < 0.0:
        raise DomainError(f"{name} begins at {instants[0]:g} s, before the start")
    steps = np.diff(instants)
    falls = np.flatnonzero((steps < 0.0) if twice else (steps <= 0.0))
    if len(falls):
        here, there = instants[falls[0]], instants[falls[0] + 1]
        raise DomainError(f"{name} must rise, but {here:g} s is followed by {there:g} s")
    return np.asarray(instants, dtype=float)


def signals_of(
    package: Package, inputs: Mapping[str, Signal] | None
) -> dict[str, Callable[[float], float]]:
    """Inputs as functions of time, looked at."""
    return {name: _signal(package, name, signal) for name, signal in (inputs or {}).items()}


def play(
    hammer: Hammer,
    instants: Array,
    signals: Mapping[str, Callable[[float], float]],
    control: Callable[[Hammer], None] | None,
) -> Iterator[float]:
    """Steps a hammer from instant to instant, and yields at each."""
    for now in map(float, instants):
        if now > 0.0:
            _exchange(hammer, signals, now, control)
        yield now


def _signal(package: Package, name: str, signal: Signal) -> Callable[[float], float]:
    variable = package.variables.settable(name)
    if not variable.tunable:
        raise DomainError(f"{name} is fixed: it can be no input over time")
    if isinstance(signal, pd.Series):
        instants = _rising(signal.index, f"the index of {name}")
        values = np.array([variable.number(value) for value in signal])
        return lambda t: float(np.interp(t, instants, values))
    if callable(signal):
        return lambda t: variable.number(signal(t))
    number = variable.number(signal)
    return lambda _: number


def _exchange(
    hammer: Hammer,
    signals: Mapping[str, Callable[[float], float]],
    to: float,
    control: Callable[[Hammer], None] | None,
) -> None:
    if signals:
        size = to - hammer.time
        values = {name: signal(hammer.time) for name, signal in signals.items()}
        hammer.set(values)
        ports = [n for n in signals if hammer.variables[n].causality == "input"]
        if size > 0.0 and ports:
            hammer.set_slopes({n: (signals[n](to) - values[n]) / size for n in ports})
    if control:
        control(hammer)
    hammer.advance(to)


def _bar(items: Iterable[Any], total: int, shown: bool) -> Iterable[Any]:
    return tqdm(items, total=total, unit="step", disable=not shown, leave=False)


def _frame(
    instants: Array,
    rows: list[list[float]],
    variables: list[Variable],
    package: Package,
    parameters: Mapping[str, float],
) -> pd.DataFrame:
    columns: dict[str, Any] = {}
    for variable, values in zip(variables, np.array(rows).T, strict=True):
        if variable.kind == "Boolean":
            columns[variable.name] = values > 0.5
        elif variable.labels:
            codes = {value: code for code, value in enumerate(variable.labels)}
            taken = [codes[int(v)] for v in values]
            columns[variable.name] = pd.Categorical.from_codes(
                taken, pd.Index([*variable.labels.values()])
            )
        elif variable.counts:
            columns[variable.name] = values.astype(np.int64)
        else:
            columns[variable.name] = values
    frame = pd.DataFrame(columns, index=pd.Index(instants, name="time"))
    frame.attrs = {
        "units": {"time": "s"} | {v.name: v.unit for v in variables},
        "display_units": {v.name: v.display_unit for v in variables if v.display_unit},
        "descriptions": {v.name: v.description for v in variables},
        "parameters": dict(parameters),
        "fmu": package.version,
    }
    return frame
