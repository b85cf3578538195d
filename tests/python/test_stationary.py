"""The settled response of the reference hammer, as the demo reads it; test_readme has its rows."""

from __future__ import annotations

import pytest
from figure import Record
from fmu import Instance, Package
from reference import Stationary, table


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


def test_a_blow_is_two_collisions_of_the_durations_of_waves(figures: Stationary) -> None:
    assert figures.collisions == 2
    # 2 T1, and what the contact's own time Z / KC, 0.5e-6 s, adds: a front is no sharper.
    assert figures.durations == pytest.approx((0.0650e-3, 0.0650e-3), abs=3 * 0.53e-6)


def test_the_main_drilling_cycle_lasts_what_the_paper_says(figures: Stationary) -> None:
    # "about 0.4 ms": half a unit of the digit that is printed.
    assert figures.drilling_cycle == pytest.approx(0.4e-3, abs=0.05e-3)


def test_the_table_names_every_figure_of_the_paper(figures: Stationary, package: Package) -> None:
    printed = table(figures, package)
    for figure in ("about 45 ms", "two", "2 T1 = 0.065 ms", "about 0.4 ms"):
        assert figure in printed


def test_the_bit_goes_through_the_paper_s_sequence(response: tuple[Stationary, Record]) -> None:
    # Sampled at 1 us: shorter spells exist, and do not matter.
    figures, record = response
    after = record.between(0.0, 20e-3).mode
    spells = [m for i, m in enumerate(after) if i == 0 or m != after[i - 1]]
    # The main cycle loads through the barrier, unloads and lifts off.
    main = spells.index("Forward")
    assert spells[main - 1] == "DissipativeForward"
    assert spells[main + 1] == "Backward"
    assert "FreeFlight" in spells[main:]
    assert spells.count("Forward") > 1
    # After the last flight drilling cycles without lift-off, until the bit stands still.
    last_flight = len(spells) - 1 - spells[::-1].index("FreeFlight")
    ending = spells[last_flight + 1 :]
    assert ending.count("DissipativeForward") >= 2
    assert ending.count("Backward") >= 2
    assert set(ending[:-1]) == {"DissipativeForward", "Backward"}
    assert ending[-1] == "Standstill"
    assert figures.standstill == pytest.approx(38.4e-3, abs=0.05e-3)
    assert abs(record.bit_velocity[record.time < 20e-3][-1]) < 1e-3
