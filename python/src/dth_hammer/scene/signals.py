"""Inputs that change over time, and the instants at which outputs are read."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from ..errors import DomainError
from ..frames import np, pd
from . import quantities
from .variables import STEP, UNTIL, VARIABLES, Array

#: An input over time: a number, a function of time, or a Series that is interpolated.
Signal = Any
#: A checked input: a function of time, s.
Function = Callable[[float], float]
#: Most points of a run; with more, a unit is probably wrong.
POINTS = 1e8


def instants_of(
    until: float | str | None,
    step: float | str | None,
    times: Collection[float | str] | None = None,
) -> Array:
    """Returns the communication points of a run, s."""
    if times is not None:
        return _rising(times, "times", twice=True)
    end = UNTIL if until is None else quantities.duration(until, "until")
    size = STEP if step is None else quantities.duration(step, "step")
    if end / size > POINTS:
        raise DomainError(f"{end:g} s in steps of {size:g} s are more than {POINTS:.0e} points")
    # Points k * step, the last one exactly at the end.
    count = max(1, int(np.ceil(end / size - 1e-9)))
    return np.append(np.arange(count) * size, end)


def _rising(times: Iterable[Any], name: str, twice: bool = False) -> Array:
    """Returns rising instants in seconds, from numbers, text with units, or timedeltas."""
    try:
        index = pd.Index(times)
    except (TypeError, ValueError):
        raise DomainError(f"{name} = {times!r} is not a list of instants") from None
    if isinstance(index, pd.TimedeltaIndex):
        instants = index.total_seconds().to_numpy()
    elif isinstance(index, pd.DatetimeIndex):
        raise DomainError(f"{name} must be seconds since the start, not dates")
    else:
        listed = enumerate(quantities.alike(index, name))
        instants = np.array([quantities.seconds(t, f"{name}[{i}]") for i, t in listed])
    if not len(instants):
        raise DomainError(f"{name} has no instants")
    if twice and instants[0] < 0.0:
        raise DomainError(f"{name} begins at {instants[0]:g} s, before the start")
    steps = np.diff(instants)
    falls = np.flatnonzero((steps < 0.0) if twice else (steps <= 0.0))
    if len(falls):
        here, there = instants[falls[0]], instants[falls[0] + 1]
        raise DomainError(f"{name} must rise, but {here:g} s is followed by {there:g} s")
    return np.asarray(instants, dtype=float)


def signals_of(inputs: Mapping[str, Signal] | None) -> dict[str, Function]:
    """Returns the inputs as functions of time, checked."""
    return {name: _signal(name, signal) for name, signal in (inputs or {}).items()}


def _signal(name: str, signal: Signal) -> Function:
    variable = VARIABLES.settable(name)
    if not variable.tunable:
        raise DomainError(f"{name} is fixed: it cannot vary over time")
    if points := points_in(name, signal):
        return lambda t: float(np.interp(t, *points))
    if callable(signal):
        return lambda t: variable.number(signal(t))
    number = variable.number(signal)
    return lambda _: number


def of_file(path: Path) -> dict[str, Signal]:
    """Reads inputs over time from a file with a column ``time`` and one for each input."""
    from .. import tables  # noqa: PLC0415

    names = [v.name for v in VARIABLES.of("input")]
    frame = tables.rows_of(path, ["time", *names])
    if "time" not in frame:
        raise DomainError(f"{path.name} has no column time")
    index = [*frame.pop("time")]
    return {VARIABLES.settable(str(n)).name: pd.Series([*frame[n]], index) for n in frame}


def points_in(name: str, signal: Signal) -> tuple[Array, Array] | None:
    """Returns instants (s) and values if the input is a Series, otherwise None."""
    if not (hasattr(signal, "index") and hasattr(signal, "to_numpy")):
        return None
    instants, number = _rising(signal.index, f"the index of {name}"), VARIABLES[name].number
    return instants, np.array([number(value) for value in quantities.alike(signal, name)])
