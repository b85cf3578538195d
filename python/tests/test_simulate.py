"""From parameters to a table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import DomainError, Hammer, blows, load, simulate
from dth_hammer.testing import assert_energy_balanced, assert_periodic


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    return simulate(until=0.6)


def test_the_table_has_units_types_and_where_it_came_from(frame: pd.DataFrame) -> None:
    variables = load().variables
    assert list(frame) == [v.name for v in variables.of("output", "local")]
    assert frame.attrs["units"]["rop"] == variables["rop"].unit
    assert frame["contact_closed"].dtype == bool
    assert list(frame["rock_mode"].cat.categories) == [*variables["rock_mode"].labels.values()]
    assert frame.attrs["fmu"] == load().version


def test_times_are_the_steps_and_the_last_is_the_end() -> None:
    frame = simulate(until=0.01, step=0.003, outputs=["hole_depth"])
    assert frame.index.tolist() == pytest.approx([0.0, 0.003, 0.006, 0.009, 0.01])
    with pytest.raises(DomainError):
        simulate(until=-1.0)


def test_the_table_survives_parquet(frame: pd.DataFrame, tmp_path: Path) -> None:
    frame.to_parquet(tmp_path / "run.parquet")
    again = pd.read_parquet(tmp_path / "run.parquet")
    pd.testing.assert_frame_equal(again, frame)
    assert again.attrs == frame.attrs


def test_the_reference_hammer_settles_and_keeps_its_energy(frame: pd.DataFrame) -> None:
    assert_energy_balanced(frame)
    assert_periodic(frame, relative=1e-5)
    with pytest.raises(AssertionError, match="blow_period still varies"):
        assert_periodic(frame[frame.index < 0.2], relative=1e-5)
    with pytest.raises(AssertionError, match="energy is off"):
        assert_energy_balanced(frame.assign(energy_residual=1.0))


def test_blows_do_not_depend_on_how_often_one_looks(frame: pd.DataFrame) -> None:
    coarse, fine = blows(simulate(until=0.6, step=0.02)), blows(frame)
    assert len(coarse) == len(fine) == frame["blow_count"].iloc[-1]
    np.testing.assert_allclose(coarse["blow_time"], fine["blow_time"], rtol=1e-9)


def test_an_input_over_time_is_a_function_or_a_table() -> None:
    ramp = pd.Series([5e3, 8e3], index=[0.0, 0.1])
    names = ["hole_depth", "energy_feed"]
    one = simulate(until=0.1, inputs={"feed_force": ramp}, outputs=names)
    two = simulate(until=0.1, inputs={"feed_force": lambda t: 5e3 + 3e4 * t}, outputs=names)
    # Straight lines: the same at any step.
    three = simulate(until=0.1, inputs={"feed_force": ramp}, outputs=names, step=0.02)
    np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(one.iloc[-1], three.iloc[-1], rtol=1e-9)


def test_a_control_acts_before_each_step() -> None:
    seen: list[float] = []

    def control(hammer: Hammer) -> None:
        seen.append(hammer.time)
        hammer.set({"rock.stiffness": 2e8})

    simulate(until=0.003, control=control, outputs=["rop"])
    assert seen == pytest.approx([0.0, 0.001, 0.002])
