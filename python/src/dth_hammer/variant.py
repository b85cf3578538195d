"""FMUs for other hosts: one that starts as a scene, one that lists the waves on a mesh, or both.

Many hosts cannot set an enumeration, some set nothing at all. `configure` writes the scene
into the description's start values, and so that the library knows of it into the GUID, which
every host hands over. Outputs are a list, so for waves a mesh must be chosen, which then is
part of the GUID too. The libraries are the same.
"""

from __future__ import annotations

import html
import os
import re
import struct
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from .errors import DthHammerError
from .hammer import Hammer
from .mesh import ELASTIC, ELEMENTS, FIDELITY, Family, families_of
from .package import Package, load
from .variables import Value, Variable

DESCRIPTION = "modelDescription.xml"
DOCUMENTATION = "documentation/index.html"
#: Where the documentation tells what a file was configured to.
NOTE = "<!--configured-->"
WAVES = "-waves-"


def configure(
    out: str | Path,
    parameters: Mapping[str, Value] | None = None,
    *,
    preset: str | None = None,
    waves: bool = False,
    fmu: str | Path | Package | None = None,
) -> int:
    """Writes an FMU whose start values are a scene's: one file is one hammer.

    Any host then simulates that hammer without setting anything; it may still set what the
    plain FMU lets it set.

    Args:
        out: the file to write.
        parameters: by dotted name, as for `simulate`; start values of inputs too.
        preset: parameter set to start from.
        waves: lists stress and velocity along the scene's mesh among the outputs.
        fmu: file to use instead of the one found.

    Returns the number of outputs added.

    Raises:
        DomainError, UnitError, UnknownNameError: for what cannot be set so.
        RefusedError: if the FMU refuses the scene; nothing is written then.
    """
    package, out = load(fmu), Path(out)
    if package.path.resolve() == out.resolve():
        raise DthHammerError(f"{out.name} would overwrite the FMU that it is made from")
    numbers = package.values(preset, parameters)
    # The FMU itself judges the scene before a file is written.
    Hammer(numbers, fmu=package, quiet=True).close()
    tree = ET.parse(Path(package.folder, DESCRIPTION))
    root = tree.getroot()
    plain, begin = _guid_parts(root, package)
    guid = root.attrib["guid"]
    if WAVES in guid:
        raise DthHammerError(f"{package.path.name} lists waves already: take the plain FMU")
    mesh = {n: numbers.get(n, package.variables[n].start or 0.0) for n in ELEMENTS}
    fixed = {**mesh, FIDELITY: package.variables[FIDELITY].number(ELASTIC)} if waves else {}
    if waves and numbers.get(FIDELITY, fixed[FIDELITY]) != fixed[FIDELITY]:
        raise DthHammerError(f"rigid bodies carry no waves: set {FIDELITY} = {ELASTIC}")
    started = _started(guid.removeprefix(plain).removeprefix(begin))
    started |= {package.variables[n].reference: v for n, v in numbers.items()}
    started = {r: v for r, v in started.items() if r not in _references(package, fixed)}
    listed = ",".join(f"{r}:{struct.pack('>d', v).hex()}" for r, v in sorted(started.items()))
    ending = WAVES + "-".join(f"{count:.0f}" for count in mesh.values()) if waves else ""
    root.set("guid", plain + (begin + listed if listed else "") + ending)
    _start(root, {n: v for n, v in numbers.items() if n not in fixed})
    added = _list_waves(root, package, mesh, fixed) if waves else 0
    _write(package, out, tree, numbers)
    return added


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
    mesh = dict(zip(ELEMENTS, elements or (), strict=bool(elements)))
    return configure(out, mesh, waves=True, fmu=fmu)


def _guid_parts(root: ET.Element, package: Package) -> tuple[str, str]:
    """The plain GUID, and what comes between it and start values."""
    node = root.find("VendorAnnotations/Tool[@name='dth_hammer.start_values']/StartValues")
    match = None if node is None else re.fullmatch(r"(.*)(-\w+-)\{.*", node.attrib["guid"])
    if match is None:
        raise DthHammerError(f"{package.path.name} is too old to be configured")
    return match[1], match[2]


def _started(text: str) -> dict[int, float]:
    """Start values by reference, as a configured FMU's GUID has them."""
    pairs = (pair.split(":") for pair in text.split(",") if pair)
    return {int(at): struct.unpack(">d", bytes.fromhex(bits))[0] for at, bits in pairs}


def _references(package: Package, names: Mapping[str, Any]) -> set[int]:
    return {package.variables[name].reference for name in names}


def _start(root: ET.Element, numbers: Mapping[str, float]) -> None:
    for node in root.iterfind("ModelVariables/ScalarVariable"):
        number = numbers.get(node.attrib["name"])
        if number is not None:
            whole = node[0].tag != "Real"
            node[0].set("start", f"{number:.0f}" if whole else repr(float(number)))


def _list_waves(
    root: ET.Element, package: Package, mesh: Mapping[str, float], fixed: Mapping[str, float]
) -> int:
    families = families_of(package)
    variables, structure = root.find("ModelVariables"), root.find("ModelStructure")
    assert variables is not None
    assert structure is not None
    # Some parameters are left one value only.
    for node in variables:
        number = fixed.get(node.attrib["name"])
        if number is not None:
            node[0].attrib.update(dict.fromkeys(("start", "min", "max"), f"{number:.0f}"))
    added = [(f, v) for f in families.values() for v in f.members(mesh)]
    for family, variable in added:
        _add(variables, structure, family, variable)
    return len(added)


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


def _shown(variable: Variable, number: float) -> str:
    return f"{variable.name} = {variable.labels.get(int(number)) or variable.shown(number)}"


def _write(package: Package, out: Path, tree: Any, numbers: Mapping[str, float]) -> None:
    ET.indent(tree)
    text = ET.tostring(tree.getroot(), encoding="UTF-8", xml_declaration=True)
    listed = ", ".join(_shown(package.variables[n], v) for n, v in numbers.items())
    note = f"<p><strong>This file starts with</strong> {html.escape(listed)}.</p>{NOTE}"
    out.parent.mkdir(parents=True, exist_ok=True)
    partial = out.with_name(f".{out.name}.{os.getpid()}")
    try:
        with (
            zipfile.ZipFile(package.path) as source,
            zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as target,
        ):
            for entry in source.infolist():
                data = source.read(entry)
                if entry.filename == DESCRIPTION:
                    data = text
                elif entry.filename == DOCUMENTATION and numbers:
                    data = data.replace(NOTE.encode(), note.encode())
                target.writestr(entry, data)
        partial.replace(out)
    finally:
        partial.unlink(missing_ok=True)
