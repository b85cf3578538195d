"""Stress and velocity along the bars: what the FMU answers for beyond its outputs.

Their number follows from the mesh, so the description does not list them: it tells in
``VendorAnnotations`` how they are called and where their value references start. This
package reads them from any FMU of the hammer; for other hosts `write_variant` makes an FMU
whose description lists those of one mesh.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from .errors import DomainError, DthHammerError
from .variables import Variable

if TYPE_CHECKING:
    from .package import Package

DESCRIPTION = "modelDescription.xml"
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
        return map(self.variable, range(1, int(numbers[self.count]) + self.more + 1))


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
        more=int(row["more"]),
        description=row["description"],
        type={key: row[key] for key in TYPE if key in row},
    )


def write_variant(package: Package, elements: Sequence[int] | None, out: Path) -> int:
    """Writes the FMU with stress and velocity along a mesh among its outputs.

    The mesh is its element counts of piston and bit, those of the FMU's start values if not
    given. Returns the number of outputs added.
    """
    if package.path.resolve() == out.resolve():
        raise DthHammerError(f"{out.name} would overwrite the FMU that it is made from")
    mesh = {name: package.variables[name].start or 0.0 for name in ELEMENTS}
    for name, count in zip(ELEMENTS, elements or (), strict=bool(elements)):
        mesh[name] = package.variables[name].number(count)
    tree = ET.parse(Path(package.folder, DESCRIPTION))
    added = _list_waves(tree.getroot(), package, mesh)
    ET.indent(tree)
    text = ET.tostring(tree.getroot(), encoding="UTF-8", xml_declaration=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    with (
        zipfile.ZipFile(package.path) as source,
        zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as target,
    ):
        for entry in source.infolist():
            mine = entry.filename == DESCRIPTION
            target.writestr(entry, text if mine else source.read(entry))
    return added


def _list_waves(root: ET.Element, package: Package, mesh: Mapping[str, float]) -> int:
    families = _families(package)
    variables, structure = root.find("ModelVariables"), root.find("ModelStructure")
    assert variables is not None
    assert structure is not None
    guid = families.guid
    for name, count in mesh.items():
        guid = guid.replace(f"{{{name}}}", f"{count:.0f}")
    root.set("guid", guid)
    _fix(variables, {**mesh, FIDELITY: package.variables[FIDELITY].number(ELASTIC)})
    added = [(f, v) for f in families.values() for v in f.members(mesh)]
    for family, variable in added:
        _add(variables, structure, family, variable)
    return len(added)


def _fix(variables: ET.Element, numbers: Mapping[str, float]) -> None:
    """Leaves some parameters one value only."""
    for node in variables:
        number = numbers.get(node.attrib["name"])
        if number is not None:
            node[0].attrib.update(dict.fromkeys(("start", "min", "max"), f"{number:.0f}"))


def _add(variables: ET.Element, structure: ET.Element, family: Family, variable: Variable) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(variable.reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
        "initial": "calculated",
    }
    node = ET.SubElement(variables, "ScalarVariable", attributes)
    ET.SubElement(node, "Real", dict(family.type))
    index: dict[str, Any] = {"index": str(len(variables))}
    for name, dependencies in (("Outputs", {"dependencies": ""}), ("InitialUnknowns", {})):
        place = structure.find(name)
        assert place is not None
        ET.SubElement(place, "Unknown", index | dependencies)


def members(package: Package, numbers: Mapping[str, float]) -> list[Variable]:
    """All that a hammer of these parameters has along its bars."""
    all_numbers = {
        name: numbers.get(name, package.variables[name].start or 0.0)
        for name in (*ELEMENTS, FIDELITY)
    }
    if all_numbers[FIDELITY] != package.variables[FIDELITY].number(ELASTIC):
        raise DomainError(f"rigid bodies carry no waves: set {FIDELITY} = {ELASTIC}")
    return [v for f in _families(package).values() for v in f.members(all_numbers)]


def _families(package: Package) -> Families:
    families = package.variables.families
    if not families:
        raise DthHammerError(f"{package.path.name} tells nothing of the inside of its bars")
    return families
