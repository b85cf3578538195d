"""Fixtures of the tests: the packaged FMU, unpacked once, and its trajectory in the first host."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import browser, opened, pages
from fmu import Package
from hosting import END, PEAKS, STEP, Trajectory, simulated

# Fixtures of the tests of the laboratory.
__all__ = ["browser", "opened", "pages"]
# Hosts in C++ that tests load into this process.
NATIVE_HOSTS = ("libcosimpy", "ecospy")
ended: list[int] = []


def pytest_sessionfinish(exitstatus: int) -> None:
    ended.append(int(exitstatus))


@pytest.hookimpl(trylast=True)
def pytest_unconfigure() -> None:
    """Ends without the destructors of foreign hosts, once everything has been told.

    With several of them in one process the heap has been found corrupt at its end, now and then and
    after all tests had passed. That the package's own programs end well is tested in processes of
    their own.
    """
    if ended and any(name in sys.modules for name in NATIVE_HOSTS):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(ended[-1])


FMU = Path(__file__).parents[2] / "dist" / "dth_hammer.fmu"


@pytest.fixture(scope="session")
def fmu_path() -> Path:
    assert FMU.is_file(), f"{FMU.name} is not packaged: run `cargo fmu`"
    return FMU


@pytest.fixture(scope="session")
def package(fmu_path: Path) -> Iterator[Package]:
    with Package(fmu_path) as package:
        yield package


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets hosts unpack FMUs into the test's own folder, because they leave them there."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))


@pytest.fixture(scope="session")
def outputs(package: Package) -> list[str]:
    return [name for name in package.names("output") if name not in PEAKS]


@pytest.fixture(scope="session")
def expected(fmu_path: Path, outputs: list[str]) -> Trajectory:
    result = simulated(fmu_path, outputs)
    assert len(result["time"]) == round(END / STEP) + 1
    assert result["blow_count"][-1] >= 1
    return {name: result[name] for name in outputs}
