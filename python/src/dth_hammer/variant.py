"""An FMU for other hosts, with stress and velocity along its bars among the outputs.

Outputs are a list, so a mesh must be chosen: it is written into the description's lists,
start values and GUID. The libraries are the same.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from .errors import DthHammerError
from .mesh import ELASTIC, ELEMENTS, FIDELITY, Family, families_of
from .package import Package, load
from .variables import Variable

DESCRIPTION = "modelDescription.xml"


def write_variant(
    out: str | Path,
    elements: Sequence[int] | None = None,
    *,
    fmu: str | Path | Package | None = None,
) -> int:
    """Writes the FMU with stress and velocity along a mesh among its outputs.

    Args:
        out: the file to write.
        elements: the mesh, as element counts of piston and bit; those of the FMU's start
            values if not given.
        fmu: file to use instead of the one found.

    Returns the number of outputs added.
    """
    package, out = load(fmu), Path(out)
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
    families = families_of(package)
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
