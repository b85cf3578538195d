"""Hosts by other authors, one test each: their trajectories must agree with fmpy's.

docs/hosts.md tells what is exercised here, host by host.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import posixpath
import re
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from zipfile import ZipFile

import fmpy
import numpy as np
import pandas as pd
import pytest
from cofmupy import Coordinator
from fmu import Instance, Package
from hosting import END, SCENE, STEP, Trajectory, assert_same, simulated
from lxml import etree
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from pathsim_fmi import CoSimulationFMU
from programs import ran
from sofirpy import simulate

pytestmark = pytest.mark.usefixtures("scratch")


def test_the_description_is_valid_by_the_schema_of_fmi_2(package: Package) -> None:
    schemas = Path(fmpy.__file__).with_name("schema") / "fmi2"
    schema = etree.XMLSchema(etree.parse(schemas / "fmi2ModelDescription.xsd"))
    description = etree.parse(Path(package.folder) / "modelDescription.xml")
    assert schema.validate(description), schema.error_log
    # The schema must refuse something.
    description.getroot().set("guide", "")
    assert not schema.validate(description)


def test_sofirpy(fmu_path: Path, outputs: list[str], expected: Trajectory) -> None:
    with contextlib.redirect_stderr(io.StringIO()):  # a progress bar
        table = simulate(
            stop_time=END,
            step_size=STEP,
            fmu_paths={"hammer": fmu_path},
            start_values={"hammer": dict(SCENE)},
            parameters_to_log={"hammer": outputs},
        )
    assert_same({name: table[f"hammer.{name}"] for name in outputs}, expected)


def test_pathsim(fmu_path: Path, outputs: list[str], expected: Trajectory) -> None:
    feed = Constant(SCENE["feed_force"])
    hammer = CoSimulationFMU(str(fmu_path), start_values=dict(SCENE), dt=STEP)
    simulation = Simulation(
        [feed, hammer], [Connection(feed, hammer["feed_force"])], dt=STEP, log=False
    )
    rows = [hammer.fmu_wrapper.get_outputs_as_array()]
    while len(rows) <= round(END / STEP):
        simulation.timestep()
        rows.append(hammer.fmu_wrapper.get_outputs_as_array())
    ports = list(hammer.fmu_wrapper.output_refs)
    found = dict(zip(ports, np.transpose(rows), strict=True))
    assert_same({name: found[name] for name in outputs}, expected)


def without_step_size(fmu: Path, folder: Path) -> Path:
    """A copy whose DefaultExperiment names no step size.

    CoFmuPy 1.0.0 cannot start an FMU with one: it takes the smallest of fmpy's texts, for which
    numpy has no function. Everything else is as packaged.
    """
    copy = folder / fmu.name
    name = "modelDescription.xml"
    with ZipFile(fmu) as source, ZipFile(copy, "w") as target:
        for entry in source.infolist():
            data = source.read(entry)
            if entry.filename == name:
                step = rb'(<DefaultExperiment\b[^>]*) stepSize="[^"]*"'
                data, count = re.subn(step, rb"\1", data)
                assert count == 1
            target.writestr(entry, data)
    return copy


def test_cofmupy(fmu_path: Path, tmp_path: Path, outputs: list[str], expected: Trajectory) -> None:
    coordinator = Coordinator()
    copy = without_step_size(fmu_path, tmp_path)
    fmu = {"id": "hammer", "path": str(copy), "initialization": SCENE}
    coordinator.start({"fmus": [fmu], "connections": []})
    rows = [[coordinator.get_variable(("hammer", name))[0] for name in outputs]]
    for _ in range(round(END / STEP)):
        coordinator.do_step(STEP)
        rows.append([coordinator.get_variable(("hammer", name))[0] for name in outputs])
    assert_same(dict(zip(outputs, np.transpose(rows), strict=True)), expected)
    # The host's own record starts at the end of the first step.
    recorded = coordinator.get_results()
    for name in outputs:
        assert list(recorded["hammer", name]) == [row[outputs.index(name)] for row in rows[1:]]


def program(name: str, *arguments: str) -> str:
    """Returns the output of a program of the environment."""
    return ran([Path(sys.executable).with_name(name), *arguments])


def test_fmutool_finds_the_fmu_compliant(fmu_path: Path) -> None:
    message = program("fmutool", "-input", str(fmu_path), "-check")
    assert "seems to be compliant with FMI-2.0" in message
    assert "No semantic error against the FMI-2 standard" in message


FED = {"feed_force": SCENE["feed_force"]}


def contain(folder: Path, plan: Mapping[str, object], fmi: int = 2) -> Path:
    """Returns the FMU that `fmucontainer` makes of those in a folder, with its master in C."""
    name = "container.fmu"
    defaults = {
        "name": name,
        "mt": False,
        "auto_link": False,
        "auto_input": True,
        "auto_output": True,
    }
    file = folder / "container.json"
    file.write_text(json.dumps(defaults | dict(plan)), encoding="utf-8")
    options = ["-fmi", str(fmi), "-container", file.name]
    program("fmucontainer", "-fmu-directory", str(folder), *options)
    return folder / name


def test_fmucontainer(
    fmu_path: Path, tmp_path: Path, outputs: list[str], expected: Trajectory
) -> None:
    shutil.copy(fmu_path, tmp_path)
    start = [[fmu_path.name, name, value] for name, value in SCENE.items()]
    plan = {"step_size": STEP, "fmu": [fmu_path.name], "start": start}
    assert_same(simulated(contain(tmp_path, plan), outputs, start_values=FED), expected)


def test_fmucontainer_sees_each_blow_of_fmi_3(fmu_path: Path, tmp_path: Path) -> None:
    """fmucontainer uses no early return, but learns from a step that it contained an event."""
    three = fmu_path.with_name("dth_hammer_fmi3.fmu")
    shutil.copy(three, tmp_path)
    start = [[three.name, name, value] for name, value in SCENE.items()]
    plan = {"step_size": STEP, "fmu": [three.name], "start": start}
    made, outputs = contain(tmp_path, plan, fmi=3), ["event_kind", "blow_count"]
    result = simulated(made, outputs, stop_time=0.25, start_values=FED)
    assert sum(result["event_kind"] == 1) == result["blow_count"][-1] >= 5


# A feed that eases with the penetration of the last blow, through a lag of 10 ms:
# x' = 100 (u2 - 1e6 u1 - x), y = x, with u2 = x(0) = 6 kN.
VALVE = {"-A": [[-100.0]], "-B": [[-1e8, 100.0]], "-C": [[1.0]], "-x0": [6e3], "-u0": [0.0, 6e3]}
PEER_STEP, PEER_END = 2e-4, 0.1


@pytest.mark.skipif(shutil.which("gcc") is None, reason="qfmu compiles its FMU by gcc")
def test_fmucontainer_with_a_qfmu_controller(
    fmu_path: Path, tmp_path: Path, package: Package, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # qfmu leaves its archive where it is called
    shutil.copy(fmu_path, tmp_path)
    valve = tmp_path / "valve.fmu"
    matrices = [text for key, value in VALVE.items() for text in (key, json.dumps(value))]
    program("qfmu", "ss", *matrices, "-dt", str(PEER_STEP / 10), "-o", str(valve))

    loop = coupled(package, valve)
    assert loop["blow_count"][-1] >= 2
    assert np.ptp(loop["feed_force_chosen"]) > 500.0, "the controller controls nothing"

    plan = {
        "step_size": PEER_STEP,
        "sequential": True,
        # In this order from the initialisation on, so that the hammer rests under the valve's feed.
        "fmu": [valve.name, fmu_path.name],
        "link": [
            [fmu_path.name, "blow_penetration", valve.name, "u1"],
            [valve.name, "y1", fmu_path.name, "feed_force"],
        ],
        # A linked variable is an output only if it is named here.
        "output": [
            [fmu_path.name, "blow_penetration", "blow_penetration"],
            [valve.name, "y1", "feed_force_chosen"],
        ],
    }
    made, ways = contain(tmp_path, plan), {"stop_time": PEER_END, "start_values": {}}
    assert_same(simulated(made, list(loop), step=PEER_STEP, **ways), loop)


def coupled(package: Package, valve: Path) -> Trajectory:
    """Runs the same two FMUs in a loop over fmpy, one after the other."""
    names = ["piston_position", "bit_position", "tip_depth", "blow_penetration", "blow_count"]
    with Package(valve) as peer:
        found: dict[str, list[float]] = {name: [] for name in [*names, "feed_force_chosen"]}
        with Instance(package, FED) as hammer, Instance(peer) as controller:
            for step in range(round(PEER_END / PEER_STEP) + 1):
                if step > 0:
                    controller.set("u1", hammer.get("blow_penetration"))
                    controller.advance(step * PEER_STEP)
                    hammer.set("feed_force", controller.get("y1"))
                    hammer.advance(step * PEER_STEP)
                for name, value in zip(names, hammer.read(names), strict=True):
                    found[name].append(value)
                found["feed_force_chosen"].append(controller.get("y1"))
    return found


ROOT = Path(__file__).parents[2]
BENCHMARK = ROOT / "evidence" / "hosts"


in_rust = pytest.mark.weekly  # 152 crates are compiled: 70 s of the processor


@pytest.fixture(scope="module")
def importer() -> Path:
    """The host in Rust."""
    target = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "importer"
    manifest = ROOT / "tests" / "importer" / "Cargo.toml"
    options = ["--quiet", "--locked", "--manifest-path", manifest, "--target-dir", target]
    ran([os.environ.get("CARGO", "cargo"), "build", *options])
    return target / "debug" / "importer"


def imported(importer: Path, fmu: Path, folder: Path) -> pd.DataFrame:
    """Returns the table that the crate fmi-rs makes of the scene."""
    rows = folder / "rows.csv"
    starts = [f"{name}={value!r}" for name, value in SCENE.items()]
    ran([importer, fmu, repr(STEP), repr(END), rows, *starts])
    return pd.read_csv(rows)


def at_points(rows: pd.DataFrame) -> pd.DataFrame:
    """Returns rows at communication points: two half way, where a file restored the state."""
    steps = rows["time"] / STEP
    rows = rows[abs(steps - steps.round()) < 1e-9]
    first = rows.groupby(steps.round()).first()
    pd.testing.assert_frame_equal(first, rows.groupby(steps.round()).last(), check_exact=True)
    return first


@in_rust
def test_fmi_rs(
    importer: Path, fmu_path: Path, tmp_path: Path, outputs: list[str], expected: Trajectory
) -> None:
    rows = at_points(imported(importer, fmu_path, tmp_path))
    assert_same({name: rows[name].to_numpy() for name in outputs}, expected)


@in_rust
def test_fmi_rs_with_events_of_fmi_3(
    importer: Path, fmu_path: Path, tmp_path: Path, outputs: list[str], expected: Trajectory
) -> None:
    rows = imported(importer, fmu_path.with_name("dth_hammer_fmi3.fmu"), tmp_path)
    points = at_points(rows)
    assert_same({name: points[name].to_numpy() for name in outputs}, expected)
    # Each event is recorded before and after it is handled.
    blows = (rows["blow_count"] > 0) & (rows["time"] == rows["blow_time"])
    events = rows[blows].drop_duplicates()
    assert len(events) == expected["blow_count"][-1] > 0


@in_rust
def test_fmi_rs_keeps_the_events_of_the_benchmark(importer: Path, tmp_path: Path) -> None:
    rows = tmp_path / "rows.csv"
    ran([importer, BENCHMARK / "unit" / "thrown_fmi3.fmu", "0.001", "0.021", rows])
    assert "| 11 of 11 | 11 of 11 |" in ran([sys.executable, BENCHMARK / "score.py", rows])


def test_fmuloader(fmu_path: Path, outputs: list[str], expected: Trajectory) -> None:
    # For Python 3.11 and newer. fmuloader cannot load a unit of FMI 2.0 without model exchange.
    loader = pytest.importorskip("fmuloader.fmi3")
    file = fmu_path.with_name("dth_hammer_fmi3.fmu")
    description = fmpy.read_model_description(str(file))
    reference = {v.name: v.valueReference for v in description.modelVariables}
    told, token = [reference[name] for name in outputs], description.instantiationToken
    with loader.Fmi3Slave(file, model_identifier="dth_hammer") as hammer:
        hammer.instantiate_co_simulation("hammer", instantiation_token=token)
        hammer.enter_initialization_mode()
        hammer.set_float64([reference[name] for name in SCENE], list(SCENE.values()))
        hammer.exit_initialization_mode()
        rows = [hammer.get_float64(told)]
        for step in range(round(END / STEP)):
            hammer.do_step(step * STEP, STEP)
            rows.append(hammer.get_float64(told))
        hammer.terminate()
        hammer.free_instance()
    assert_same(dict(zip(outputs, np.transpose(rows), strict=True)), expected)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("suffix", ["", "_fmi3"])
def test_a_host_checks_itself_by_the_archives_reference(fmu_path: Path, suffix: str) -> None:
    """Compares with the reference files in the archive, within the tolerance in its manifest."""
    file, folder = fmu_path.with_stem(fmu_path.stem + suffix), "extra/org.fmi-standard.fmi-ls-ref/"
    with ZipFile(file) as archive:
        manifest = etree.fromstring(archive.read(f"{folder}fmi-ls-manifest.xml"))
        for related in manifest.iter("Related"):
            archive.getinfo(posixpath.normpath(folder + related.get("source")))
        inputs, expected = (
            np.genfromtxt(io.BytesIO(archive.read(f"{folder}{name}")), delimiter=",", names=True)
            for name in ("reference_in.csv", "reference_out.csv")
        )
    names = [*expected.dtype.names[1:]]
    found = fmpy.simulate_fmu(file, stop_time=0.2, output_interval=1e-3, input=inputs, output=names)
    for name in names:
        assert np.abs(found[name] - expected[name]).max() < 1e-9 * np.abs(expected[name]).max()
