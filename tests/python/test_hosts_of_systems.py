"""Hosts in C++ that run systems: one FMU, one with the scene's start values, a file of SSP 1.0.

docs/hosts.md tells what is exercised here, host by host.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import container
import dth_hammer
import numpy as np
import pytest
import system
from dth_hammer.fmu import configure, write_system
from dth_hammer.scene.variables import PRESETS
from hosting import END, SCENE, STEP, Trajectory, assert_same, in_python

pytestmark = pytest.mark.usefixtures("scratch")


@pytest.fixture
def libcosim() -> ModuleType:
    """Returns the Python binding of libcosim, the C++ host of the Open Simulation Platform."""
    return pytest.importorskip(
        "libcosimpy.CosimExecution", reason="libcosimpy has no wheel for this Python or platform"
    )


class Cosim:
    """An execution of libcosim, and the values of its slaves."""

    def __init__(self, execution: Any) -> None:
        self.execution = execution
        # By now the C library is loaded.
        observer = sys.modules["libcosimpy.CosimObserver"].CosimObserver
        self._observer = observer.create_last_value()
        assert execution.add_observer(self._observer)

    def references(self, slave: int) -> dict[str, int]:
        """Returns the value references by name."""
        return {v.name.decode(): v.reference for v in self.execution.slave_variables(slave)}

    def read(self, slave: int, names: Sequence[str]) -> list[float]:
        """Returns reals at the last communication point; others have no value here."""
        found = self.references(slave)
        values = self._observer.last_real_values(slave, [found[name] for name in names])
        assert values is not None
        return list(values)

    def play(self, slave: int, names: Sequence[str]) -> Trajectory:
        """Returns the trajectory after the start: libcosim shows no value before its first step."""
        rows = []
        for _ in range(round(END / STEP)):
            assert self.execution.step()
            rows.append(self.read(slave, names))
        return dict(zip(names, np.transpose(rows), strict=True))


def local(libcosim: ModuleType, file: Path) -> tuple[Cosim, int]:
    """An execution with one FMU."""
    execution = libcosim.CosimExecution.from_step_size(round(STEP * 1e9))
    slave = libcosim.CosimSlave.CosimLocalSlave(str(file), "hammer")
    return Cosim(execution), execution.add_local_slave(slave)


def after_start(trajectory: Trajectory) -> Trajectory:
    return {name: values[1:] for name, values in trajectory.items()}


def test_libcosim(
    libcosim: ModuleType, fmu_path: Path, outputs: list[str], expected: Trajectory
) -> None:
    host, slave = local(libcosim, fmu_path)
    for name, value in SCENE.items():
        assert host.execution.real_initial_value(slave, host.references(slave)[name], value)
    assert_same(host.play(slave, outputs), after_start(expected))


# libcosim and ecos cannot set an enumeration, so the file itself must start with it.
ENUMERATED = SCENE | {"fidelity": "Rigid"}


@pytest.fixture(scope="module")
def rigid(outputs: list[str]) -> Trajectory:
    """Returns the native module's results for the scene with its enumeration."""
    # The scene strikes harder than steel lasts, which makes a blow come early.
    with pytest.warns(dth_hammer.HammerWarning, match="does not last beyond"):
        frame = dth_hammer.simulate(ENUMERATED, END, step=STEP, outputs=outputs)
    return {name: frame[name].to_numpy() for name in outputs}


def test_libcosim_with_a_configured_fmu(
    libcosim: ModuleType, fmu_path: Path, tmp_path: Path, outputs: list[str], rigid: Trajectory
) -> None:
    file = tmp_path / "mine.fmu"
    configure(ENUMERATED, file, fmu=fmu_path)
    host, slave = local(libcosim, file)
    assert "fidelity" not in host.references(slave)
    assert_same(host.play(slave, outputs), after_start(rigid))


# One preset of each family; `.ci/weekly long` runs all.
FAMILIES = ("reference", "air_4_inch", "water_hammer", "top_hammer")


@pytest.mark.parametrize(
    "preset",
    [
        name if name in FAMILIES else pytest.param(name, marks=pytest.mark.weekly)
        for name in PRESETS
    ],
)
@pytest.mark.filterwarnings("ignore::dth_hammer.HammerWarning")
def test_libcosim_runs_the_system_of_each_preset(
    libcosim: ModuleType, fmu_path: Path, tmp_path: Path, preset: str
) -> None:
    """libcosim names a folder by the unit's token, so a long token prevented loading."""
    file, end = tmp_path / "hammer.ssp", 0.04
    write_system(preset, file, {}, step=STEP, until=end, fmu=fmu_path)
    host = Cosim(libcosim.CosimExecution.from_ssp_file(str(file)))
    assert host.execution.step(round(end / STEP))
    frame = dth_hammer.simulate(preset, end, step=STEP, outputs=list(SHOWN))
    expected = [frame[name].iloc[-1] for name in SHOWN]
    # Sums of steps are off by 40 * 7e-18 s, and no window of air ends at a host's step.
    assert host.read(0, SHOWN) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("preset", FAMILIES)
@pytest.mark.filterwarnings("ignore::dth_hammer.HammerWarning")
def test_ecos_runs_the_system_of_each_preset(
    ecos: ModuleType, fmu_path: Path, tmp_path: Path, preset: str
) -> None:
    file, end = tmp_path / "hammer.ssp", 0.04
    write_system(preset, file, {}, step=STEP, until=end, fmu=fmu_path)
    with ecos.EcosSimulation(STEP, ssp_path=str(file)) as simulation:
        assert simulation.init()
        simulation.step(round(end / STEP))
        found = [simulation.get_real(f"hammer::{name}") for name in SHOWN]
        simulation.terminate()
    frame = dth_hammer.simulate(preset, end, step=STEP, outputs=list(SHOWN))
    # The tolerance is that of libcosim's test.
    assert found == pytest.approx([frame[n].iloc[-1] for n in SHOWN], rel=1e-9, abs=1e-9)


@pytest.fixture
def ecos() -> ModuleType:
    """Returns the binding of Ecos, a host in C++, which needs the threading library tbb."""
    threads = Path(sys.prefix, "lib", "libtbb.so.12")
    if not threads.is_file():
        pytest.skip("ecospy's library is for x86-64, and its tbb is installed on Linux")
    ctypes.CDLL(str(threads), mode=ctypes.RTLD_GLOBAL)
    module: ModuleType = pytest.importorskip("ecospy")
    module.EcosLib.set_log_level("warn")
    return module


def ecos_trajectory(
    ecos: ModuleType, file: Path, outputs: Sequence[str], starts: Mapping[str, float]
) -> Trajectory:
    with ecos.EcosSimulationStructure() as structure:
        structure.add_model("hammer", str(file))
        structure.add_parameter_set("scene", {f"hammer::{n}": v for n, v in starts.items()})
        with ecos.EcosSimulation(STEP, structure=structure) as simulation:
            assert simulation.init(parameter_set="scene")
            rows = [[simulation.get_real(f"hammer::{name}") for name in outputs]]
            for _ in range(round(END / STEP)):
                simulation.step()
                rows.append([simulation.get_real(f"hammer::{name}") for name in outputs])
            simulation.terminate()
    return dict(zip(outputs, np.transpose(rows), strict=True))


def test_ecos(ecos: ModuleType, fmu_path: Path, outputs: list[str], expected: Trajectory) -> None:
    assert_same(ecos_trajectory(ecos, fmu_path, outputs, SCENE), expected)


def test_ecos_with_a_configured_fmu(
    ecos: ModuleType, fmu_path: Path, tmp_path: Path, outputs: list[str], rigid: Trajectory
) -> None:
    file = tmp_path / "mine.fmu"
    configure(ENUMERATED, file, fmu=fmu_path)
    assert_same(ecos_trajectory(ecos, file, outputs, {}), rigid)


SYSTEM_STEP, SYSTEM_END = 1e-3, 0.1
SHOWN = ("piston_position", "bit_position", "tip_depth", "blow_count", "blow_time", "blow_speed")


@pytest.fixture(scope="module")
def ssp(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Writes the hammer and its compressor as one file."""
    file = tmp_path_factory.mktemp("system") / "compressor.ssp"
    system.build(file, SYSTEM_STEP, SYSTEM_END)
    return file


@pytest.fixture(scope="module")
def loop() -> list[float]:
    """Runs both in a loop in Python, which steps both at once, as these hosts do."""
    found = container.run_loop(SYSTEM_END, SYSTEM_STEP, at_once=True, names=SHOWN)
    assert found["blow_count"] >= 2
    return [*found.values()]


# The differences are from rounding. Hosts sum their steps, which after 100 of 1e-3 s is off by 100
# * 1.1e-16 s = 1.1e-14 s, and the pressure jumps then. That may cut a window of air elsewhere, each
# of which is right to 1e-11. The piston's position passes zero at each blow, so its error counts on
# the stroke of 0.1 m: those of 600 windows add up randomly, to 25 * 1e-11 * 0.1 m.
def close(loop: list[float]) -> list[Any]:
    """Returns the loop's values as approximations that allow for rounding."""
    places = (2.5e-11 if name == "piston_position" else None for name in SHOWN)
    return [pytest.approx(x, rel=1e-9, abs=off) for x, off in zip(loop, places, strict=True)]


@in_python
def test_libcosim_runs_a_system_with_its_own_step(
    libcosim: ModuleType, ssp: Path, loop: list[float]
) -> None:
    host = Cosim(libcosim.CosimExecution.from_ssp_file(str(ssp)))
    slaves = {info.name.decode(): info.index for info in host.execution.slave_infos()}
    assert slaves.keys() == {"hammer", "compressor"}
    assert host.execution.step(round(SYSTEM_END / SYSTEM_STEP))
    # The time is in nanoseconds, and the step is the file's.
    assert host.execution.status().current_time == round(SYSTEM_END * 1e9)
    assert host.read(slaves["hammer"], SHOWN) == close(loop)


@in_python
def test_ecos_runs_a_system(ecos: ModuleType, ssp: Path, loop: list[float]) -> None:
    with ecos.EcosSimulation(SYSTEM_STEP, ssp_path=str(ssp)) as simulation:
        assert simulation.init()
        simulation.step(round(SYSTEM_END / SYSTEM_STEP))
        found = [simulation.get_real(f"hammer::{name}") for name in SHOWN]
        simulation.terminate()
    assert found == close(loop)
