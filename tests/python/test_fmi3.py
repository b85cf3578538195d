"""The archive of FMI 3.0: the hammer of FMI 2.0, with steps that end at events."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import container
import fmpy
import numpy as np
import pytest
from dth_hammer.fmu import write_system
from fmpy.validation import validate_fmu
from fmu import Package
from fmu_manipulation_toolbox.assembly import Assembly
from hosting import END, STEP, in_python, simulated
from lxml import etree


@pytest.fixture(scope="module")
def three_path(fmu_path: Path) -> Path:
    path = fmu_path.with_name("dth_hammer_fmi3.fmu")
    assert path.is_file(), f"{path.name} is not packaged: run `cargo fmu`"
    return path


@pytest.fixture(scope="module")
def three(three_path: Path) -> Iterator[Package]:
    with Package(three_path) as package:
        yield package


@pytest.fixture(scope="module", params=["fmi2", "fmi3"])
def either(request: pytest.FixtureRequest, fmu_path: Path, three_path: Path) -> Path:
    """Returns the archive of each standard."""
    return {"fmi2": fmu_path, "fmi3": three_path}[request.param]


def read(path: Path, name: str) -> bytes:
    with ZipFile(path) as archive:
        return archive.read(name)


def test_fmpy_finds_nothing_to_complain_of(either: Path) -> None:
    assert validate_fmu(str(either)) == []


def test_both_archives_have_the_same_library(fmu_path: Path, three_path: Path) -> None:
    def libraries(path: Path) -> set[bytes]:
        with ZipFile(path) as archive:
            names = [name for name in archive.namelist() if name.startswith("binaries/")]
            assert names
            return {archive.read(name) for name in names}

    assert libraries(fmu_path) == libraries(three_path)


def test_variables_are_those_of_fmi_2(package: Package, three: Package) -> None:
    types = {"Real": "Float64", "Integer": "Int32"}
    for name, two in package.variables.items():
        found = three.variables[name]
        assert found.type == types.get(two.type, two.type), name
        for attribute in ("valueReference", "causality", "variability", "unit", "min", "max"):
            assert getattr(found, attribute) == getattr(two, attribute), (name, attribute)
        assert (found.start or None) == (two.start or None), name


def test_results_are_those_of_fmi_2_to_the_bit(
    fmu_path: Path, three_path: Path, package: Package
) -> None:
    outputs = package.names("output")
    two, three = (simulated(path, outputs) for path in (fmu_path, three_path))
    assert len(two["time"]) == round(END / STEP) + 1
    assert two["blow_count"][-1] >= 1
    for name, values in two.items():
        np.testing.assert_array_equal(three[name], values, err_msg=name)


@in_python
def test_a_system_of_ssp_2_in_fmucontainer_is_the_loop_in_python(
    three_path: Path, tmp_path: Path
) -> None:
    step, end = 1e-3, 0.1
    names = ("piston_position", "bit_position", "tip_depth", "blow_count", "blow_time", "air_flow")
    file = tmp_path / "compressor.ssp"
    partners = {"compressor": container.build_compressor(tmp_path / "compressor")}
    write_system(container.SCENE, file, partners, step=step, fmu=three_path)
    assembly = Assembly(Path(file.name), fmu_directory=tmp_path, default_step_size=step)
    # The file itself has no ports, so the outputs are those of its components.
    assembly.root.auto_output = True
    assembly.make_fmu(fmi_version=3)
    made = file.with_suffix(".fmu")
    found = simulated(made, names, step=step, stop_time=end, start_values={})
    expected = [*container.run_loop(end, step, at_once=True, names=names).values()]
    assert expected[3] >= 2
    # Sums of the step are rounded differently, which changes the air within its error.
    assert [float(found[name][-1]) for name in names] == pytest.approx(expected, rel=1e-8)


def test_terminals_are_valid_and_of_variables_that_there_are(either: Path) -> None:
    schemas = Path(fmpy.__file__).with_name("schema") / "fmi3"
    schema = etree.XMLSchema(etree.parse(schemas / "fmi3TerminalsAndIcons.xsd"))
    terminals = etree.fromstring(read(either, "terminalsAndIcons/terminalsAndIcons.xml"))
    assert schema.validate(terminals), schema.error_log
    described = {v.name: v for v in fmpy.read_model_description(either).modelVariables}
    kinds = {
        terminal.get("name"): [
            described[member.get("variableName")].causality for member in terminal
        ]
        for terminal in terminals.iter("Terminal")
    }
    pair = ["input", "output"]
    drive, air = ["input"] * 2 + ["output"] * 6, ["input"] * 2 + ["output"] * 2
    assert kinds == {"drive": drive, "air": air, "feed": pair}
    # By the rule "plug", members are connected to those of the same name.
    for member in terminals.iter("TerminalMemberVariable"):
        assert member.get("memberName") == member.get("variableName")
    assert read(either, "terminalsAndIcons/icon.png").startswith(b"\x89PNG\r\n")
