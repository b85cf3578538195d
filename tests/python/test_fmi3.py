"""The archive of FMI 3.0: the hammer of FMI 2.0, whose steps end at events."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from fmu import Package
from hosting import END, SCENE, STEP, Trajectory


@pytest.fixture(scope="module")
def three_path(fmu_path: Path) -> Path:
    path = fmu_path.with_name("dth_hammer_fmi3.fmu")
    assert path.is_file(), f"{path.name} is not packaged: run `cargo fmu`"
    return path


@pytest.fixture(scope="module")
def three(three_path: Path) -> Iterator[Package]:
    with Package(three_path) as package:
        yield package


def simulated(path: Path, outputs: list[str], **more: object) -> Trajectory:
    result = fmpy.simulate_fmu(
        str(path),
        stop_time=END,
        step_size=STEP,
        output_interval=STEP,
        start_values=SCENE,
        output=outputs,
        **more,
    )
    return {name: result[name] for name in ["time", *outputs]}


def test_fmpy_finds_nothing_wrong(three_path: Path) -> None:
    assert validate_fmu(str(three_path)) == []


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


def test_with_events_the_host_is_there_at_each_blow(three_path: Path) -> None:
    outputs = ["blow_count", "blow_time"]
    whole = simulated(three_path, outputs)
    early = simulated(three_path, outputs, use_event_mode=True, early_return_allowed=True)
    blows = set(whole["blow_time"][whole["blow_count"] > 0])
    assert blows
    assert not blows & set(whole["time"])
    assert set(early["time"]) - set(whole["time"]) == blows


def with_a_valve_outside(
    package: Package, stroke: float, force: float, *, step: float, end: float, read: list[str]
) -> tuple[list[float], int]:
    """The hammer under a force that a valve outside reverses at both ends of the stroke."""
    hammer = FMU3Slave(
        guid=package.description.guid,
        unzipDirectory=package.folder,
        modelIdentifier="dth_hammer",
        instanceName="hammer",
    )
    hammer.instantiate(eventModeUsed=True, earlyReturnAllowed=True)
    at = {name: variable.valueReference for name, variable in package.variables.items()}
    hammer.setInt64([at["drive.source"]], [2])
    hammer.setInt32([at["event.positions"]], [2])
    hammer.setFloat64([at["event.position[1]"], at["event.position[2]"]], [-stroke, 0.0])
    hammer.setFloat64([at["drive_force"]], [force])
    hammer.enterInitializationMode()
    hammer.exitInitializationMode()
    hammer.updateDiscreteStates()
    hammer.enterStepMode()
    time, point, calls = 0.0, 1, 0
    while time < end:
        target = min(point * step, end)
        event, _, early, time = hammer.doStep(time, target - time)
        calls, point = calls + 1, point + (not early)
        if event:
            hammer.enterEventMode()
            (position,) = hammer.getFloat64([at["relative_position"]])
            if (force < 0.0 and position <= -stroke) or (force > 0.0 and position >= 0.0):
                force = -force
                hammer.setFloat64([at["drive_force"]], [force])
            hammer.updateDiscreteStates()
            hammer.enterStepMode()
    values = hammer.getFloat64([at[name] for name in read])
    hammer.terminate()
    hammer.freeInstance()
    return values, calls


def test_a_valve_outside_in_steps_of_50_ms_is_the_relay_inside(
    fmu_path: Path, package: Package, three: Package
) -> None:
    end = 0.25
    read = ["blow_count", "blow_time", "blow_speed", "piston_position", "hole_depth"]
    names = [*read, "applied_drive_force"]
    inside = fmpy.simulate_fmu(str(fmu_path), stop_time=end, output_interval=0.05, output=names)
    assert inside["blow_count"][-1] > 3
    stroke, force = package.start("drive.stroke"), inside["applied_drive_force"][0]
    found, calls = with_a_valve_outside(three, stroke, force, step=0.05, end=end, read=read)
    for name, value in zip(read, found, strict=True):
        assert abs(value - inside[name][-1]) < 1e-10, name
    assert calls < 60
