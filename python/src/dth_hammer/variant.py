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

from . import _native
from .errors import DthHammerError
from .hammer import Hammer
from .mesh import ELASTIC, ELEMENTS, FIDELITY
from .package import DESCRIPTION, Package, load
from .variables import VARIABLES, Value, Variable, numbers, whole

DOCUMENTATION = "documentation/index.html"
#: Where the documentation tells what a file was configured to.
NOTE = "<!--configured-->"
WAVES = "-waves-"
#: Attributes of an annotation that belong to the type, as a description writes them.
TYPE = ("declaredType", "unit", "displayUnit", "nominal")


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
        RefusedError: if the engine refuses the scene; nothing is written then.
    """
    package, out = load(fmu), Path(out)
    if package.path.resolve() == out.resolve():
        raise DthHammerError(f"{out.name} would overwrite the FMU that it is made from")
    given = numbers(preset, parameters)
    # The engine judges the scene before a file is written.
    Hammer(given, quiet=True).close()
    root = package.description
    references = _references(root)
    if unknown := [name for name in given if name not in references]:
        raise DthHammerError(f"{package.path.name} is of an older make: it has no {unknown[0]}")
    plain, begin = _guid_parts(root, package)
    guid = root.attrib["guid"]
    if WAVES in guid:
        raise DthHammerError(f"{package.path.name} lists waves already: take the plain FMU")
    elastic = VARIABLES[FIDELITY].number(ELASTIC)
    if waves and given.get(FIDELITY, elastic) != elastic:
        raise DthHammerError(f"rigid bodies carry no waves: set {FIDELITY} = {ELASTIC}")
    mesh = {n: whole(given)[n] for n in ELEMENTS}
    fixed = {**mesh, FIDELITY: elastic} if waves else {}
    started = _started(guid.removeprefix(plain).removeprefix(begin))
    started |= {references[n]: v for n, v in given.items()}
    started = {r: v for r, v in started.items() if r not in {references[n] for n in fixed}}
    listed = ",".join(f"{r}:{struct.pack('>d', v).hex()}" for r, v in sorted(started.items()))
    ending = WAVES + "-".join(f"{count:.0f}" for count in mesh.values()) if waves else ""
    root.set("guid", plain + (begin + listed if listed else "") + ending)
    _start(root, {n: v for n, v in given.items() if n not in fixed})
    added = _list_waves(root, package, given, fixed) if waves else 0
    _write(package, out, root, given)
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


def _references(root: ET.Element) -> dict[str, int]:
    """Value references by name, as this file has them."""
    nodes = root.iterfind("ModelVariables/ScalarVariable")
    return {node.attrib["name"]: int(node.attrib["valueReference"]) for node in nodes}


def _start(root: ET.Element, given: Mapping[str, float]) -> None:
    for node in root.iterfind("ModelVariables/ScalarVariable"):
        number = given.get(node.attrib["name"])
        if number is not None:
            whole = node[0].tag != "Real"
            node[0].set("start", f"{number:.0f}" if whole else repr(float(number)))


def _list_waves(
    root: ET.Element, package: Package, given: Mapping[str, float], fixed: Mapping[str, float]
) -> int:
    node = root.find("VendorAnnotations/Tool[@name='dth_hammer']/Waves")
    if node is None:
        raise DthHammerError(f"{package.path.name} tells nothing of the inside of its bars")
    families = {row.attrib["name"]: row.attrib for row in node.iter("Family")}
    variables, structure = root.find("ModelVariables"), root.find("ModelStructure")
    assert variables is not None
    assert structure is not None
    # Some parameters are left one value only.
    for variable in variables:
        number = fixed.get(variable.attrib["name"])
        if number is not None:
            variable[0].attrib.update(dict.fromkeys(("start", "min", "max"), f"{number:.0f}"))
    names = _native.wave_names({**given, **fixed})
    for name in names:
        family, _, index = name.rstrip("]").partition("[")
        _add(variables, structure, families[family], name, int(index))
    return len(names)


def _add(
    variables: ET.Element, structure: ET.Element, row: Mapping[str, str], name: str, index: int
) -> None:
    attributes = {
        "name": name,
        "valueReference": str(int(row["firstValueReference"]) + index - 1),
        "description": row["description"],
        "causality": "output",
        "variability": "continuous",
        "initial": "calculated",
    }
    node = ET.SubElement(variables, "ScalarVariable", attributes)
    ET.SubElement(node, "Real", {key: row[key] for key in TYPE if key in row})
    position: dict[str, Any] = {"index": str(len(variables))}
    for part, dependencies in (("Outputs", {"dependencies": ""}), ("InitialUnknowns", {})):
        place = structure.find(part)
        assert place is not None
        ET.SubElement(place, "Unknown", position | dependencies)


def _text(variable: Variable, number: float) -> str:
    return f"{variable.name} = {variable.labels.get(int(number)) or variable.text(number)}"


def _write(package: Package, out: Path, root: ET.Element, given: Mapping[str, float]) -> None:
    ET.indent(root)
    text = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    listed = ", ".join(_text(VARIABLES[n], v) for n, v in given.items())
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
                elif entry.filename == DOCUMENTATION and given:
                    data = data.replace(NOTE.encode(), note.encode())
                target.writestr(entry, data)
        partial.replace(out)
    finally:
        partial.unlink(missing_ok=True)
