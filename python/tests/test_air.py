"""A hammer that air drives goes through what any other does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dth_hammer import Scene, SNCurve, figures, life, report, steady, sweep

PRESET = "air_4_inch"


def test_the_indicator_diagram_has_both_pressures_and_the_drive_s_work() -> None:
    cycle = figures.settled_cycle({}, "0.5 s", preset=PRESET)
    pressures, force = figures.indicator(cycle).axes
    assert [line.get_label() for line in pressures.lines] == ["drive chamber", "return chamber"]
    for line in pressures.lines:
        bars = np.asarray(line.get_ydata())
        # From the exhaust up to a little above the supply, where a chamber is compressed.
        assert 1.0 < bars.min() < bars.max() < 1.1 * 25.2
    work = steady(preset=PRESET)["energy_drive"]
    # The title's number is rounded to 1 J, and the loop's is a sum of trapezia.
    assert float(force.get_title(loc="left").split()[0]) == pytest.approx(work, rel=5e-3)


def test_a_sweep_over_the_supply_has_its_air() -> None:
    table = sweep({"supply_pressure": ["15 bar", "20 bar"]}, "steady", preset=PRESET, error=0.01)
    low, high = table["air_flow"]
    # Choked ports: in proportion to the pressure, and more because the hammer strikes faster.
    assert high / low > 20.0 / 15.0
    assert table["rop"].is_monotonic_increasing


def test_an_air_hammer_has_a_report_with_its_air(tmp_path: Path) -> None:
    scene = Scene("x", "", PRESET, {}, {}, 0.5)
    text = report(scene, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Indicator diagram" in text
    assert "free air" in text


def test_an_air_hammer_has_a_life() -> None:
    hours = life(SNCurve("200 MPa", 1e7, 8), preset=PRESET).worst["hours"]
    assert 0.0 < hours < np.inf
    # Damage goes with the stress over the strength to the power of the slope.
    stronger = life(SNCurve("400 MPa", 1e7, 8), preset=PRESET).worst["hours"]
    assert stronger == pytest.approx(2.0**8 * hours, rel=1e-6)
