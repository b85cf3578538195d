"""One run of a sweep: what it is made of, what distinguishes it from others, and its row."""

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from typing import Any

from ..errors import DomainError, RefusedError
from ..run.hammer import Hammer
from ..run.run import play
from ..scene import quantities
from ..scene.band import sides
from ..scene.signals import Signal, instants_of, points_in, signals_of
from ..scene.variables import STEP, VARIABLES, model
from .longrun import KIND, Wanted, answered
from .store import RUN

#: Columns beside parameters and outputs: what tells runs apart, how long one is, of which
#: model, what it was refused for, and what was doubtful.
ROWS = 5  # version of what a row has
CASE, UNTIL, MODEL, ERROR, WARNING = "case", "until", "model", "error", "warning"
#: Marks a row that is returned and not stored.
PASSING = "passing"
#: One row of the table.
Row = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """What the runs of a sweep need besides their grid point.

    Inputs and the controller act at communication points, so a case that has one of them has
    a ``step`` too: that of `simulate` if it gives none.
    """

    #: The point of the grid is laid over these.
    parameters: Mapping[str, float] = field(default_factory=dict)
    #: Inputs over time, as `simulate` takes them.
    inputs: Mapping[str, Signal] = field(default_factory=dict)
    #: Called with the hammer before each step. Each run has a copy of its own.
    control: Callable[[Hammer], None] | None = None
    step: float | str | None = None
    #: Tells the rows of one state of the code from those of another in a sweep's file.
    version: int | str | None = None

    @property
    def moves(self) -> bool:
        """Returns whether inputs change during the run."""
        return bool(self.inputs) or self.control is not None

    def identity(self, name: str) -> list[Any]:
        """Returns a key that distinguishes its rows from others: its data and its code's version.

        Raises:
            DomainError: it has code and no version.
        """
        if not self.moves:
            return []
        codes = [f"the input {n}" for n, s in self.inputs.items() if callable(s)]
        codes += ["the controller"] if self.control else []
        if codes and self.version is None:
            raise DomainError(
                f"the case {name!r} has code ({', '.join(codes)}): to keep its rows in a file, "
                "give it a version (version=1), and another one when the code changes"
            )
        data = {n: _data(n, s) for n, s in self.inputs.items() if not callable(s)}
        return [self.version, data, codes, quantities.duration(self.step or STEP, "step")]


def _data(name: str, signal: Signal) -> Any:
    """Returns an input (a number or a Series) as numbers."""
    if points := points_in(name, signal):
        return [part.tolist() for part in points]
    return VARIABLES.settable(name).number(signal)


@dataclass(frozen=True)
class Job:
    """One run of a sweep: all that a worker must know of it."""

    #: What makes it the same run: the model, all that is set, how long, what is read.
    key: str
    #: Of the case.
    name: str
    case: Case
    numbers: Mapping[str, float]
    #: How long it is, s, or how its long-run response is sought.
    until: float | Wanted
    #: What is read at its end, or the columns of its response.
    names: Sequence[str]

    def played(self) -> Row:
        """Runs what Python acts on and returns the final values."""
        assert not isinstance(self.until, Wanted)
        try:
            signals = signals_of(self.case.inputs)
            start = {name: signal(0.0) for name, signal in signals.items()}
            with Hammer(dict(self.numbers) | start, quiet=True) as hammer:
                instants = instants_of(self.until, self.case.step)
                play(hammer, instants, signals, [], control=deepcopy(self.case.control))
                hammer.check()
                return self.result(hammer.reader(self.names)(), "", hammer.warnings)
        except RefusedError as error:
            return self.result([], str(error), [])
        except Exception as error:
            # Any other error comes from the user's input or controller. It may be temporary (a full
            # disk, a lost connection), so the next sweep tries again.
            return self.result([], f"{type(error).__name__}: {error}", []) | {PASSING: True}

    def row(self, values: Sequence[float], refused: str, warnings: Sequence[str]) -> Row:
        """The row of what the engine answers, or why it does not."""
        if refused or not isinstance(self.until, Wanted):
            return self.result(values, refused, warnings)
        found = answered(values, self.numbers, warnings)
        row = self.result([math.nan] * len(self.names), "", found.warnings)
        means = [name for name in self.names if name in found.outputs.index]
        row |= {KIND: found.kind, "blows": found.blows, "reached": float(found.reached)}
        row |= {name: float(found.mean[name]) for name in means}
        row |= sides(row, self.numbers)
        return row | {f"{name}_error": float(found.error[name]) for name in means}

    def result(self, values: Sequence[float], refused: str, warnings: Iterable[str]) -> Row:
        """Returns the row of a run: the requested outputs, empty if the run was refused."""
        row: Row = {RUN: self.key, CASE: self.name, **self.numbers}
        end = math.nan if isinstance(self.until, Wanted) else self.until
        row |= {UNTIL: end, MODEL: model()}
        read = [math.nan] * len(self.names) if refused else values
        row |= dict(zip(self.names, read, strict=True))
        row |= sides(row, self.numbers)
        if KIND in self.names:
            row[KIND] = ""
        note = "" if refused else "; ".join(dict.fromkeys(warnings))
        return row | {ERROR: refused, WARNING: note}


def planned(
    name: str,
    case: Case,
    points: Sequence[Mapping[str, float]],
    *,
    until: float | Wanted,
    names: Sequence[str],
    stored: bool,
) -> list[Job]:
    """Returns the checked runs of a case over the grid; ``kept``: rows go to a file."""
    code = case.identity(name) if stored else []
    if case.moves and not isinstance(until, Wanted):
        signals_of(case.inputs)
        instants_of(until, case.step)
    runs = []
    for point in points:
        for text in {*case.inputs} & {*point}:
            raise DomainError(f"{text} is in the grid and an input of the case {name!r}")
        numbers = {**case.parameters, **point}
        end = asdict(until) if isinstance(until, Wanted) else until
        text = json.dumps([ROWS, model(), sorted(numbers.items()), end, names, name, code])
        key = hashlib.sha256(text.encode()).hexdigest()[:16]
        runs.append(Job(key, name, case, numbers, until, names))
    return runs
