"""One run of a sweep: what it is made of, what tells it from others, what it gives."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

from .errors import DomainError, RefusedError
from .fingerprint import digest
from .hammer import Hammer
from .run import Signal, instants_of, play, signals_of
from .store import RUN
from .variables import Value, model
from .variables import numbers as checked

#: Columns beside parameters and outputs: what tells runs apart, how long one is, of which
#: model, what it was refused for, and what was doubtful.
ROWS = 3  # version of what a row has
CASE, UNTIL, MODEL, ERROR, WARNING = "case", "until", "model", "error", "warning"
#: One row of the table.
Row = dict[str, Any]


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

    def digest(self, name: str) -> str:
        """What tells its inputs and its controller from others, code and all.

        Raises:
            DomainError: they hold something that no digest can be made of, such as a lock.
        """
        if not self.moves:
            return ""
        try:
            return digest((dict(self.inputs), self.control, self.step))
        except Exception as error:
            raise DomainError(
                f"no rows can be kept of the case {name!r}, because nothing tells its code and "
                f"data from an edited version ({error}): call without `out`, or let the "
                "controller make such things when it is first called"
            ) from None


@dataclass(frozen=True)
class Run:
    """One run of a sweep: all that a worker must know of it."""

    #: What makes it the same run: the model, all that is set, how long, what is read.
    key: str
    #: Of the case.
    name: str
    case: Case
    numbers: Mapping[str, float]
    until: float
    #: What is read at its end.
    names: Sequence[str]

    def row(self) -> Row:
        """Runs it, and tells its end."""
        try:
            start = {name: s(0.0) for name, s in signals_of(self.case.inputs).items()}
            with Hammer(dict(self.numbers) | start, quiet=True) as hammer:
                self._played(hammer)
                return self.result(hammer.reader(self.names)(), "", hammer.warnings)
        except RefusedError as error:
            return self.result([], str(error), [])
        except Exception as error:
            # Only what a user wrote, an input or a controller, raises anything else.
            if not self.case.moves:
                raise
            return self.result([], f"{type(error).__name__}: {error}", [])

    def _played(self, hammer: Hammer) -> None:
        if self.case.moves:
            instants = instants_of(self.until, self.case.step)
            signals = signals_of(self.case.inputs)
            play(hammer, instants, signals, [], control=deepcopy(self.case.control))
        else:
            # One communication step: the result does not depend on it.
            hammer.advance(self.until)

    def result(self, values: Sequence[float], refused: str, warnings: Iterable[str]) -> Row:
        """The row of a run: values of what is read, none of them if it was refused."""
        row: Row = {RUN: self.key, CASE: self.name, **self.numbers}
        row |= {UNTIL: self.until, MODEL: model()}
        read = [math.nan] * len(self.names) if refused else values
        row |= dict(zip(self.names, read, strict=True))
        note = "" if refused else "; ".join(dict.fromkeys(warnings))
        return row | {ERROR: refused, WARNING: note}


def planned(
    name: str,
    case: Case,
    points: Sequence[Mapping[str, float]],
    *,
    common: Mapping[str, float],
    until: float,
    names: Sequence[str],
    stored: bool,
) -> list[Run]:
    """The runs of a case at every point of the grid, checked; ``kept``: rows go to a file."""
    shared = dict(common) | checked(case.preset, case.parameters)
    code = case.digest(name) if stored else ""
    if case.moves:
        signals_of(case.inputs)
        instants_of(until, case.step)
    runs = []
    for point in points:
        for text in {*case.inputs} & {*point}:
            raise DomainError(f"{text} is in the grid and an input of the case {name!r}")
        numbers = shared | dict(point)
        text = json.dumps([ROWS, model(), sorted(numbers.items()), until, names, name, code])
        key = hashlib.sha256(text.encode()).hexdigest()[:16]
        runs.append(Run(key, name, case, numbers, until, names))
    return runs
