"""The reference hammer's settled response: the figures that the demo prints."""

from __future__ import annotations

import pytest
from figure import Record
from fmu import Instance, Package
from reference import Stationary, table

# Tolerances are those of the published numbers, which two solvers made: a unit or
# two of the last digit printed.


def test_the_period_is_the_published_one(figures: Stationary) -> None:
    assert figures.period == pytest.approx(45.389e-3, abs=0.002e-3)


def test_the_rate_of_penetration_is_the_published_one(figures: Stationary) -> None:
    assert figures.tip_rate == pytest.approx(33.99e-3, abs=0.05e-3)


def test_the_speed_and_energy_of_a_blow_are_those_just_before_it(
    figures: Stationary, package: Package
) -> None:
    with Instance(package) as hammer:
        hammer.advance(figures.blows[-1] - 1e-9)
        speed = hammer.get("relative_velocity")
        mass = package.start("material.density") * package.start("cross_section")
        mass *= package.start("piston.length")
    # In a nanosecond the relay's force changes the speed by 5e-7 m/s.
    assert figures.speed == pytest.approx(speed, abs=1e-6)
    assert figures.energy == pytest.approx(mass * figures.speed**2 / 2, rel=1e-12)


def test_a_blow_is_two_collisions_of_the_published_durations(figures: Stationary) -> None:
    assert figures.collisions == 2
    assert figures.durations == pytest.approx((0.0661e-3, 0.0653e-3), abs=0.0002e-3)


def test_the_main_drilling_cycle_lasts_what_the_paper_says(figures: Stationary) -> None:
    # "about 0.4 ms": half a unit of the digit that is printed.
    assert figures.drilling_cycle == pytest.approx(0.4e-3, abs=0.05e-3)


def test_the_first_periods_are_the_published_ones(figures: Stationary) -> None:
    published = (44.188e-3, 44.984e-3, 45.300e-3, 45.370e-3, 45.385e-3, 45.388e-3, 45.389e-3)
    assert figures.first_periods == pytest.approx(published, abs=0.003e-3)


def test_the_energy_balance_closes(figures: Stationary) -> None:
    assert figures.residual < 1e-9


def test_the_table_names_every_figure_of_the_paper(figures: Stationary, package: Package) -> None:
    printed = table(figures, package)
    for figure in ("about 45 ms", "two", "2 T1 = 0.065 ms", "about 0.4 ms"):
        assert figure in printed


def test_the_bit_goes_through_the_paper_s_sequence(response: tuple[Stationary, Record]) -> None:
    # Sampled at 1 us: shorter spells exist, and do not matter.
    _, record = response
    after = record.between(0.0, 4e-3).mode
    spells = [m for i, m in enumerate(after) if i == 0 or m != after[i - 1]]
    # The main cycle loads through the barrier, unloads and lifts off.
    main = spells.index("Forward")
    assert spells[main - 1] == "DissipativeForward"
    assert spells[main + 1] == "Backward"
    assert "FreeFlight" in spells[main:]
    # After the last flight drilling cycles without lift-off, until nothing moves.
    last_flight = len(spells) - 1 - spells[::-1].index("FreeFlight")
    ending = spells[last_flight + 1 :]
    assert ending.count("DissipativeForward") >= 2
    assert ending.count("Backward") >= 1
    assert abs(record.bit_velocity[record.time < 20e-3][-1]) < 1e-6
