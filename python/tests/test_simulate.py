"""From parameters to a table of results."""

import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    Hammer,
    HammerWarning,
    Run,
    UnknownNameError,
    mesh_for,
    simulate,
)
from dth_hammer.scene.signals import instants_of
from dth_hammer.scene.variables import VARIABLES, model
from dth_hammer.simulation.run import PER_BLOW, PER_STEP
from dth_hammer.testing import assert_energy_balanced, assert_periodic


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(until=0.6)


def test_the_table_has_units_types_and_where_it_came_from(run: Run) -> None:
    usual = [v.name for v in VARIABLES.of("output", "local") if v.name not in PER_STEP]
    assert list(run.frame) == usual
    assert {*PER_STEP} <= {*run.blows}
    assert run.units["rop"] == VARIABLES["rop"].unit
    assert run["contact_closed"].dtype == bool
    assert list(run["rock_mode"].cat.categories) == [*VARIABLES["rock_mode"].labels.values()]
    assert run.scene.until == 0.6
    assert run.model == model()


def test_times_are_the_steps_and_the_last_is_the_end() -> None:
    short = simulate(until=0.01, step=0.003, outputs=["tip_depth"])
    assert short.time.tolist() == pytest.approx([0.0, 0.003, 0.006, 0.009, 0.01])
    # The quotient is above 7 by a rounding error.
    assert len(instants_of(2.1, 0.3)) == 8


def test_the_table_survives_parquet(run: Run, tmp_path: Path) -> None:
    run.frame.to_parquet(tmp_path / "run.parquet")
    again = pd.read_parquet(tmp_path / "run.parquet")
    pd.testing.assert_frame_equal(again, run.frame)
    assert again.attrs == run.frame.attrs


def test_the_reference_hammer_settles_and_keeps_its_energy(run: Run) -> None:
    assert_energy_balanced(run)
    assert_periodic(run, relative=1e-5)
    with pytest.raises(AssertionError, match="blow_period still varies"):
        assert_periodic(replace(run, blows=run.blows.iloc[:5]), relative=1e-5)
    with pytest.raises(AssertionError, match="energy is off"):
        assert_energy_balanced(replace(run, frame=run.frame.assign(energy_residual=1.0)))


@pytest.mark.parametrize("step", [0.6, 0.25, 1e-2, 1e-4])
def test_the_table_of_blows_does_not_depend_on_how_often_one_looks(run: Run, step: float) -> None:
    table = simulate(until=0.6, step=step, outputs=["rop"]).blows
    # Forces and works of blows are recorded even if no outputs are named.
    other = run.blows[[*table]]
    assert len(table) == run["blow_count"].iloc[-1] > 10
    assert table.index.tolist() == [*range(1, len(table) + 1)]
    # Each way of stepping finds an event's instant anew, and rounds alike, so there is no
    # tolerance.
    pd.testing.assert_frame_equal(table, other, check_exact=True)
    assert table.attrs["units"].items() <= run.blows.attrs["units"].items()


def test_the_table_is_the_engine_s_own_journal(run: Run) -> None:
    # The table of a run equals the blows of one step, in which nothing is joined.
    with Hammer(record=True) as hammer:
        assert hammer.step_blows()["blow_time"] == []
        hammer.advance(0.6)
        message = hammer.step_blows()
        assert hammer["blow_count"] == len(message["blow_time"])
    assert run.blows.to_dict("list") == message
    assert [*run.blows][: len(PER_BLOW)] == [*PER_BLOW]


def test_the_blows_are_what_the_outputs_have_of_the_last_one(run: Run) -> None:
    table, frame = run.blows, run.frame
    for name in PER_BLOW:
        # Equal at the sample after each blow, except for outputs that the blow's period completes.
        message = frame.loc[frame["blow_count"].diff() > 0, name]
        np.testing.assert_array_equal(message.to_numpy(), table[name].to_numpy(), err_msg=str(name))


def test_blows_have_the_units_of_their_table(run: Run) -> None:
    changed = run.convert({"rop": "m/h", "blow_period": "ms", "tip_depth": "in"})
    assert changed.blows.attrs["units"]["rop"] == changed.units["rop"] == "m/h"
    np.testing.assert_allclose(changed.blows["rop"], 3600.0 * run.blows["rop"], rtol=1e-15)
    np.testing.assert_allclose(changed["tip_depth"], run["tip_depth"] / 0.0254, rtol=1e-15)
    assert changed.convert("us").blows.attrs["units"]["blow_speed"] == "ft/s"
    with pytest.raises(UnknownNameError, match="tip_depth"):
        run.convert({"tip_dept": "mm"})


def test_a_column_of_a_long_run_is_not_paid_for_with_copies(run: Run) -> None:
    # pandas copies a table's attributes at every operation, so none may grow with the run.
    for table in (run.frame, run.blows):
        assert all(copy.deepcopy(value) is value for value in table.attrs.values())


def test_blows_of_steps_that_a_control_makes_are_said_to_be_missing(run: Run) -> None:
    def control(hammer: Hammer) -> None:
        hammer.advance(hammer.time + 0.15)

    # Blows during the control's own steps are in no step of the run.
    with pytest.warns(HammerWarning, match="blows are missing"):
        table = simulate(until=0.6, step=0.2, control=control).blows
    assert set(table["blow_time"]) < set(run.blows["blow_time"])


def test_an_input_over_time_is_a_function_or_a_table() -> None:
    ramp = pd.Series([5e3, 8e3], index=[0.0, 0.1])
    names = ["tip_depth", "energy_feed"]
    one = simulate(until=0.1, inputs={"feed_force": ramp}, outputs=names)
    two = simulate(until=0.1, inputs={"feed_force": lambda t: 5e3 + 3e4 * t}, outputs=names)
    # Straight lines are exact at any step.
    three = simulate(until=0.1, inputs={"feed_force": ramp}, outputs=names, step=0.02)
    np.testing.assert_allclose(one.frame, two.frame, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(one.frame.iloc[-1], three.frame.iloc[-1], rtol=1e-9)


def test_a_control_acts_before_each_step() -> None:
    sampled: list[float] = []

    def control(hammer: Hammer) -> None:
        sampled.append(hammer.time)
        hammer.set({"rock.stiffness": 2e8})

    simulate(until=0.003, control=control, outputs=["rop"])
    assert sampled == pytest.approx([0.0, 0.001, 0.002])


def test_a_force_asked_for_on_a_mesh_made_for_a_rate_is_warned_of() -> None:
    asked = ["rock_force_peak", "tip_depth"]

    def warnings(**more: object) -> tuple[str, ...]:
        return simulate(until=1e-3, **{"outputs": asked, **more}).warnings  # type: ignore[arg-type]

    (text,) = warnings()
    assert text.startswith("rock_force_peak: ")
    assert "mesh_for(of='force')" in text
    assert "stresses" in warnings(outputs=["tip_depth"], waves=True)[0]
    # No warning: for rates, with a mesh for forces, and for rigid bodies.
    assert warnings(outputs=["tip_depth"]) == ()
    assert warnings(hammer=mesh_for(of="force").parameters) == ()
    assert warnings(hammer={"fidelity": "Rigid"}) == ()
