"""The drive by chambers, through the FMU."""

from __future__ import annotations

import numpy as np
import pytest
from dth_hammer import DomainError, Hammer, simulate, stationary

CHAMBERS = {"drive.source": "Chambers"}
PORTS = [f"{chamber}.{port}" for chamber in ("drive", "return") for port in ("supply", "exhaust")]
LEVELS = [f"chambers.{port}.{way}_pressure" for port in PORTS for way in ("open", "shut")]


def test_it_blows_alike_however_it_is_stepped() -> None:
    tables = [simulate(CHAMBERS, until=0.15, step=step).blows for step in (1e-4, 0.15)]
    names = ["blow_time", "blow_speed", "blow_energy"]
    assert len(tables[0]) >= 3
    for name in names:
        assert [*tables[0][name]] == [*tables[1][name]]


def test_the_pressures_make_the_force_and_stay_between_the_levels() -> None:
    names = ["drive_chamber_pressure", "return_chamber_pressure", "applied_drive_force"]
    frame = simulate(CHAMBERS, until=0.1, step=1e-4, outputs=names)
    drive, back, force = (frame[name].to_numpy() for name in names)
    with Hammer(CHAMBERS) as hammer:
        areas = [hammer[f"drive.area_{chamber}"] for chamber in ("drive", "return")]
        levels = [hammer[name] for name in LEVELS]
    # Two products and a difference.
    rounding = 4 * np.finfo(float).eps * max(levels) * max(areas)
    assert np.allclose(force, areas[0] * drive - areas[1] * back, rtol=0, atol=rounding)
    both = np.concatenate([drive, back])
    assert min(levels) <= both.min() < 0.2 * both.max() < both.max() <= max(levels)


def test_a_state_in_mid_stroke_goes_on_as_it_would_have() -> None:
    names = ["relative_position", "drive_chamber_pressure", "energy_drive", "event_count"]
    with Hammer(CHAMBERS) as hammer:
        hammer.step(0.0093)
        state = hammer.save()
        hammer.step(0.05)
        ahead = hammer.get(names)
        hammer.restore(state)
        hammer.step(0.05)
        assert hammer.get(names) == ahead


def test_its_cycle_is_what_a_run_settles_to_and_has_derivatives() -> None:
    name = "drive.area_drive"
    cycle = stationary(CHAMBERS, [name])
    with Hammer(CHAMBERS) as hammer:
        hammer.advance(4.0)
        assert hammer["blow_period"] == pytest.approx(cycle.period, rel=1e-6)
    at = cycle.values[name]
    low, high = (stationary({**CHAMBERS, name: at * (1 + w * 1e-5)}).period for w in (-1.0, 1.0))
    slope = (high - low) / (2e-5 * at)
    assert cycle.gradient.loc["period", name] == pytest.approx(slope, rel=1e-4)


def test_a_number_that_no_port_has_is_refused_by_name() -> None:
    with pytest.raises(DomainError, match=r"chambers\.drive\.supply\.open_time = -1"):
        Hammer(CHAMBERS | {"chambers.drive.supply.open_time": -1.0})
