"""The engine's table of quantities: names, units, domains, meanings, and the presets.

Nothing of it is written in this package: it is all read from the native module.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib import metadata
from typing import TYPE_CHECKING, Any

from .. import _native
from ..errors import DomainError, UnknownNameError
from . import quantities
from .rocks import beside

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Array = NDArray[Any]
else:
    Array = Any
#: What a user may write for a number.
Value = quantities.Value
#: A member of a family along the bodies, counted from 1.
INDEXED = re.compile(r"(\w+)\[([1-9]\d*)\]")
#: Communication step and duration, s, where none is given: those that the FMU proposes too.
STEP, UNTIL = _native.STEP, _native.UNTIL


@dataclass(frozen=True)
class Variable:
    """One variable."""

    name: str
    reference: int
    kind: str
    causality: str
    variability: str
    description: str
    unit: str = ""
    display_unit: str = ""
    start: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    #: The declared type, for instance Length or Count.
    quantity: str = ""
    #: Labels of an enumeration by value.
    labels: Mapping[int, str] = field(default_factory=dict)

    @property
    def settable(self) -> bool:
        """Whether it can be set."""
        return self.causality in ("parameter", "input")

    @property
    def counts(self) -> bool:
        """Whether the value is a count, although its port is a Real."""
        return self.quantity == "Count"

    @property
    def tunable(self) -> bool:
        """Whether it may be set between steps."""
        return self.causality == "input" or self.variability == "tunable"

    def number(self, value: Value) -> float:
        """The value in the declared unit, checked against the declared domain."""
        if self.labels and isinstance(value, str):
            number = self._label(value)
        else:
            number = quantities.read(value, self.unit, self.name)
        if not math.isfinite(number):
            raise DomainError(f"{self.name} must be finite, not {number}")
        if self.kind in ("Integer", "Enumeration") and number != int(number):
            raise DomainError(f"{self.name} must be a whole number, not {number}")
        if not self._holds(number):
            raise DomainError(f"{self.name} = {self.text(number)} is not {self.domain()}")
        return number

    def text(self, number: float) -> str:
        """Returns a number as it is written: a label, or with the declared unit."""
        if label := self.labels.get(int(number)) if self.labels else None:
            return label
        return f"{number:g} {self.unit if self.unit != '1' else ''}".rstrip()

    def _holds(self, number: float) -> bool:
        low, high = self.minimum, self.maximum
        return (low is None or number >= low) and (high is None or number <= high)

    def domain(self) -> str:
        """The declared domain in words."""
        if self.labels:
            allowed = [label for value, label in self.labels.items() if self._holds(value)]
            return "one of " + ", ".join(allowed) if len(allowed) > 1 else allowed[0]
        low, high = self.minimum, self.maximum
        if low is not None and low == high:
            return f"{low:g}"
        if low is not None and high is not None:
            return f"within {low:g} and {high:g}"
        if low is not None:
            below = math.nextafter(low, -math.inf)
            # A bound that is not itself allowed is declared as the next number above it.
            above = len(repr(below)) < len(repr(low)) or below == 0.0
            return f"above {below:g}" if above else f"at least {low:g}"
        return "any number" if high is None else f"at most {high:g}"

    def _label(self, text: str) -> float:
        """The value of an enumeration's label, or a number as it is."""
        for value, label in self.labels.items():
            if text.strip() == label:
                return float(value)
        try:
            return float(text)
        except ValueError:
            raise UnknownNameError(f"value of {self.name}", text, self.labels.values()) from None


class Variables(Mapping[str, Variable]):
    """All variables by name; a wrong name is answered with the nearest right one."""

    def __init__(self) -> None:
        self._table = {row["name"]: Variable(**row) for row in _native.variables()}
        #: What there is along the bodies, as many as a mesh needs.
        self.families = {
            name: Variable(name, -1, "Real", "output", "continuous", text, unit, display or "")
            for name, text, unit, display in _native.ALONG
        }

    def __getitem__(self, name: str) -> Variable:
        """The variable, or an error that names the nearest one."""
        variable = self._table.get(name)
        if variable is None:
            match = INDEXED.fullmatch(name)
            if match is None or match[1] not in self.families:
                raise UnknownNameError("variable", name, [*self._table, *self.families])
            variable = replace(self.families[match[1]], name=name)
        return variable

    def __contains__(self, name: object) -> bool:
        """Whether there is such a variable."""
        return name in self._table

    def __iter__(self) -> Iterator[str]:
        """Names in the order of the table."""
        return iter(self._table)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._table)

    def of(self, *causalities: str) -> list[Variable]:
        """Variables of some causalities, in the order of the table."""
        return [v for v in self._table.values() if v.causality in causalities]

    def settable(self, name: str) -> Variable:
        """A parameter or an input by name."""
        variable = self._table.get(name)
        if variable is None or not variable.settable:
            names = [v.name for v in self.of("parameter", "input")]
            raise UnknownNameError("parameter or input", name, names)
        return variable


@dataclass(frozen=True)
class Preset:
    """A hammer by name: what differs from the reference."""

    name: str
    description: str
    values: Mapping[str, float]


VARIABLES = Variables()
PRESETS: Mapping[str, Preset] = {p.name: p for p in (Preset(*row) for row in _native.presets())}


def numbers(
    preset: str | None,
    parameters: Mapping[str, Value] | None,
    under: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Checked numbers of a preset with parameters laid over it, ``rock`` among them too."""
    if preset is not None and preset not in PRESETS:
        error = UnknownNameError("preset", preset, PRESETS)
        instead = _native.instead_of(preset)
        raise DomainError(f"no preset is called {preset!r}: {instead}") if instead else error
    own = PRESETS[preset].values if preset else {}
    chosen = beside({**(under or {}), **own}, parameters or {})
    return {name: VARIABLES.settable(name).number(value) for name, value in chosen.items()}


def whole(given: Mapping[str, float]) -> dict[str, float]:
    """Numbers of all parameters and inputs: those given, else the start values."""
    settable = VARIABLES.of("parameter", "input")
    return {v.name: given.get(v.name, v.start or 0.0) for v in settable}


@functools.cache
def model() -> str:
    """Version of the engine and a hash of its sources, for provenance."""
    return f"dth-hammer {metadata.version('dth-hammer')} {_native.ENGINE}"
