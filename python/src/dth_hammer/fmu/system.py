"""A hammer and its drive in one file: an SSP system that a host couples.

With FMI 2.0 the file is of SSP 1.0, with FMI 3.0 of SSP 2.0.

The hammer in it starts as the scene, so a host need not set an enumeration, which many cannot.
Variables of equal names are connected: a drive that gives ``drive_pressure`` and takes
``relative_position`` needs no more to be said.
"""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from .. import __name__ as package_name
from .. import _native
from ..contract import typed
from ..errors import DomainError, DthHammerError, FmuNotFoundError, warn
from ..extras import need
from ..outputs import check, whole
from ..scene import quantities
from ..scene.hammers import Hammerlike, Rocklike, scene_of
from ..scene.variables import UNTIL
from .package import Package, load
from .variant import configure, start_values

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription, ModelVariable

HAMMER = "hammer"
#: Step of the exchange that is proposed, s: `examples/pressure_model.py` measures others.
STEP = 1e-5
SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
#: What libcosim reads its step from; others pass over it.
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
#: Types that a connector can have without naming another file's enumeration.
TYPES = ("Real", "Integer", "Boolean", "String", "Float64", "Int32")
#: Those that have a unit; exponents of base units, offset and factor where nothing is said.
REALS = ("Real", "Float64")
BASES = dict.fromkeys(("kg", "m", "s", "A", "K", "mol", "cd", "rad", "offset"), 0) | {"factor": 1}

#: A variable of a component: the component's name, the variable's.
Port = tuple[str, str]


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
) -> list[tuple[Port, Port]]:
    """Writes an archive (``.ssp``) of a hammer and its partners, connected by name.

    It is of SSP 1.0, or of SSP 2.0 if the hammer is of FMI 3.0: then partners may be of either.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        out: the .ssp to write.
        partners: FMUs for co-simulation by the names of their components, for instance a drive.
        preset: parameter set that a mapping is laid over.
        rock: beside it: a name, a class or a strength, or a file, as `dth_hammer.rock` takes them.
        step: step of the exchange that the file proposes, s, or text with a unit.
        until: end that the file proposes, s, or text with a unit.
        fmu: file of the hammer, in place of the one in the package.
        fmi: version of FMI, 2 or 3, of the one in the package.

    Returns what is connected, from an output to an input.

    Raises:
        DthHammerError: if a partner has nothing to do with the hammer, or two give one input.
        FmuNotFoundError: if a partner is no FMU for co-simulation of such a version.
    """
    package = load(fmu, fmi=fmi)
    size = quantities.duration(step, "step")
    end = quantities.duration(until, "until")
    descriptions = {HAMMER: _described(package.path, package.fmi)}
    for name, path in partners.items():
        if not name.isidentifier() or name in descriptions:
            what = f"a partner cannot be called {name!r}"
            raise DomainError(f"{what}: use a word other than {HAMMER!r}")
        descriptions[name] = _described(Path(path), package.fmi)
    connected = _connect(descriptions)
    # The hammer comes last: hosts that initialise in order then pass it its partners' start values.
    descriptions[HAMMER] = descriptions.pop(HAMMER)
    out = check(out, (".ssp",))
    scene = scene_of(hammer, rock, preset)
    ports = [port for _, (component, port) in connected if component == HAMMER]
    for _, why in _native.unread(start_values(package.description, scene)[0], ports):
        warn(why)
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder, f"{HAMMER}.fmu")
        configure(scene, own, fmu=package)
        files = {HAMMER: own} | {name: Path(path) for name, path in partners.items()}
        _write(out, _structure(out.stem, descriptions, connected, size, end), files)
    return connected


def _described(path: Path, fmi: int) -> ModelDescription:
    fmpy = need("fmpy")
    try:
        description: ModelDescription = fmpy.read_model_description(path)
    except Exception as error:
        text = " ".join(str(error).split()) or type(error).__name__
        raise FmuNotFoundError(f"{path} is not a readable FMU: {text}") from None
    versions = ["2.0", "3.0"][: fmi - 1]
    if description.fmiVersion not in versions or description.coSimulation is None:
        wanted = " or ".join(versions)
        raise FmuNotFoundError(f"{path} is not a co-simulation FMU of FMI {wanted}")
    return description


def _ports(description: ModelDescription, causality: str) -> dict[str, ModelVariable]:
    """A component's ports, by name; an array is none."""
    return {
        v.name: v
        for v in description.modelVariables
        if v.causality == causality and v.type in TYPES and not v.dimensions
    }


def _connect(descriptions: Mapping[str, ModelDescription]) -> list[tuple[Port, Port]]:
    hammer, found = descriptions[HAMMER], []
    wanted, offered = _ports(hammer, "input"), _ports(hammer, "output")
    sources: dict[str, str] = {}
    for name, partner in descriptions.items():
        if name == HAMMER:
            continue
        gives = [n for n in _ports(partner, "output") if n in wanted]
        takes = [n for n in _ports(partner, "input") if n in offered]
        if not gives and not takes:
            raise DthHammerError(
                f"{name} shares no name with the hammer, which takes {', '.join(wanted)}"
            )
        for port in gives:
            if port in sources:
                raise DthHammerError(f"both {sources[port]} and {name} give {port}")
            sources[port] = name
        found += [((name, port), (HAMMER, port)) for port in gives]
        found += [((HAMMER, port), (name, port)) for port in takes]
    return found


def _structure(
    name: str,
    descriptions: Mapping[str, ModelDescription],
    connected: list[tuple[Port, Port]],
    step: float,
    end: float,
) -> bytes:
    """The text of ``SystemStructure.ssd``."""
    for prefix, uri in (("ssd", SSD), ("ssc", SSC), ("osp", OSP)):
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
            # An input that nothing gives keeps its start value: some hosts would set it to 0.
            if kind == "input" and (name, port) not in given:
                continue
            attributes = {"name": port, "kind": kind}
            connector = ET.SubElement(connectors, f"{{{SSD}}}Connector", attributes)
            has_unit = variable.type in REALS and variable.unit in defined
            unit = {"unit": variable.unit} if has_unit else {}
            ET.SubElement(connector, f"{{{SSC}}}{variable.type}", unit)


def _add_units(root: ET.Element, descriptions: Iterable[ModelDescription]) -> None:
    """Defines every unit that a connector names, as the component's own description does."""
    wanted = {name for node in root.iter() if (name := node.get("unit"))}
    defined = [unit for d in descriptions for unit in d.unitDefinitions if unit.baseUnit]
    base_units = {unit.name: unit.baseUnit for unit in defined}
    units = ET.SubElement(root, f"{{{SSD}}}Units")
    for name in sorted(wanted):
        unit = ET.SubElement(units, f"{{{SSC}}}Unit", {"name": name})
        numbers = {part: getattr(base_units[name], part) for part in BASES}
        # What is 0, or of a factor 1, need not be written.
        written = {part: repr(x) for part, x in numbers.items() if x != BASES[part]}
        ET.SubElement(unit, f"{{{SSC}}}BaseUnit", written)


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
