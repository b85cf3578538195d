"""What the FMU is as a file, and what bad input gets."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from fmu import Instance, Logger, Package

ERROR = 3


@pytest.fixture
def log() -> list[str]:
    return []


@pytest.fixture
def logger(log: list[str]) -> Logger:
    """Keeps what is said of errors; that all is well is said too, by the way."""

    def write(_component: int, _name: bytes, status: int, _kind: bytes, text: bytes) -> None:
        if status == ERROR:
            log.append(text.decode())

    return write


def refused(action: Callable[[], object], function: str) -> None:
    """Runs what must end as fmi2Error of the named function."""
    with pytest.raises(FMICallException) as refusal:
        action()
    assert refusal.value.status == ERROR
    assert refusal.value.function == function


def test_the_validator_finds_nothing(fmu_path: Path) -> None:
    assert validate_fmu(str(fmu_path)) == []


WRONG = [
    ("rock.unloading_ratio", 1.0),
    ("rock.stiffness", -1.0),
    ("cross_section", 0.0),
    ("material.damping_time", -1e-9),
    ("piston.elements", 0),
    ("bit.elements", 401),
]


@pytest.mark.parametrize(("name", "value"), WRONG)
def test_a_wrong_parameter_is_named_and_the_instance_survives(
    package: Package, logger: Logger, log: list[str], name: str, value: float
) -> None:
    with Instance(package, logger=logger) as hammer:
        hammer.slave.reset()
        refused(lambda: hammer.begin({name: value}), "fmi2ExitInitializationMode")
        (line,) = log
        message = re.search(rf"{re.escape(name)} = (\S+) is not allowed: it must be", line)
        assert message
        assert float(message[1]) == value
        hammer.slave.reset()
        hammer.begin({})
        hammer.advance(0.02)
        assert hammer.get("blow_count") == 1


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_none_is_refused_and_changes_nothing(
    package: Package, logger: Logger, log: list[str], value: float
) -> None:
    with Instance(package, logger=logger) as hammer:
        before = hammer.get("feed_force")
        refused(lambda: hammer.set("feed_force", value), "fmi2SetReal")
        assert len(log) == 1
        assert hammer.get("feed_force") == before
        hammer.advance(1e-3)


def test_a_wrong_guid_gives_no_instance(
    package: Package, logger: Logger, log: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(package.description, "guid", "{another}")
    with pytest.raises(Exception, match="Failed to instantiate"):
        Instance(package, logger=logger)
    (line,) = log
    assert "another" in line
