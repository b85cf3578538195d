"""One run of a sweep: its settings, the key that distinguishes it from other runs, and its row."""

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from typing import Any

from ..errors import DomainError, RefusedError
from ..scene import quantities
from ..scene.band import sides
from ..scene.signals import Signal, instants_of, points_in, signals_of
from ..scene.variables import STEP, VARIABLES, model
from ..simulation.hammer import Hammer
from ..simulation.run import play
from .longrun import KIND, Wanted, answered
from .store import RUN

#: Version of the format of a row. It is part of a run's key, so old rows are not reused.
ROWS = 6
#: Columns beside parameters and outputs: name of the case, duration (s), version of the model,
#: the error of a refused run, and warnings.
CASE, UNTIL, MODEL, ERROR, WARNING = "case", "until", "model", "error", "warning"
#: Marks a row that is returned to the caller but not stored in the file.
PASSING = "passing"
Row = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """The settings that a run of a sweep needs besides its grid point.

    Inputs and the controller act at communication points, so a case with inputs or a controller
    also has a ``step``; by default it is that of `simulate`.
    """

    #: Parameters of all runs; those of the grid point override them.
    parameters: Mapping[str, float] = field(default_factory=dict)
    #: Inputs over time, as `simulate` takes them.
    inputs: Mapping[str, Signal] = field(default_factory=dict)
    #: Called with the hammer before each step. Each run has its own copy.
    control: Callable[[Hammer], None] | None = None
    step: float | str | None = None
    #: Version of the user's functions. Change it with them, so that a sweep's file does not mix
    #: rows of the old and the new code.
    version: int | str | None = None

    @property
    def needs_python(self) -> bool:
        """Whether Python code or changing inputs act during the run."""
        return bool(self.inputs) or self.control is not None

    def identity(self, name: str) -> list[Any]:
        """Returns the part of a row's key that tells this case from others: its data and version.

        Raises:
            DomainError: the case has functions but no version.
        """
        if not self.needs_python:
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
    """Returns a constant or tabulated input as plain numbers, which JSON can store."""
    if points := points_in(name, signal):
        return [part.tolist() for part in points]
    return VARIABLES.settable(name).number(signal)


@dataclass(frozen=True)
class Job:
    """One run of a sweep, with everything that a worker needs to simulate it."""

    #: Hash of the model's version, all settings, the duration and the requested outputs. Two runs
    #: with the same key have the same row.
    key: str
    name: str
    case: Case
    numbers: Mapping[str, float]
    #: Duration, s, or the accuracy to which the long-run response is computed.
    until: float | Wanted
    #: Outputs that are read at the end of the run, or the columns of the long-run response.
    names: Sequence[str]

    def played(self) -> Row:
        """Runs a hammer on which Python code or changing inputs act, and returns its row."""
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
            # disk, a lost connection), so the row is not stored and the next sweep tries again.
            return self.result([], f"{type(error).__name__}: {error}", []) | {PASSING: True}

    def row(self, values: Sequence[float], refused: str, warnings: Sequence[str]) -> Row:
        """Returns the row of a run, from the engine's values or from its reason for refusing it."""
        if refused or not isinstance(self.until, Wanted):
            return self.result(values, refused, warnings)
        response = answered(values, self.numbers, warnings)
        row = self.result([math.nan] * len(self.names), "", response.warnings)
        means = [name for name in self.names if name in response.outputs.index]
        row |= {KIND: response.kind, "blows": response.blows, "reached": float(response.reached)}
        row |= {name: float(response.mean[name]) for name in means}
        row |= sides(row, self.numbers)
        return row | {f"{name}_error": float(response.error[name]) for name in means}

    def result(self, values: Sequence[float], refused: str, warnings: Iterable[str]) -> Row:
        """Returns the row of a run with the requested outputs, which are NaN for a refused run."""
        row: Row = {RUN: self.key, CASE: self.name, **self.numbers}
        duration = math.nan if isinstance(self.until, Wanted) else self.until
        row |= {UNTIL: duration, MODEL: model()}
        outputs = [math.nan] * len(self.names) if refused else values
        row |= dict(zip(self.names, outputs, strict=True))
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
    """Returns the checked runs of a case, one for each grid point.

    Args:
        name: name of the case.
        case: settings of all runs.
        points: parameters of each grid point.
        until: duration, s, or the accuracy of the long-run response.
        names: outputs to read.
        stored: whether the rows go to a file; then functions of the case need a version.
    """
    identity = case.identity(name) if stored else []
    if case.needs_python and not isinstance(until, Wanted):
        signals_of(case.inputs)
        instants_of(until, case.step)
    runs = []
    for point in points:
        for text in {*case.inputs} & {*point}:
            raise DomainError(f"{text} is in the grid and an input of the case {name!r}")
        numbers = {**case.parameters, **point}
        end = asdict(until) if isinstance(until, Wanted) else until
        text = json.dumps([ROWS, model(), sorted(numbers.items()), end, names, name, identity])
        key = hashlib.sha256(text.encode()).hexdigest()[:16]
        runs.append(Job(key, name, case, numbers, until, names))
    return runs
