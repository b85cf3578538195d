"""Writes a hammer and its drive to one file: an SSP system that a host program co-simulates.

With FMI 2.0 the file follows SSP 1.0, with FMI 3.0 SSP 2.0.

The hammer's FMU in it has the scene as its start values, because many hosts cannot set an
enumeration. Variables of equal names are connected: a drive with the output ``drive_pressure`` and
the input ``relative_position`` needs no further description.

Every host that reads such a file steps all units at once. The values of a drive are therefore one
step older than in a host that steps one unit after the other, and `coupling.delay` is chosen
accordingly.
"""

from __future__ import annotations

import re
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from .. import __name__ as package_name
from .. import _native
from ..contract import typed
from ..errors import DomainError, DthHammerError, FmuNotFoundError, reading, warn
from ..extras import need
from ..outputs import check, whole
from ..scene import quantities
from ..scene.hammers import Hammerlike, Rocklike, scene_of
from ..scene.variables import UNTIL, VARIABLES
from ..scene.variables import whole as whole_of
from .package import PARTNER, Package, inspect, load
from .variant import configure, start_values

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription, ModelVariable

HAMMER = "hammer"
#: Default communication step, s; `examples/pressure_model.py` compares it with others.
STEP = 1e-5
SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
#: Namespace of the annotation that gives libcosim its step; other hosts ignore it.
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
#: Namespace of the annotation that gives OMSimulator its step; without it, it refuses the file.
OMS = "urn:oms"
#: Inputs that a drive gives, one value for each step, and the sources that read them.
DRIVEN = ("drive_force", "drive_pressure", "return_pressure")
SOURCES = ("Force", "Pressure")
DELAY, IMPEDANCE, SOURCE = "coupling.delay", "drive.impedance", "drive.source"
#: Types that a connector may have. Enumerations are left out, as they refer to another file.
TYPES = ("Real", "Integer", "Boolean", "String", "Float64", "Int32")
#: Types that have a unit.
REALS = ("Real", "Float64")
#: Default exponents of the base units, and default offset and factor of a unit.
BASES = dict.fromkeys(("kg", "m", "s", "A", "K", "mol", "cd", "rad", "offset"), 0) | {"factor": 1}

#: A variable of a component: the name of the component and the name of the variable.
Port = tuple[str, str]


class Connections(list[tuple[Port, Port]]):
    """Connections from outputs to inputs; ``chosen`` says which settings were made, and why."""

    chosen: str = ""


@typed()
def write_system(
    hammer: Hammerlike,
    out: str | Path,
    partners: Mapping[str, str | Path],
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    step: float | str = STEP,
    until: float | str = UNTIL,
    fmu: str | Path | Package | None = None,
    fmi: int = 2,
) -> Connections:
    """Writes an archive (``.ssp``) of a hammer and its partners, connected by name.

    With FMI 2 the archive follows SSP 1.0. With FMI 3 it follows SSP 2.0, and partners may be FMUs
    of FMI 2.0 or FMI 3.0.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        out: the .ssp to write.
        partners: FMUs for co-simulation by the names of their components, for instance a drive.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        step: communication step that the file proposes, s, or text with a unit.
        until: end time that the file proposes, s, or text with a unit.
        fmu: FMU of the hammer to use instead of the package's own.
        fmi: version of FMI, 2 or 3, of the package's own FMU.

    Where a partner gives the drive's force or pressure, `coupling.delay` is 1.5, unless the hammer
    sets it. This is right in a host that steps all units at once, for a partner that moves to the
    given position or takes differences of volumes. It is 1 for a partner that holds a flow, and 0.5
    for one that looks ahead. With `drive.impedance` it is 1, for the wave of a line.

    Returns the connections, each from an output to an input, and what was chosen.

    Raises:
        DthHammerError: a partner shares no variable with the hammer, or two partners give the same
            input.
        FmuNotFoundError: a partner is not an FMU for co-simulation of a suitable version.
    """
    package = load(fmu, fmi=fmi)
    size = quantities.duration(step, "step")
    end = quantities.duration(until, "until")
    descriptions = {HAMMER: _described(package.path, package.fmi)}
    for name, path in partners.items():
        if not (name.isidentifier() and name.isascii()) or name in descriptions:
            problem = f"a partner cannot be called {name!r}"
            raise DomainError(f"{problem}: use a word other than {HAMMER!r}")
        descriptions[name] = _described(Path(path), package.fmi)
    connected = _connect(descriptions)
    # The hammer comes last, so that hosts which initialise the components in order pass it the
    # start values of its partners.
    descriptions[HAMMER] = descriptions.pop(HAMMER)
    out = check(out, (".ssp",))
    scene = scene_of(hammer, rock, preset)
    ports = [port for _, (component, port) in connected if component == HAMMER]
    given, _ = start_values(package.description, scene)
    delay, connected.chosen = _coupled(given, ports)
    scene = replace(scene, parameters={**scene.parameters, **delay})
    for _, sentence in _native.unread(given | delay, ports):
        warn(sentence)
    with tempfile.TemporaryDirectory() as folder:
        hammer_file = Path(folder, f"{HAMMER}.fmu")
        configure(scene, hammer_file, fmu=package)
        files = {HAMMER: hammer_file} | {name: Path(path) for name, path in partners.items()}
        _write(out, _structure(_identifier(out.stem), descriptions, connected, size, end), files)
    return connected


def _coupled(given: Mapping[str, float], ports: Iterable[str]) -> tuple[dict[str, float], str]:
    """Returns the delay for a host that steps all units at once, and the reason for it."""
    numbers = whole_of(given)
    driven = [port for port in ports if port in DRIVEN]
    if not driven or VARIABLES[SOURCE].labels[int(numbers[SOURCE])] not in SOURCES:
        return {}, ""
    if DELAY in given:
        return {}, f"{DELAY} = {numbers[DELAY]:g}, as the hammer has it"
    wave = numbers[IMPEDANCE] > 0.0
    delay, of = (1.0, "the wave of a line") if wave else (1.5, "a position, or differenced volumes")
    others = "" if wave else "; 1 if it holds a flow, 0.5 if it looks ahead"
    why = f"readers of .ssp step all at once, and {', '.join(driven)} stands for {of}{others}"
    return {DELAY: delay}, f"{DELAY} = {delay:g}: {why}"


def _identifier(name: str) -> str:
    """Returns the name of a system as an identifier, which OMSimulator requires."""
    word = re.sub(r"[^0-9A-Za-z_]", "_", name)
    return word if word.isidentifier() else f"_{word}"


def _described(path: Path, fmi: int) -> ModelDescription:
    fmpy = need("fmpy")
    with reading(path, "an FMU", FmuNotFoundError):
        with zipfile.ZipFile(path) as archive:
            inspect(archive, PARTNER)
        description: ModelDescription = fmpy.read_model_description(path)
    versions = ["2.0", "3.0"][: fmi - 1]
    if description.fmiVersion not in versions or description.coSimulation is None:
        wanted = " or ".join(versions)
        raise FmuNotFoundError(f"{path} is not a co-simulation FMU of FMI {wanted}")
    return description


def _ports(description: ModelDescription, causality: str) -> dict[str, ModelVariable]:
    """Returns the scalar ports of a component by name."""
    return {
        v.name: v
        for v in description.modelVariables
        if v.causality == causality and v.type in TYPES and not v.dimensions
    }


def _connect(descriptions: Mapping[str, ModelDescription]) -> Connections:
    hammer, connections = descriptions[HAMMER], Connections()
    hammer_inputs, hammer_outputs = _ports(hammer, "input"), _ports(hammer, "output")
    sources: dict[str, str] = {}
    for name, partner in descriptions.items():
        if name == HAMMER:
            continue
        given_ports = [n for n in _ports(partner, "output") if n in hammer_inputs]
        taken_ports = [n for n in _ports(partner, "input") if n in hammer_outputs]
        if not given_ports and not taken_ports:
            raise DthHammerError(
                f"{name} shares no name with the hammer, which takes {', '.join(hammer_inputs)}"
            )
        for port in given_ports:
            if port in sources:
                raise DthHammerError(f"both {sources[port]} and {name} give {port}")
            sources[port] = name
        connections += [((name, port), (HAMMER, port)) for port in given_ports]
        connections += [((HAMMER, port), (name, port)) for port in taken_ports]
    return connections


def _structure(
    name: str,
    descriptions: Mapping[str, ModelDescription],
    connected: Connections,
    step: float,
    end: float,
) -> bytes:
    """Returns the text of ``SystemStructure.ssd``."""
    for prefix, uri in (("ssd", SSD), ("ssc", SSC), ("osp", OSP), ("oms", OMS)):
        ET.register_namespace(prefix, uri)
    version = {"2.0": "1.0", "3.0": "2.0"}[descriptions[HAMMER].fmiVersion]
    tool = {"version": version, "name": name, "generationTool": package_name}
    root = ET.Element(f"{{{SSD}}}SystemStructureDescription", tool)
    system = ET.SubElement(root, f"{{{SSD}}}System", {"name": name})
    elements = ET.SubElement(system, f"{{{SSD}}}Elements")
    given = {taker for _, taker in connected}
    for component, description in descriptions.items():
        _add_component(elements, component, description, given)
    _add_units(root, descriptions.values())
    connections = ET.SubElement(system, f"{{{SSD}}}Connections")
    for (giver, output), (taker, taken) in connected:
        ends = {"startElement": giver, "startConnector": output}
        ends |= {"endElement": taker, "endConnector": taken}
        ET.SubElement(connections, f"{{{SSD}}}Connection", ends)
    _add_master(system, step)
    _add_experiment(root, step, end)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text


def _add_component(
    elements: ET.Element, name: str, description: ModelDescription, given: set[Port]
) -> None:
    where = {"type": "application/x-fmu-sharedlibrary", "source": _place(name)}
    node = ET.SubElement(elements, f"{{{SSD}}}Component", {"name": name} | where)
    connectors = ET.SubElement(node, f"{{{SSD}}}Connectors")
    defined = {unit.name for unit in description.unitDefinitions if unit.baseUnit}
    for kind in ("input", "output"):
        for port, variable in _ports(description, kind).items():
            # Leave out unconnected inputs: some hosts would set them to 0 instead of keeping their
            # start values.
            if kind == "input" and (name, port) not in given:
                continue
            attributes = {"name": port, "kind": kind}
            connector = ET.SubElement(connectors, f"{{{SSD}}}Connector", attributes)
            has_unit = variable.type in REALS and variable.unit in defined
            unit = {"unit": variable.unit} if has_unit else {}
            ET.SubElement(connector, f"{{{SSC}}}{variable.type}", unit)


def _add_units(root: ET.Element, descriptions: Iterable[ModelDescription]) -> None:
    """Defines every unit that a connector uses, copied from the components' descriptions."""
    wanted = {name for node in root.iter() if (name := node.get("unit"))}
    defined = [unit for d in descriptions for unit in d.unitDefinitions if unit.baseUnit]
    base_units = {unit.name: unit.baseUnit for unit in defined}
    units = ET.SubElement(root, f"{{{SSD}}}Units")
    for name in sorted(wanted):
        unit = ET.SubElement(units, f"{{{SSC}}}Unit", {"name": name})
        numbers = {part: getattr(base_units[name], part) for part in BASES}
        # Attributes with their default value may be left out.
        written = {part: repr(x) for part, x in numbers.items() if x != BASES[part]}
        ET.SubElement(unit, f"{{{SSC}}}BaseUnit", written)


def _add_master(system: ET.Element, step: float) -> None:
    notes = ET.SubElement(system, f"{{{SSD}}}Annotations")
    note = ET.SubElement(notes, f"{{{SSC}}}Annotation", {"type": "org.openmodelica"})
    own = ET.SubElement(note, f"{{{OMS}}}Annotations")
    information = ET.SubElement(own, f"{{{OMS}}}SimulationInformation")
    master = {"description": "oms-ma", "stepSize": repr(step)}
    # OMSimulator reads both, although a fixed step needs neither.
    master |= {"absoluteTolerance": "1e-4", "relativeTolerance": "1e-4"}
    ET.SubElement(information, f"{{{OMS}}}FixedStepMaster", master)


def _add_experiment(root: ET.Element, step: float, end: float) -> None:
    times = {"startTime": "0.0", "stopTime": repr(end)}
    experiment = ET.SubElement(root, f"{{{SSD}}}DefaultExperiment", times)
    notes = ET.SubElement(experiment, f"{{{SSD}}}Annotations")
    note = ET.SubElement(notes, f"{{{SSC}}}Annotation", {"type": "com.opensimulationplatform"})
    algorithm = ET.SubElement(note, f"{{{OSP}}}Algorithm")
    ET.SubElement(algorithm, f"{{{OSP}}}FixedStepAlgorithm", {"baseStepSize": repr(step)})


def _place(component: str) -> str:
    return f"resources/{component}.fmu"


def _write(out: Path, structure: bytes, files: Mapping[str, Path]) -> None:
    with whole(out) as new, zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", structure)
        for component, file in files.items():
            archive.write(file, _place(component), zipfile.ZIP_STORED)
