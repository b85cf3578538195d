"""The finite-element oracle against itself and the published numbers; no FMU."""

from __future__ import annotations

from typing import Any

import pytest
from oracle_fe import Hammer, Run, reference, simulate
from scenes import SHORT, SHORT_END, first_blow


@pytest.fixture(scope="module")
def short() -> Run:
    return simulate(SHORT, [0.0, SHORT_END], 1e-11)


def test_it_conserves_energy(short: Run) -> None:
    first, last = short.samples
    hammer = Hammer(SHORT)

    def stored(sample: dict[str, Any]) -> float:
        names = ("kinetic", "strain", "contact", "rock_stored")
        return sum(sample[f"energy_{name}"] for name in names)

    weight = SHORT["gravity"] * hammer.piston.mass
    work = last["energy_drive"] + weight * (last["piston_position"] - first["piston_position"])
    moved = last["bit_position"] - first["bit_position"]
    work += SHORT["gravity"] * hammer.bit.mass * moved
    work += SHORT["feed_force"] * (last["bit_top_position"] - first["bit_top_position"])
    spent = sum(last[f"energy_{n}"] for n in ("viscous", "rock_dissipated", "damping"))
    # Energies of 100 J at a relative tolerance of 1e-11 a step, a thousand steps or more.
    assert stored(last) - stored(first) + spent == pytest.approx(work, abs=1e-6)
    assert spent > 10.0  # not an idle scene


def test_it_conserves_momentum(short: Run) -> None:
    first, last = short.samples
    mass = Hammer(SHORT).piston.mass
    gain = mass * (last["piston_velocity"] - first["piston_velocity"])
    # The relay does not switch in this scene, so its impulse is force times time.
    assert not [e for e in short.events if e.guard == "Q10"]
    down = next(e.time for e in short.events if e.guard == "Q9")
    drive = SHORT["drive.amplitude"] * (down - (SHORT_END - down))
    impulse = drive + mass * SHORT["gravity"] * SHORT_END - last["contact_impulse"]
    assert gain == pytest.approx(impulse, abs=1e-8)


def test_its_first_period_is_the_published_one() -> None:
    (first, _), (second, _) = first_blow()["blows"]
    # Published to a microsecond.
    assert second - first == pytest.approx(44.188e-3, abs=0.5e-6)


def test_its_stored_numbers_are_what_it_makes(short: Run) -> None:
    stored = first_blow()
    index = stored["time"].index(0.014)
    run = simulate(reference(), stored["time"][: index + 1], 1e-12)
    assert [e.guard for e in run.events] == [
        e["guard"] for e in stored["events"] if e["time"] <= run.times[-1]
    ]
    for name, accuracy in stored["accuracy"].items():
        # Both runs may be off by the stated accuracy.
        expected = stored["samples"][name][index]
        assert run.samples[-1][name] == pytest.approx(expected, abs=2 * accuracy + 1e-15), name
