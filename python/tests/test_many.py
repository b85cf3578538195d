"""Long-run responses of many hammers: a row each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from dth_hammer import Case, DomainError, HammerWarning, UnknownNameError, steady, sweep
from dth_hammer.study import workers

RIGID = {"fidelity": "Rigid"}
#: With feed a cycle, without one no blow is as another.
GRID = {"feed_force": [5e3, 0.0]}


def test_a_row_is_what_steady_gives() -> None:
    table = sweep(GRID, "steady", parameters=RIGID, error=0.03)
    assert table["kind"].tolist() == ["cycle", "irregular"]
    assert "until" not in table
    assert table["reached"].all()
    assert table["rop_error"][0] == 0.0
    assert table.attrs["units"]["rop_error"] == "m/s"
    one = steady(RIGID | {"feed_force": 0.0}, error=0.03)
    for mean in one.outputs.index:
        assert (table[mean][1], table[f"{mean}_error"][1]) == (one[mean], one.error[mean])
    assert table["blows"][1] == one.blows
    processes = sweep(
        GRID, "steady", parameters=RIGID, error=0.03, scheduler="processes", workers=1
    )
    pd.testing.assert_frame_equal(table, processes)


def test_the_same_call_seeks_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sought: list[float] = []
    responses = workers.responses

    def counted(points: Sequence[dict[str, float]], *rest: Any, **others: Any) -> Any:
        sought.extend(point["feed_force"] for point in points)
        return responses(points, *rest, **others)

    monkeypatch.setattr(workers, "responses", counted)
    for suffix in ("parquet", "csv"):
        ways = {"parameters": RIGID, "out": tmp_path / f"means.{suffix}", "outputs": ["rop"]}
        sought.clear()
        sweep({"feed_force": [5e3]}, "steady", error=0.03, **ways)
        table = sweep(GRID, "steady", error=0.03, **ways)
        assert sought == [5e3, 0.0]
        pd.testing.assert_frame_equal(sweep(GRID, "steady", error=0.03, **ways), table)
        assert sought == [5e3, 0.0]
        # Another error is another question.
        sweep({"feed_force": [0.0]}, "steady", error=0.04, **ways)
        assert sought == [5e3, 0.0, 0.0]


def test_steady_takes_a_grid_a_list_or_a_frame_and_takes_up_where_it_was(tmp_path: Path) -> None:
    out = tmp_path / "means.csv"
    grid = {"feed_force": np.linspace(0.0, 5e3, 2)[::-1], "fidelity": "Rigid"}
    table = steady(grid, error=0.03, out=out, scheduler="processes", workers=1)
    swept = sweep(GRID, "steady", parameters=RIGID, error=0.03)
    pd.testing.assert_frame_equal(table[[*swept]], swept)
    rows = [RIGID | {"feed_force": feed} for feed in grid["feed_force"]]
    for same in (rows, pd.DataFrame(rows), {"feed_force": pd.Series([5e3, 0.0])} | RIGID):
        known = out.read_bytes()
        again = steady(same, error=0.03, out=out)
        pd.testing.assert_frame_equal(again[[*table]], table)
        assert out.read_bytes() == known


def test_rows_may_be_a_list_or_a_frame_and_tell_why_there_is_none() -> None:
    rows = [
        RIGID | {"drive.source": "Relay", "rock.stiffness": 2e8},
        RIGID | {"drive.source": "Force", "rock.stiffness": 2e8},
        RIGID | {"drive.source": "Relay", "rock.stiffness": 1e300},
    ]
    with pytest.warns(HammerWarning, match="nothing sets drive_force"):
        table = sweep(rows, "steady", outputs=["rop"])
    assert table["kind"].tolist() == ["cycle", "stalled", ""]
    assert table["rop"].notna().tolist() == [True, False, False]
    assert [bool(text) for text in table["error"]] == [False, False, True]
    with pytest.warns(HammerWarning, match="nothing sets drive_force"):
        again = sweep(pd.DataFrame(rows), "steady", outputs=["rop"])
    pd.testing.assert_frame_equal(again, table)


def test_a_controller_s_hammer_has_a_mean_too() -> None:
    # A constant input, set before each step, is the same hammer.
    cases = {"held": Case(parameters=RIGID, inputs={"feed_force": 5e3})}
    table = sweep({"rock.stiffness": [2e8]}, "steady", cases=cases, scheduler="threads")
    one = steady(RIGID | {"feed_force": 5e3, "rock.stiffness": 2e8})
    assert table["kind"].tolist() == ["cycle"] == [one.kind]
    # Where the periods of twelve blows agree to 1e-6, so do the means but for rounding of sums.
    assert table["tip_rate"][0] == pytest.approx(one["tip_rate"], rel=1e-4)


def test_what_is_asked_wrongly_is_told() -> None:
    with pytest.raises(DomainError, match=r'until = 1\.0 is not "steady"'):
        sweep(GRID, 1.0, error=0.01)
    with pytest.raises(UnknownNameError, match="mean"):
        sweep(GRID, "steady", outputs=["rate"])
    with pytest.raises(DomainError, match="the same in each"):
        sweep([{"feed_force": 1.0}, {"gravity": 0.0}], "steady")
    with pytest.raises(DomainError, match=r"sweep\(grid, \"steady\", cases=...\)"):
        steady(GRID, starts=2)  # type: ignore[call-overload]
    with pytest.raises(DomainError, match="for many hammers: give lists or rows"):
        steady(RIGID, workers=2)  # type: ignore[call-overload]
    with pytest.raises(DomainError, match="the same in each"):
        steady(np.zeros(3))  # type: ignore[call-overload]
