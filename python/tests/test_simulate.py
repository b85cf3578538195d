"""From parameters to a table."""

from __future__ import annotations

import re
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    DomainError,
    DthHammerError,
    Hammer,
    HammerWarning,
    blows,
    convert,
    load,
    simulate,
)
from dth_hammer.run import PER_BLOW
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


@pytest.mark.parametrize("step", [0.6, 0.25, 1e-2, 1e-4])
def test_the_table_of_blows_does_not_depend_on_how_often_one_looks(
    frame: pd.DataFrame, step: float
) -> None:
    table, other = blows(simulate(until=0.6, step=step, outputs=["rop"])), blows(frame)
    assert len(table) == frame["blow_count"].iloc[-1] > 10
    assert table.index.tolist() == [*range(1, len(table) + 1)]
    # An event's instant is found anew in each slicing, and rounds alike: no tolerance.
    pd.testing.assert_frame_equal(table, other, check_exact=True)
    assert table.attrs["units"] == other.attrs["units"]


def test_the_table_is_the_engine_s_own_journal(frame: pd.DataFrame) -> None:
    # All of one step: nothing is put together here.
    with Hammer() as hammer:
        assert hammer.step_blows()["blow_time"] == []
        hammer.advance(0.6)
        told = hammer.step_blows()
        assert hammer["blow_count"] == len(told["blow_time"])
    assert blows(frame).to_dict("list") == told
    assert [*blows(frame)] == [*PER_BLOW]


def test_the_blows_are_what_the_outputs_have_of_the_last_one(frame: pd.DataFrame) -> None:
    table = blows(frame)
    for name in table:
        # At the sample after each blow, but for what its period completes.
        told = frame.loc[frame["blow_count"].diff() > 0, name]
        np.testing.assert_array_equal(told.to_numpy(), table[name].to_numpy(), err_msg=str(name))


def test_the_blows_of_a_part_are_those_in_it(frame: pd.DataFrame, tmp_path: Path) -> None:
    whole, part = blows(frame), blows(frame[(frame.index > 0.2) & (frame.index <= 0.4)])
    inside = whole[(whole["blow_time"] > 0.2) & (whole["blow_time"] <= 0.4)]
    pd.testing.assert_frame_equal(part, inside)
    frame.to_parquet(tmp_path / "run.parquet")
    pd.testing.assert_frame_equal(blows(pd.read_parquet(tmp_path / "run.parquet")), whole)
    early = blows(frame[frame.index < 0.01])
    assert early.empty
    assert list(early) == list(whole) == list(blows(frame[frame.index < 0.0]))


def test_blows_have_the_units_of_their_table(frame: pd.DataFrame) -> None:
    table = blows(convert(frame, {"rop": "m/h", "blow_period": "ms"}))
    expected = convert(blows(frame), {"rop": "m/h", "blow_period": "ms"})
    pd.testing.assert_frame_equal(table, expected, check_exact=True)
    assert table.attrs["units"] == expected.attrs["units"]
    assert convert(table, "us").attrs["units"]["blow_speed"] == "ft/s"


def without_journal(fmu: Path, folder: Path) -> Path:
    """An FMU that does not announce its blows, as one of an older make."""
    copy = folder / fmu.name
    with ZipFile(fmu) as source, ZipFile(copy, "w") as target:
        for entry in source.infolist():
            data = source.read(entry)
            if entry.filename == "modelDescription.xml":
                data, count = re.subn(rb"<Blows .*?</Blows>", b"", data, flags=re.DOTALL)
                assert count == 1
            target.writestr(entry, data)
    return copy


def test_without_a_journal_blows_are_told_from_samples_and_what_is_missing_is_said(
    frame: pd.DataFrame, tmp_path: Path
) -> None:
    plain = load(without_journal(load().path, tmp_path))
    whole, columns = blows(frame), ["blow_time", "blow_speed", "rop"]
    fine = blows(simulate(until=0.6, step=1e-3, fmu=plain))
    pd.testing.assert_frame_equal(fine[columns], whole[columns], check_exact=True)
    # 0.6 s in steps of 0.2 s: of each step's blows the last one is seen.
    coarse = simulate(until=0.6, step=0.2, fmu=plain)
    with pytest.warns(HammerWarning, match=f"{len(whole) - 3} blows are missing"):
        seen = blows(coarse)
    assert len(seen) == 3
    pd.testing.assert_frame_equal(seen[columns], whole.loc[seen.index, columns], check_exact=True)
    with pytest.raises(DthHammerError, match="no blow_count"):
        blows(simulate(until=0.01, outputs=["rop"], fmu=plain))


def test_steps_that_a_control_makes_leave_no_journal_with_holes(frame: pd.DataFrame) -> None:
    def control(hammer: Hammer) -> None:
        hammer.advance(hammer.time + 0.15)

    # Blows of the control's own steps are in no step of the run's.
    with pytest.warns(HammerWarning, match="blows are missing"):
        table = blows(simulate(until=0.6, step=0.2, control=control))
    assert set(table["blow_time"]) < set(blows(frame)["blow_time"])


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
