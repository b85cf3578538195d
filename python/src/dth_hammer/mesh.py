"""Stress and velocity along the bars: what the FMU answers for beyond its outputs.

Their number follows from the mesh, so the description does not list them: it tells in
``VendorAnnotations`` how they are called and where their value references start. This
package reads them from any FMU of the hammer; for other hosts see `variant`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from .errors import DomainError, DthHammerError
from .variables import Variable

if TYPE_CHECKING:
    from .package import Package

ELEMENTS = ("piston.elements", "bit.elements")
FIDELITY, ELASTIC = "fidelity", "Elastic"
INDEXED = re.compile(r"(\w+)\[([1-9]\d*)\]")
#: Attributes of an annotation that belong to the type, as a description writes them.
TYPE = ("declaredType", "unit", "displayUnit", "nominal")


@dataclass(frozen=True)
class Family:
    """Variables of one kind along one body, counted from 1 at its upper end."""

    name: str
    first: int
    #: The parameter that counts the body's elements.
    count: str
    #: The parameter that counts its sections: there are never fewer elements.
    least: str
    #: How many there are beyond the elements: 1 for what belongs to nodes.
    more: int
    description: str
    #: Attributes of its type.
    type: Mapping[str, str]

    def variable(self, index: int) -> Variable:
        """The member of an index from 1."""
        return Variable(
            name=f"{self.name}[{index}]",
            reference=self.first + index - 1,
            kind="Real",
            causality="output",
            variability="continuous",
            description=self.description,
            unit=self.type["unit"],
            display_unit=self.type.get("displayUnit", ""),
        )

    def members(self, numbers: Mapping[str, float]) -> Iterator[Variable]:
        """All of a mesh."""
        elements = max(int(numbers[self.count]), int(numbers.get(self.least, 0)))
        return map(self.variable, range(1, elements + self.more + 1))


class Families(Mapping[str, Family]):
    """The families by name, as the description announces them."""

    def __init__(self, description: Path) -> None:
        root = ET.parse(description).getroot()
        node = root.find("VendorAnnotations/Tool[@name='dth_hammer']/Waves")
        #: GUID of a variant, with the element counts left open.
        self.guid = "" if node is None else node.attrib["guid"]
        rows = [] if node is None else [_family(row.attrib) for row in node.iter("Family")]
        self._table = {family.name: family for family in rows}

    def __getitem__(self, name: str) -> Family:
        """The family."""
        return self._table[name]

    def __iter__(self) -> Iterator[str]:
        """Names in the order of the description."""
        return iter(self._table)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._table)

    def find(self, name: str) -> Variable | None:
        """The variable called like ``piston_stress[3]``, whether or not a mesh has it."""
        match = INDEXED.fullmatch(name)
        if match is None or match[1] not in self._table:
            return None
        return self._table[match[1]].variable(int(match[2]))


def _family(row: Mapping[str, str]) -> Family:
    return Family(
        name=row["name"],
        first=int(row["firstValueReference"]),
        count=row["count"],
        least=row.get("least", ""),
        more=int(row["more"]),
        description=row["description"],
        type={key: row[key] for key in TYPE if key in row},
    )


def members(package: Package, numbers: Mapping[str, float]) -> list[Variable]:
    """All that a hammer of these parameters has along its bars."""
    families = families_of(package)
    least = [f.least for f in families.values() if f.least]
    all_numbers = {
        name: numbers.get(name, package.variables[name].start or 0.0)
        for name in (*ELEMENTS, FIDELITY, *least)
    }
    if all_numbers[FIDELITY] != package.variables[FIDELITY].number(ELASTIC):
        raise DomainError(f"rigid bodies carry no waves: set {FIDELITY} = {ELASTIC}")
    return [v for f in families.values() for v in f.members(all_numbers)]


def families_of(package: Package) -> Families:
    """The families, or an error if the FMU has none."""
    families = package.variables.families
    if not families:
        raise DthHammerError(f"{package.path.name} tells nothing of the inside of its bars")
    return families
