"""Variants of the FMU: with the start values of a scene, or with arrays.

Many hosts cannot set an enumeration, and some cannot set any parameter. `configure` therefore
writes a scene into the start values of the model description. It also writes the scene, as text,
into a section of the library that is reserved for it, because the library does not read the
description. Every host passes the GUID (in FMI 3.0 the instantiation token) to the library. Here it
is the plain FMU's GUID followed by a hash of that text, so the library can check that description
and section belong together.

With FMI 3.0 the FMU can also list arrays of waves and blows. They are in a variant, because many
importers reject arrays. Apart from the section, the libraries of all variants are identical.
"""

import html
import re
import struct
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

from ..contract import typed
from ..errors import DthHammerError
from ..outputs import check, whole
from ..scene.hammers import Hammerlike, Rocklike, numbers_of, scene_of
from ..scene.scene import Scene
from ..scene.variables import VARIABLES, Value, Variable
from ..simulation.hammer import Hammer
from .package import DESCRIPTION, IDENTITY, Package, inspect, load

DOCUMENTATION = "documentation/index.html"
#: Placeholder in the documentation that is replaced by the list of start values.
NOTE = "<!--configured-->"
ARRAYS = "-arrays"
#: Bytes at the beginning of the library's section, and the number of bytes that follow them.
SECTION_MARK, SECTION_SIZE = b"dth_hammer: this unit starts as:", 1 << 14
BINARIES = "binaries/"
#: By version of FMI: the element of the description that specifies the format of the section.
FORMAT_PATHS = {
    2: "VendorAnnotations/Tool[@name='dth_hammer.start_values']/StartValues",
    3: "Annotations/Annotation[@type='dth_hammer.start_values']/StartValues",
}
#: Folder of files that are valid only for the plain FMU, such as its reference results.
PLAIN_ONLY = "extra/"
TRUTHS = {0: "false", 1: "true"}
#: Causalities of the FMU's own parameters.
OWN = ("parameter", "structuralParameter")


@typed()
def configure(
    hammer: Hammerlike,
    out: str | Path,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    arrays: bool = False,
    fmu: str | Path | Package | None = None,
    fmi: int = 2,
) -> int:
    """Writes an FMU with the start values of a scene: the file then is one particular hammer.

    Any host simulates that hammer without setting any parameter. It can still set all that can be
    set in the plain FMU.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
            It may include start values of inputs and, for FMI 3.0, the parameters of the FMU's
            events and the lengths of its arrays.
        out: the .fmu to write.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        arrays: with FMI 3, lists stress and velocity along the bodies, and the blows of a step, as
            arrays.
        fmu: FMU to start from instead of the package's own.
        fmi: version of FMI, 2 or 3, of the package's own FMU.

    Returns the number of outputs added.

    Raises:
        DomainError, UnknownNameError: a name or a value cannot be set.
        RefusedError: the engine refuses the scene; then nothing is written.

    Example:
        >>> from dth_hammer import fmu
        >>> fmu.configure({"feed_force": "8 kN"}, "mine.fmu", rock="granite")
        0
    """
    package, out = load(fmu, fmi=fmi), check(out, (".fmu",))
    if package.path.resolve() == out.resolve():
        raise DthHammerError(f"{out.name} would overwrite the FMU that it is made from")
    root = package.description
    added = _list_arrays(root, package) if arrays else 0
    rows = _rows(root)
    given, fmu_values = start_values(root, scene_of(hammer, rock, preset))
    # The engine checks the scene before a file is written.
    Hammer(given, quiet=True).close()
    if unknown := [name for name in given if name not in rows]:
        raise DthHammerError(f"{package.path.name} is of an older version: it has no {unknown[0]}")
    values = {**given, **fmu_values}
    text = _identify(root, package, values, arrays=arrays)
    for name, number in values.items():
        node = rows[name][1]
        node.set("start", _start_text(node.tag, number))
    _write(package, out, root, text, values)
    return added


def start_values(root: ET.Element, scene: Scene) -> tuple[dict[str, float], dict[str, float]]:
    """Returns the checked numbers of a scene.

    The second mapping has the parameters that only the FMU of FMI 3.0 has, see `_fmu_parameters`.
    """
    fmu_variables = {v.name: v for v in _fmu_parameters(root)}
    fmu_values = {
        n: fmu_variables[n].number(value)
        for n, value in scene.parameters.items()
        if n in fmu_variables
    }
    parameters: dict[str, Value] = {
        n: v for n, v in scene.parameters.items() if n not in fmu_variables
    }
    return numbers_of(replace(scene, parameters=parameters)), fmu_values


def _fmu_parameters(root: ET.Element) -> list[Variable]:
    """Returns the FMU's parameters that the hammer does not have: events and array lengths."""
    variables = []
    for name, (reference, node) in _rows(root).items():
        attributes = node.attrib
        if name in VARIABLES or attributes.get("causality") not in OWN:
            continue
        kind = "Real" if node.tag == "Float64" else "Integer"
        low, high = (float(attributes[k]) if k in attributes else None for k in ("min", "max"))
        labels = TRUTHS if node.tag == "Boolean" else {}
        text, unit = (attributes.get(key, "") for key in ("description", "unit"))
        row = name, reference, kind, "parameter", "fixed", text, unit
        variables.append(Variable(*row, minimum=low, maximum=high, labels=labels))
    return variables


def _identify(
    root: ET.Element, package: Package, given: Mapping[str, float], *, arrays: bool
) -> str:
    """Writes the GUID with the hash of the section's text, and returns that text."""
    identity = IDENTITY[package.fmi]
    plain_identity, prefix = _identity_parts(root, package)
    section = _section(package)
    arrays = arrays or section.endswith(ARRAYS)
    section = section.removesuffix(ARRAYS).removeprefix(prefix)
    rows = _rows(root)
    started = _read_start_values(section) | {rows[n][0]: v for n, v in given.items()}
    listed = ",".join(f"{r}:{struct.pack('>d', v).hex()}" for r, v in sorted(started.items()))
    text = (prefix + listed if listed else "") + (ARRAYS if arrays else "")
    root.set(identity, plain_identity + (_sign(text) if text else ""))
    return text


def _sign(text: str) -> str:
    """Returns a dash and the text's hash (64-bit FNV-1a), as the library computes it."""
    number = 0xCBF29CE484222325
    for byte in text.encode():
        number = (number ^ byte) * 0x100000001B3 % 2**64
    return f"-{number:016x}"


def _section(package: Package) -> str:
    """Returns the text in the section of an FMU's libraries."""
    with zipfile.ZipFile(package.path) as archive:
        for name in archive.namelist():
            library = archive.read(name) if name.startswith(BINARIES) else b""
            _, mark, rest = library.partition(SECTION_MARK)
            if mark:
                return rest[:SECTION_SIZE].partition(b"\0")[0].decode()
    raise DthHammerError(f"{package.path.name} is too old to be configured")


def _with_section(library: bytes, text: str) -> bytes:
    """Returns the library with the text written to its section."""
    before, mark, rest = library.partition(SECTION_MARK)
    if not mark:
        return library
    return before + mark + text.encode().ljust(SECTION_SIZE, b"\0") + rest[SECTION_SIZE:]


def _identity_parts(root: ET.Element, package: Package) -> tuple[str, str]:
    """Returns the plain FMU's GUID, and the text that precedes the start values in the section."""
    node = root.find(FORMAT_PATHS[package.fmi])
    texts = () if node is None else node.attrib.values()
    match = next((re.fullmatch(r"(.*)(-\w+-)\{.*", text) for text in texts), None)
    if match is None:
        raise DthHammerError(f"{package.path.name} is too old to be configured")
    return match[1], match[2]


def _read_start_values(text: str) -> dict[int, float]:
    """Reads the start values, by value reference, from a section's text."""
    pairs = (pair.split(":") for pair in text.split(",") if pair)
    return {int(at): struct.unpack(">d", bytes.fromhex(bits))[0] for at, bits in pairs}


def _rows(root: ET.Element) -> dict[str, tuple[int, ET.Element]]:
    """Returns each variable's value reference and the element with its start value, by name."""
    nodes = root.iterfind("ModelVariables/*")
    return {
        node.attrib["name"]: (
            int(node.attrib["valueReference"]),
            node[0] if node.tag == "ScalarVariable" else node,
        )
        for node in nodes
    }


def _start_text(kind: str, number: float) -> str:
    """Returns a start value as text, for a type of FMI 2.0 or 3.0."""
    if kind == "Boolean":
        return TRUTHS[int(number)]
    return repr(float(number)) if kind in ("Real", "Float64") else f"{number:.0f}"


def _list_arrays(root: ET.Element, package: Package) -> int:
    """Adds the arrays to the description and returns the number of outputs added."""
    node = root.find("Annotations/Annotation[@type='dth_hammer.arrays']/Arrays")
    variables, structure = root.find("ModelVariables"), root.find("ModelStructure")
    if node is None or variables is None or structure is None:
        raise DthHammerError(f"{package.path.name} has no arrays: they are of FMI 3.0 (--fmi 3)")
    added = 0
    known = {variable.attrib["name"] for variable in variables}
    for row in node:
        attributes = dict(row.attrib)
        kind, length = attributes.pop("type"), attributes.pop("length", None)
        if attributes["name"] in known:
            raise DthHammerError(f"{package.path.name} has arrays already")
        variable = ET.SubElement(variables, kind, attributes)
        if length is not None:
            ET.SubElement(variable, "Dimension", valueReference=length)
        if attributes["causality"] != "output":
            continue
        added += 1
        unknown = {"valueReference": attributes["valueReference"]}
        # The standard requires outputs before initial unknowns.
        place = [part.tag for part in structure].index("InitialUnknown")
        structure.insert(place, ET.Element("Output", unknown | {"dependencies": ""}))
        # Initially, an array depends on what the output with the most dependencies depends on.
        widest = max((part.get("dependencies", "") for part in structure), key=len)
        ET.SubElement(structure, "InitialUnknown", unknown | {"dependencies": widest})
    return added


def _write(
    package: Package, out: Path, root: ET.Element, text: str, given: Mapping[str, float]
) -> None:
    ET.indent(root)
    description = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    text_by_name = {
        n: VARIABLES[n].text(v) if n in VARIABLES else f"{v:g}" for n, v in given.items()
    }
    listed = ", ".join(f"{name} = {text}" for name, text in text_by_name.items())
    note = f"<p><strong>This file starts with</strong> {html.escape(listed)}.</p>{NOTE}"
    with (
        whole(out) as new,
        zipfile.ZipFile(package.path) as source,
        zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as target,
    ):
        inspect(source)
        for entry in source.infolist():
            if given and entry.filename.startswith(PLAIN_ONLY):
                continue
            data = source.read(entry)
            if entry.filename == DESCRIPTION:
                data = description
            elif entry.filename.startswith(BINARIES):
                data = _with_section(data, text)
            elif entry.filename == DOCUMENTATION and given:
                data = data.replace(NOTE.encode(), note.encode())
            target.writestr(entry, data)
