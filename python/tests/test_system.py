"""One file of SSP 1.0 with the hammer and its drive; hosts run it in tests/python."""

from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

import container
import fmpy
import pytest
from dth_hammer import PRESETS, VARIABLES, DomainError, DthHammerError, HammerWarning
from dth_hammer.errors import FmuNotFoundError
from dth_hammer.fmu import find, write_system
from fmpy.ssp.ssd import get_connections, read_ssd
from fmpy.validation import validate_fmu
from lxml import etree

SCENE = {"drive.source": "Air"}
#: A drive with a pressure as output, as far as a file of SSP needs it.
DRIVE = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="drive" guid="1">
  <CoSimulation modelIdentifier="drive"/>
  <ModelVariables>
    <ScalarVariable name="relative_position" valueReference="0" causality="input">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="drive_pressure" valueReference="1" causality="output">
      <Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return container.build_compressor(tmp_path_factory.mktemp("drive"))


def test_a_system_is_valid_by_the_schema_of_ssp_1(drive: Path, tmp_path: Path) -> None:
    file = tmp_path / "one.ssp"
    write_system(SCENE, file, {"drive": drive}, step="20 us", until="0.3 s")
    schemas = Path(fmpy.__file__).with_name("ssp") / "schema"
    schema = etree.XMLSchema(etree.parse(schemas / "SystemStructureDescription.xsd"))
    with ZipFile(file) as archive:
        structure = etree.fromstring(archive.read("SystemStructure.ssd"))
    assert schema.validate(structure), schema.error_log
    experiment = structure.find("{*}DefaultExperiment")
    assert experiment is not None
    assert experiment.attrib == {"startTime": "0.0", "stopTime": "0.3"}
    connectors = {node.get("name"): node for node in structure.iter("{*}Connector")}
    assert connectors["supply_pressure"][0].get("unit") == "Pa"
    assert connectors["blow_count"][0].get("unit") == "1"
    pascal = structure.find("{*}Units/{*}Unit[@name='Pa']/{*}BaseUnit")
    assert pascal is not None
    assert pascal.attrib == {"kg": "1", "m": "-1", "s": "-2"}
    # The schema is not one that lets everything through.
    structure[0].set("kind", "")
    assert not schema.validate(structure)


def test_a_file_says_how_late_its_pressures_are(tmp_path: Path, cli: Callable[..., str]) -> None:
    """Its readers step all at once; a drive that is the hammer's own has no delay."""
    drive = tmp_path / "drive.fmu"
    with ZipFile(drive, "w") as archive:
        archive.writestr("modelDescription.xml", DRIVE)
    scene: dict[str, str | float] = {"drive.source": "Pressure", "drive.area_drive": 1e-3}
    own: dict[str, str | float]
    for own, expected in (
        ({}, "coupling.delay = 1.5: readers of .ssp step all at once"),
        ({"drive.impedance": 300.0}, "coupling.delay = 1: readers of .ssp step all at once"),
        ({"coupling.delay": 1.0}, "coupling.delay = 1, as the hammer has it"),
    ):
        file = tmp_path / "4 inch.ssp"
        words = [f"--set={name}={value}" for name, value in (scene | own).items()]
        said = cli("system", f"--partner=drive={drive}", *words, "-o", file)
        assert "drive.drive_pressure -> hammer.drive_pressure" in said
        assert expected in said
        with ZipFile(file) as archive:
            archive.extractall(tmp_path)
            structure = etree.fromstring(archive.read("SystemStructure.ssd"))
        described = fmpy.read_model_description(tmp_path / "resources" / "hammer.fmu")
        (delay,) = [v.start for v in described.modelVariables if v.name == "coupling.delay"]
        assert f"coupling.delay = {float(delay):g}" in said
        # OMSimulator needs a name that is an identifier, and its own master.
        assert structure.get("name") == structure.find("{*}System").get("name") == "_4_inch"
        (master,) = structure.iter("{urn:oms}FixedStepMaster")
        assert master.get("stepSize") == "1e-05"


def test_a_reader_of_ssp_finds_the_components_and_what_is_connected(
    drive: Path, tmp_path: Path
) -> None:
    file = tmp_path / "one.ssp"
    message = write_system(SCENE, file, {"drive": drive}, until=0.3)
    structure = read_ssd(str(file))
    assert [c.name for c in structure.system.elements] == ["drive", "hammer"]
    found = {
        (one.parent.name, one.name, two.parent.name, two.name)
        for one, two in get_connections(structure.system)
    }
    assert found == {(*one, *two) for one, two in message}
    assert found == {
        ("drive", "supply_pressure", "hammer", "supply_pressure"),
        ("hammer", "air_mass", "drive", "air_mass"),
    }


def test_the_hammer_in_it_starts_as_the_scene(drive: Path, tmp_path: Path) -> None:
    file = tmp_path / "one.ssp"
    write_system(SCENE | {"feed_force": "6 kN"}, file, {"drive": drive}, preset="air_4_inch")
    with ZipFile(file) as archive:
        archive.extractall(tmp_path)
    hammer = tmp_path / "resources" / "hammer.fmu"
    assert validate_fmu(str(hammer)) == []
    described = fmpy.read_model_description(hammer).modelVariables
    starts = {v.name: v.start for v in described}
    assert float(starts["feed_force"]) == 6e3
    assert VARIABLES["drive.source"].labels[int(starts["drive.source"])] == "Air"
    assert float(starts["rock.stiffness"]) == PRESETS["air_4_inch"].values["rock.stiffness"]
    assert (tmp_path / "resources" / "drive.fmu").read_bytes() == drive.read_bytes()


def test_with_fmi_3_it_is_a_system_of_ssp_2(drive: Path, tmp_path: Path) -> None:
    file = tmp_path / "one.ssp"
    events = {"event.positions": 1, "event.position[1]": -0.02}
    connected = write_system(SCENE | events, file, {"drive": drive}, fmi=3)
    with ZipFile(file) as archive:
        archive.extractall(tmp_path)
        structure = etree.fromstring(archive.read("SystemStructure.ssd"))
    assert structure.get("version") == "2.0"
    ends = ("startElement", "startConnector", "endElement", "endConnector")
    found = [tuple(c.get(end) for end in ends) for c in structure.iter("{*}Connection")]
    assert found == [(*one, *two) for one, two in connected]
    types = {
        (component.get("name"), etree.QName(connector[0]).localname)
        for component in structure.iter("{*}Component")
        for connector in component.iter("{*}Connector")
    }
    # `event_kind` is a real output too, because some hosts read every output as real.
    assert types == {("hammer", "Float64"), ("drive", "Real")}
    hammer = tmp_path / "resources" / "hammer.fmu"
    assert validate_fmu(str(hammer)) == []
    starts = {v.name: v.start for v in fmpy.read_model_description(hammer).modelVariables}
    assert float(starts["event.position[1]"]) == -0.02
    with pytest.raises(FmuNotFoundError, match=r"not a co-simulation FMU of FMI 2\.0"):
        write_system(SCENE, file, {"drive": hammer})


def test_what_cannot_be_a_system_is_told_and_nothing_is_written(
    drive: Path, tmp_path: Path
) -> None:
    out, text = tmp_path / "out" / "one.ssp", tmp_path / "text.fmu"
    text.write_text("no archive", encoding="utf-8")
    hammer, outside = find(), tmp_path / "outside.fmu"
    with ZipFile(outside, "w") as archive:
        archive.writestr("modelDescription.xml", DRIVE)
        archive.writestr("../evil", b"")
    for partners, error, message in (
        ({"drive": text}, FmuNotFoundError, "cannot be read as an FMU"),
        ({"drive": tmp_path / "none.fmu"}, FmuNotFoundError, r"none\.fmu"),
        ({"drive": outside}, FmuNotFoundError, r"would unpack '\.\./evil' outside"),
        ({"hammer": drive}, DomainError, "cannot be called 'hammer'"),
        ({"my drive": drive}, DomainError, "cannot be called 'my drive'"),
        ({"one": drive, "two": drive}, DthHammerError, "both one and two give supply_pressure"),
        ({"other": hammer}, DthHammerError, "other shares no name with the hammer"),
    ):
        with pytest.raises(error, match=message):
            write_system(SCENE, out, partners)
    with pytest.raises(DomainError, match="step = -1 s is not above 0"):
        write_system(SCENE, out, {"drive": drive}, step=-1)
    assert not out.parent.exists()


def test_a_drive_that_the_hammer_does_not_read_is_a_warning(drive: Path, tmp_path: Path) -> None:
    with pytest.warns(HammerWarning, match="pressure is ignored: drive.source is Relay"):
        write_system({}, tmp_path / "one.ssp", {"drive": drive})


def test_the_command(drive: Path, tmp_path: Path, cli: Callable[..., str]) -> None:
    words = ["system", f"--partner=drive={drive}", "--step=20 us", "--set=drive.source=Air"]
    said = cli(*words, "-o", tmp_path / "one.ssp")
    assert "drive.supply_pressure -> hammer.supply_pressure" in said
    assert "must end in .ssp" in cli(*words, "-o", tmp_path / "one.zip", code=2)
