"""The reference hammer's settled response: the figures that the demo prints."""

from __future__ import annotations

import pytest
from figure import Record
from fmu import Package
from reference import Stationary, table

# Tolerances are those of the published numbers, which two solvers made: a unit or
# two of the last digit printed.


def test_the_period_is_the_published_one(figures: Stationary) -> None:
    assert figures.period == pytest.approx(45.389e-3, abs=0.002e-3)


def test_the_rate_of_penetration_is_the_published_one(figures: Stationary) -> None:
    assert figures.rop == pytest.approx(33.99e-3, abs=0.05e-3)


def test_the_impact_speed_is_the_published_one(figures: Stationary) -> None:
    assert figures.speed == pytest.approx(11.28, abs=0.01)


def test_a_blow_is_two_collisions_of_the_published_durations(figures: Stationary) -> None:
    assert figures.collisions == 2
    assert figures.durations == pytest.approx((0.0661e-3, 0.0653e-3), abs=0.0002e-3)


def test_the_main_drilling_cycle_lasts_what_the_paper_says(figures: Stationary) -> None:
    # "about 0.4 ms" and 0.40 published, sampled at 1 us.
    assert figures.drilling_cycle == pytest.approx(0.40e-3, abs=0.006e-3)


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
    # Drilling cycles with lift-off, then without, then no motion that counts: in a
    # window sampled at 1 us, since shorter spells than that exist but do not matter.
    _, record = response
    after = record.between(0.0, 4e-3).mode
    spells = [m for i, m in enumerate(after) if i == 0 or m != after[i - 1]]
    kinds = ["DissipativeForward", "Forward", "Backward", "FreeFlight"]
    firsts = [spells.index(kind) for kind in kinds]
    assert firsts == sorted(firsts)
    last_flight = len(spells) - 1 - spells[::-1].index("FreeFlight")
    assert set(spells[last_flight + 1 :]) >= {"DissipativeForward", "Backward"}
