"""What the tests share: the packaged FMU, unpacked once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from figure import Record
from fmu import Package
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
