"""The FMU against the independent finite-element oracle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pytest
from fmu import Instance, Package
from oracle_fe import reference, simulate
from scenes import SHORT, SHORT_END, first_blow

# A collision is over when no other closing can belong to it.
SETTLED = 2e-4


def sampled(
    package: Package, scene: Mapping[str, float], times: Sequence[float], names: Sequence[str]
) -> dict[str, list[float]]:
    """The FMU's outputs at the given instants."""
    rows = []
    with Instance(package, scene) as hammer:
        for time in times:
            if time > hammer.time:
                hammer.advance(time)
            rows.append(hammer.read(names))
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))


def test_the_start_values_are_the_published_reference(package: Package) -> None:
    for name, value in reference().items():
        assert package.start(name) == value, name


def modes(package: Package, values: Sequence[float]) -> list[str]:
    labels = package.labels("rock_mode")
    return [labels[int(v)] for v in values]


def test_the_first_blow_is_the_oracle_s(package: Package) -> None:
    stored = first_blow()
    names = [n for n in stored["samples"] if n in package.variables]
    assert len(names) >= len(stored["samples"]) - 1
    found = sampled(package, {}, stored["time"], [*names, "rock_mode", "event_count"])
    assert modes(package, found["rock_mode"]) == stored["rock_mode"]
    assert found["event_count"][-1] == len(stored["events"])
    for name in names:
        # The oracle states the difference between its own runs at four tolerances. A
        # second independent run may be as far off on the other side, no more.
        close = 2 * stored["accuracy"][name]
        assert found[name] == pytest.approx(stored["samples"][name], abs=close), name


def test_the_first_blow_s_events_are_the_oracle_s(package: Package) -> None:
    stored = first_blow()
    closings = [e["time"] for e in stored["events"] if e["guard"] == "close"]
    openings = [e["time"] for e in stored["events"] if e["guard"] == "open"]
    with Instance(package) as hammer:
        hammer.advance(openings[0] + SETTLED)
        first = hammer.read(["blow_time", "contact_duration"])
        hammer.advance(openings[1] + SETTLED)
        second = hammer.read(["blow_time", "contact_duration"])
    accuracy = 2 * stored["event_time_accuracy"]
    assert first[0] == second[0] == pytest.approx(closings[0], abs=accuracy)
    durations = [b - a for a, b in zip(closings, openings, strict=True)]
    assert [first[1], second[1]] == pytest.approx(durations, abs=2 * accuracy)


def test_a_live_run_of_the_oracle_agrees(package: Package) -> None:
    # Another mesh, penalty, gap and start than the stored numbers, so that these cannot
    # have been fitted; and made here and now, so that oracle and numbers cannot part.
    times = [i * SHORT_END / 60 for i in range(61)]
    rough, fine = (simulate(SHORT, times, tolerance) for tolerance in (1e-9, 1e-11))
    names = [n for n in fine.samples[0] if n in package.variables and n != "rock_mode"]
    found = sampled(package, SHORT, times, [*names, "rock_mode", "event_count"])
    assert len(fine.events) > 20
    assert found["event_count"][-1] == len(fine.events)
    assert modes(package, found["rock_mode"]) == [s["rock_mode"] for s in fine.samples]
    for name in names:
        expected = [s[name] for s in fine.samples]
        pairs = zip(fine.samples, rough.samples, strict=True)
        # The finer run is better than its distance from the one a hundred times rougher.
        accuracy = max(abs(a[name] - b[name]) for a, b in pairs)
        scale: Any = max(map(abs, expected))
        close = accuracy + 1e-12 * scale
        assert found[name] == pytest.approx(expected, abs=close), name
