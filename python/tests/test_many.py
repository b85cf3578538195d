"""Long-run responses of many hammers: a row each."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from dth_hammer import DomainError, HammerWarning, steady
from dth_hammer.study.cases import Job
from dth_hammer.study.workers import parts_of

RIGID = {"fidelity": "Rigid"}
#: With feed a cycle, without one no blow is as another.
GRID = {"feed_force": [5e3, 0.0], "fidelity": "Rigid"}


def test_a_row_is_what_steady_gives() -> None:
    table = steady(GRID, error=0.03)
    assert table["kind"].tolist() == ["cycle", "irregular"]
    assert "until" not in table
    assert table["reached"].all()
    assert table["rop_error"][0] == 0.0
    assert table.attrs["units"]["rop_error"] == "m/s"
    one = steady(RIGID | {"feed_force": 0.0}, error=0.03)
    for mean in one.outputs.index:
        assert (table[mean][1], table[f"{mean}_error"][1]) == (one[mean], one.error[mean])
    assert table["blows"][1] == one.blows
    with ThreadPoolExecutor(1) as crew:
        pd.testing.assert_frame_equal(table, steady(GRID, error=0.03, scheduler=crew))


def test_the_same_call_seeks_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sought: list[float] = []

    def counted(runs: Sequence[Job], *by: Any) -> Any:
        sought.extend(run.numbers["feed_force"] for run in runs)
        return parts_of(runs, *by)

    monkeypatch.setattr("dth_hammer.study.sweeping.parts_of", counted)
    for suffix in ("parquet", "csv"):
        out = tmp_path / f"means.{suffix}"
        sought.clear()
        steady(GRID | {"feed_force": [5e3]}, error=0.03, out=out)
        table = steady(GRID, error=0.03, out=out)
        assert sought == [5e3, 0.0]
        pd.testing.assert_frame_equal(steady(GRID, error=0.03, out=out), table)
        assert sought == [5e3, 0.0]
        # Another error is another question.
        steady(GRID | {"feed_force": [0.0]}, error=0.04, out=out)
        assert sought == [5e3, 0.0, 0.0]


def test_rows_may_be_a_list_or_a_frame_and_tell_why_there_is_none() -> None:
    rows = [
        RIGID | {"drive.source": "Relay", "rock.stiffness": 2e8},
        RIGID | {"drive.source": "Force", "rock.stiffness": 2e8},
        RIGID | {"drive.source": "Relay", "rock.stiffness": 1e300},
    ]
    with pytest.warns(HammerWarning, match="nothing sets drive_force"):
        table = steady(rows)
    assert table["kind"].tolist() == ["cycle", "stalled", ""]
    assert table["rop"].notna().tolist() == [True, False, False]
    assert [bool(text) for text in table["error"]] == [False, False, True]
    with pytest.warns(HammerWarning, match="nothing sets drive_force"):
        again = steady(pd.DataFrame(rows))
    pd.testing.assert_frame_equal(again, table)


def test_what_is_asked_wrongly_is_told() -> None:
    with pytest.raises(DomainError, match="the same in each"):
        steady([{"feed_force": 1.0}, {"gravity": 0.0}])
    with pytest.raises(DomainError, match="for many hammers: give lists or rows"):
        steady(RIGID, workers=2)  # type: ignore[call-overload]
    with pytest.raises(DomainError, match="is not parameters by name, a preset"):
        steady(np.zeros(3))  # type: ignore[call-overload]
