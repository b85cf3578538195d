"""What the tests share: the packaged FMU, unpacked once, and what the first host says of it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import fmpy
import pytest
from figure import Record
from fmu import Package
from hosting import END, PEAKS, SCENE, STEP, Trajectory
from reference import Stationary, stationary

FMU = Path(__file__).parents[2] / "dist" / "dth_hammer.fmu"


@pytest.fixture(scope="session")
def fmu_path() -> Path:
    assert FMU.is_file(), f"{FMU.name} is not packaged: run `cargo fmu`"
    return FMU


@pytest.fixture(scope="session")
def package(fmu_path: Path) -> Iterator[Package]:
    with Package(fmu_path) as package:
        yield package


@pytest.fixture(scope="session")
def response(package: Package) -> tuple[Stationary, Record]:
    """The reference hammer's settled response, simulated once."""
    return stationary(package)


@pytest.fixture(scope="session")
def figures(response: tuple[Stationary, Record]) -> Stationary:
    return response[0]


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Hosts unpack an FMU, and leave it where they did."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))


@pytest.fixture(scope="session")
def outputs(package: Package) -> list[str]:
    return [name for name in package.names("output") if name not in PEAKS]


@pytest.fixture(scope="session")
def expected(fmu_path: Path, outputs: list[str]) -> Trajectory:
    result = fmpy.simulate_fmu(
        str(fmu_path),
        stop_time=END,
        step_size=STEP,
        output_interval=STEP,
        start_values=SCENE,
        output=outputs,
    )
    assert len(result) == round(END / STEP) + 1
    assert result["blow_count"][-1] >= 1
    return {name: result[name] for name in outputs}
