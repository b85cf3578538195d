"""The FMU's variables as its model description declares them: names, units, domains.

Nothing about a variable is written in this package: it is all read from the FMU.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from fmpy.model_description import ModelDescription, ScalarVariable
from numpy.typing import NDArray

from .errors import DomainError, UnitError, UnknownNameError

if TYPE_CHECKING:
    from .mesh import Families

Array = NDArray[Any]
#: A number in the declared unit, a label of an enumeration, or text such as ``"60 mm"``.
Value = float | int | bool | str


@dataclass(frozen=True)
class Variable:
    """One variable of the FMU."""

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
    #: Units that a value may carry: value in SI = value in the unit / factor.
    factors: Mapping[str, float] = field(default_factory=dict)
    #: Labels of an enumeration by value.
    labels: Mapping[int, str] = field(default_factory=dict)

    @property
    def settable(self) -> bool:
        """Whether a user may set it."""
        return self.causality in ("parameter", "input")

    @property
    def tunable(self) -> bool:
        """Whether it may be set between steps."""
        return self.causality == "input" or self.variability == "tunable"

    def number(self, value: Value) -> float:
        """The value in the declared unit, checked against the declared domain."""
        if isinstance(value, str):
            value = self._parse(value)
        number = float(value)
        if not math.isfinite(number):
            raise DomainError(f"{self.name} must be finite, not {number}")
        if self.kind in ("Integer", "Enumeration") and number != int(number):
            raise DomainError(f"{self.name} must be a whole number, not {number}")
        if not self._holds(number):
            value_and_unit = f"{number:g} {self.unit}".rstrip()
            raise DomainError(f"{self.name} = {value_and_unit} is not {self.domain()}")
        return number

    def _holds(self, number: float) -> bool:
        low, high = self.minimum, self.maximum
        return (low is None or number >= low) and (high is None or number <= high)

    def domain(self) -> str:
        """The declared domain in words."""
        if self.labels:
            allowed = [label for value, label in self.labels.items() if self._holds(value)]
            return "one of " + ", ".join(allowed) if len(allowed) > 1 else allowed[0]
        if self.minimum is not None and self.minimum == self.maximum:
            return f"{self.minimum:g}"
        if self.minimum is not None and self.maximum is not None:
            return f"within {self.minimum:g} and {self.maximum:g}"
        if self.minimum is not None:
            return f"at least {self.minimum:g}"
        if self.maximum is not None:
            return f"at most {self.maximum:g}"
        return "any number"

    def _parse(self, text: str) -> float:
        for value, label in self.labels.items():
            if text == label:
                return value
        words = text.split()
        try:
            number = float(words[0])
        except (ValueError, IndexError):
            if self.labels:
                raise UnknownNameError(
                    f"value of {self.name}", text, self.labels.values()
                ) from None
            raise DomainError(f"{self.name} = {text!r} is not a number") from None
        unit = " ".join(words[1:])
        if not unit:
            return number
        if unit not in self.factors:
            units = ", ".join(self.factors) or "no unit"
            raise UnitError(f"{self.name} is given in {units}, not in {unit!r}")
        return number / self.factors[unit]


class Variables(Mapping[str, Variable]):
    """All variables by name; a wrong name is answered with the nearest right one."""

    def __init__(self, description: ModelDescription, families: Families) -> None:
        #: What can be read beyond what is listed.
        self.families = families
        units = {
            unit.name: {unit.name: 1.0} | {d.name: float(d.factor) for d in unit.displayUnits}
            for unit in description.unitDefinitions
        }
        self._table = {v.name: _variable(v, units) for v in description.modelVariables}

    def __getitem__(self, name: str) -> Variable:
        """The variable, or an error that names the nearest one."""
        variable = self._table.get(name) or self.families.find(name)
        if variable is None:
            raise UnknownNameError("variable", name, [*self._table, *self.families])
        return variable

    def __contains__(self, name: object) -> bool:
        """Whether there is such a variable."""
        return name in self._table

    def __iter__(self) -> Any:
        """Names in the order of the description."""
        return iter(self._table)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._table)

    def of(self, *causalities: str) -> list[Variable]:
        """Variables of some causalities, in the order of the description."""
        return [v for v in self._table.values() if v.causality in causalities]

    def settable(self, name: str) -> Variable:
        """A parameter or an input by name."""
        variable = self._table.get(name)
        if variable is None or not variable.settable:
            names = [v.name for v in self.of("parameter", "input")]
            raise UnknownNameError("parameter or input", name, names)
        return variable


def _variable(v: ScalarVariable, units: Mapping[str, Mapping[str, float]]) -> Variable:
    declared = v.declaredType
    items = (getattr(declared, "items", None) or []) if v.type == "Enumeration" else []
    unit = v.unit or (declared.unit if declared else None) or ""
    return Variable(
        name=cast("str", v.name),
        reference=v.valueReference,
        kind=cast("str", v.type),
        causality=v.causality or "local",
        variability=v.variability or "continuous",
        description=v.description or "",
        unit=unit,
        display_unit=v.displayUnit or "",
        start=_float(v.start),
        minimum=_float(v.min),
        maximum=_float(v.max),
        factors=units.get(unit, {}),
        labels={int(item.value): item.name for item in items},
    )


def _float(text: str | None) -> float | None:
    return None if text is None else float(text)
