"""The engine's table of variables: names, units, domains, meanings, and the presets.

All of it is read from the native module; nothing is repeated here.
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
from ..frames import pd
from . import quantities
from .rocks import beside

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Array = NDArray[Any]
else:
    Array = Any
#: The types that a user may give for a number.
Value = quantities.Value
#: Name and index (from 1) of a variable along the bodies, such as ``bit_stress[12]``.
INDEXED = re.compile(r"(\w+)\[([1-9]\d*)\]")
#: Default communication step and duration, s; the FMU proposes the same values.
STEP, UNTIL = _native.STEP, _native.UNTIL


@dataclass(frozen=True)
class Variable:
    """A parameter, input, output or local variable of the engine."""

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
    #: Labels of an enumeration, by their numbers.
    labels: Mapping[int, str] = field(default_factory=dict)

    @property
    def settable(self) -> bool:
        """Whether a user can set it: parameters and inputs."""
        return self.causality in ("parameter", "input")

    @property
    def counts(self) -> bool:
        """Whether the value is a whole number, although the FMU declares it as a Real."""
        return self.quantity == "Count"

    @property
    def tunable(self) -> bool:
        """Whether it may be changed between steps."""
        return self.causality == "input" or self.variability == "tunable"

    def number(self, value: Value) -> float:
        """Converts a value to the declared unit and checks it against the declared domain."""
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
        """Returns a number as text: its label, or the number with the declared unit."""
        if label := self.labels.get(int(number)) if self.labels else None:
            return label
        return f"{number:g} {self.unit if self.unit != '1' else ''}".rstrip()

    def _holds(self, number: float) -> bool:
        low, high = self.minimum, self.maximum
        return (low is None or number >= low) and (high is None or number <= high)

    def domain(self) -> str:
        """Returns the declared domain as text, such as ``above 0``."""
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
            # An exclusive bound is declared as the next floating-point number above it. Of two
            # neighbouring floats, the one that a person chose as the bound prints shorter.
            exclusive = len(repr(below)) < len(repr(low)) or below == 0.0
            return f"above {below:g}" if exclusive else f"at least {low:g}"
        return "any number" if high is None else f"at most {high:g}"

    def _label(self, text: str) -> float:
        """Returns the number of an enumeration's label; text of a number is converted as it is."""
        for value, label in self.labels.items():
            if text.strip() == label:
                return float(value)
        try:
            return float(text)
        except ValueError:
            raise UnknownNameError(f"value of {self.name}", text, self.labels.values()) from None


class Variables(Mapping[str, Variable]):
    """All variables by name; the error for an unknown name proposes the most similar one."""

    def __init__(self) -> None:
        self._table = {row["name"]: Variable(**row) for row in _native.variables()}
        #: Variables along the bodies, which have one element per node or element of the mesh.
        self.families = {
            name: Variable(name, -1, "Real", "output", "continuous", text, unit, display or "")
            for name, text, unit, display in _native.ALONG
        }

    def __getitem__(self, name: str) -> Variable:
        """Returns the variable; for an unknown name, the error proposes the most similar one."""
        variable = self._table.get(name)
        if variable is None:
            match = INDEXED.fullmatch(name)
            if match is None or match[1] not in self.families:
                raise UnknownNameError("variable", name, [*self._table, *self.families])
            variable = replace(self.families[match[1]], name=name)
        return variable

    def __contains__(self, name: object) -> bool:
        """Whether a variable with this name is in the table."""
        return name in self._table

    def __iter__(self) -> Iterator[str]:
        """Names in the order of the table."""
        return iter(self._table)

    def __len__(self) -> int:
        """Number of variables in the table."""
        return len(self._table)

    def _repr_html_(self) -> str:
        """Returns a table of all variables for notebooks."""
        rows = {v.name: (v.causality, v.unit, v.start, v.description) for v in self.values()}
        heads = ["kind", "unit", "start", "meaning"]
        table = pd.DataFrame.from_dict(rows, orient="index", columns=heads)
        return table.to_html(na_rep="", max_rows=None)

    def of(self, *causalities: str) -> list[Variable]:
        """Returns the variables of the given causalities, in the order of the table."""
        return [v for v in self._table.values() if v.causality in causalities]

    def settable(self, name: str) -> Variable:
        """Returns a parameter or an input by name."""
        variable = self._table.get(name)
        if variable is None or not variable.settable:
            names = [v.name for v in self.of("parameter", "input")]
            raise UnknownNameError("parameter or input", name, names)
        return variable


@dataclass(frozen=True)
class Preset:
    """A hammer with a name: the values that differ from the reference hammer."""

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
    """Returns the checked numbers of a preset, overridden by parameters.

    Args:
        preset: name of the preset, None for the reference hammer.
        parameters: values by name; the key ``rock`` may name a rock.
        under: numbers that both the preset and the parameters override.
    """
    if preset is not None and preset not in PRESETS:
        error = UnknownNameError("preset", preset, PRESETS)
        advice = _native.instead_of(preset)
        raise DomainError(f"no preset is called {preset!r}: {advice}") if advice else error
    preset_values = PRESETS[preset].values if preset else {}
    chosen = beside({**(under or {}), **preset_values}, parameters or {})
    return {name: VARIABLES.settable(name).number(value) for name, value in chosen.items()}


def whole(given: Mapping[str, float]) -> dict[str, float]:
    """Returns the numbers of all parameters and inputs: those given, else the start values."""
    settable = VARIABLES.of("parameter", "input")
    return {v.name: given.get(v.name, v.start or 0.0) for v in settable}


@functools.cache
def model() -> str:
    """Returns the version of the engine and a hash of its sources, for provenance."""
    return f"dth-hammer {metadata.version('dth-hammer')} {_native.ENGINE}"
