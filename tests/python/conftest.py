"""What the tests share: the packaged FMU, unpacked once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from fmu import Package

FMU = Path(__file__).parents[2] / "dist" / "dth_hammer.fmu"


@pytest.fixture(scope="session")
def fmu_path() -> Path:
    assert FMU.is_file(), f"{FMU.name} is not packaged: run `cargo fmu`"
    return FMU


@pytest.fixture(scope="session")
def package(fmu_path: Path) -> Iterator[Package]:
    with Package(fmu_path) as package:
        yield package
