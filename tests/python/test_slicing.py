"""The trajectory does not depend on how the host slices time."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest
from fmu import Instance, Package

END = 0.1


def single() -> list[float]:
    return [END]


def even() -> list[float]:
    return [END * i / 1000 for i in range(1, 1001)]


def uneven() -> list[float]:
    # Sizes over eight decades, as an adaptive host makes them.
    dice = random.Random(2)
    sizes = [10 ** dice.uniform(-8, 0) for _ in range(1000)]
    total, times = sum(sizes), []
    for size in sizes:
        times.append((times[-1] if times else 0.0) + END * size / total)
    return [*times[:-1], END]


@pytest.fixture(scope="module")
def watched(package: Package) -> list[str]:
    # A peak is defined over the last communication step, so it does depend on it.
    peaks = {"contact_force_peak", "rock_force_peak"}
    return [n for n in package.names("output") if n not in peaks]


@pytest.fixture(scope="module")
def reference(package: Package, watched: list[str]) -> tuple[list[float], list[float]]:
    """Final values with even steps, and the largest magnitude each had."""
    largest = [0.0] * len(watched)
    with Instance(package) as hammer:
        for time in even():
            hammer.advance(time)
            values = hammer.read(watched)
            largest = [max(a, abs(b)) for a, b in zip(largest, values, strict=True)]
    return values, largest


COUNTS = {"event_count", "contact_count", "blow_count", "rock_cycle_count"}


@pytest.mark.parametrize("slices", [single, uneven], ids=["one", "random"])
def test_slicing_changes_nothing(
    package: Package,
    watched: list[str],
    reference: tuple[list[float], list[float]],
    slices: Callable[[], list[float]],
) -> None:
    with Instance(package) as hammer:
        for time in slices():
            hammer.advance(time)
        values = dict(zip(watched, hammer.read(watched), strict=True))
    expected = dict(zip(watched, reference[0], strict=True))
    largest = dict(zip(watched, reference[1], strict=True))
    assert set(watched) >= COUNTS
    assert expected["blow_count"] >= 2
    # The residual is itself a rounding error: its measure is the work done.
    largest["energy_residual"] = largest["energy_drive"]
    for name in watched:
        if name in COUNTS:
            assert values[name] == expected[name], name
        else:
            assert values[name] == pytest.approx(expected[name], abs=1e-9 * largest[name]), name
