"""Derivatives of runs: differences of exact runs, with errors, valid through events."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .. import _native
from ..errors import DomainError, DthHammerError, UnknownNameError
from ..frames import np, pd
from ..scene.variables import Array

if TYPE_CHECKING:
    from .hammer import Hammer

#: Word between output and parameter in the name of a derivative's column; suffix of the column with
#: its error.
PER, ERROR = " per ", "_error"
#: Above SHARP times output over parameter, a derivative is dropped, because the motion does not
#: settle. A warning is given if it is valid for less than the share NARROW of the parameter.
SHARP, NARROW = 1e4, 1e-7
#: Repeats a run with some numbers changed; returns the outputs, and the hammer at its end.
Rerun = Callable[[Mapping[str, float]], "tuple[Array, Hammer]"]


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of a run's results, one row per parameter."""

    #: Derivatives by each parameter, in the shape of the outputs; where events change their order,
    #: the mean of both sides.
    values: list[Array]
    #: Estimated errors of the derivatives, in the same shape.
    errors: list[Array]
    #: Change of each parameter, to first order, at which events change their order.
    reach: Array
    #: Reasons why derivatives are valid on one side at most, in words.
    nonsmooth: list[list[str]]


def derivatives(numbers: Mapping[str, float], by: Sequence[str], rerun: Rerun) -> Derivatives:
    """Returns the derivatives of a run with respect to parameters and inputs.

    Args:
        numbers: the numbers that were set.
        by: parameters and constant inputs.
        rerun: repeats the run with some numbers changed.
    """
    for _, why in _native.unread(dict(numbers), [*by]):
        raise DomainError(f"no derivative by a parameter that is not read: {why}")
    shape: list[tuple[int, ...]] = []

    def run(changed: Mapping[str, float]) -> tuple[Array, _native.Machine]:
        values, hammer = rerun(changed)
        shape[:] = [values.shape]
        return np.ascontiguousarray(values, dtype=float).ravel(), hammer.machine

    rows = _native.derivatives(dict(numbers), differentiable(by), run)
    values, errors, reach, nonsmooth = ([*part] for part in zip(*rows, strict=True))
    values, errors = ([row.reshape(shape[0]) for row in part] for part in (values, errors))
    return Derivatives(values, errors, np.array(reach), nonsmooth)


def warnings_of(found: Derivatives, rows: Array, at: Mapping[str, float]) -> list[str]:
    """Replaces meaningless derivatives by NaN, and returns warnings about doubtful ones.

    If a motion does not settle, each blow multiplies a small change by ten or more. Its derivatives
    grow without bound, and are valid only for tiny changes.

    Args:
        found: the derivatives of the rows.
        rows: the outputs, one column each.
        at: values of the parameters.
    """
    texts, sizes = [], np.abs(rows).max(axis=0)
    for k, (name, value) in enumerate(at.items()):
        scale = abs(value) or 1.0
        lost = np.abs(found.values[k]) * scale > SHARP * sizes
        found.values[k][lost] = found.errors[k][lost] = np.nan
        meant = "`trend` tells what means depend on"
        if lost.any() or np.isnan(found.values[k]).any():
            texts.append(f"not smooth in {name}: the motion does not settle; {meant}")
        elif found.nonsmooth[k]:
            why = "; ".join(dict.fromkeys(found.nonsmooth[k][:2]))
            texts.append(f"derivatives by {name} hold on one side at most ({why}); {meant}")
        elif found.reach[k] < NARROW * scale:
            part = found.reach[k] / scale
            texts.append(f"derivatives by {name} hold for {part:.1g} of it at most; {meant}")
    return texts


def differentiable(names: Iterable[str]) -> list[str]:
    """Returns the names, each once; raises an error if there is no derivative by one of them."""
    known, chosen = _native.ARGUMENTS, [*dict.fromkeys(names)]
    for name in chosen:
        if name not in known:
            raise UnknownNameError("parameter or input with derivatives", name, known)
    return chosen


def column(output: str, by: str) -> str:
    """Returns the name of the column of a derivative."""
    return f"{output}{PER}{by}"


def with_derivatives(frame: pd.DataFrame, found: Derivatives, by: Iterable[str]) -> pd.DataFrame:
    """Returns a run's table with columns for each derivative of a numeric output and its error."""
    columns = {
        column(str(output), name) + ending: values[:, i]
        for i, output in enumerate(frame)
        if frame[output].dtype.kind in "fiub"
        for name, *pair in zip(by, found.values, found.errors, strict=True)
        for ending, values in zip(("", ERROR), pair, strict=True)
    }
    whole = pd.concat([frame, pd.DataFrame(columns, index=frame.index)], axis=1)
    whole.attrs = frame.attrs
    return whole


def derivatives_in(
    frame: pd.DataFrame, by: Mapping[str, float], *, errors: bool = False
) -> pd.DataFrame:
    """Returns the derivatives that a run's table has as columns, or their errors.

    Derivatives with respect to a parameter in ``by``, which has its value, are made elasticities.
    """
    names = [str(c) for c in frame if PER in str(c) and not str(c).endswith(ERROR)]
    if not names:
        raise DthHammerError("no derivatives in this run: simulate(..., gradient=[...])")
    pairs = [tuple(name.split(PER)) for name in names]
    table = frame[[name + ERROR * errors for name in names]].copy()
    table.columns = pd.MultiIndex.from_tuples(pairs, names=["output", "by"])
    for output, name in pairs:
        if name in by:
            table[output, name] *= by[name] / frame[output]
    return table.abs() if errors else table
