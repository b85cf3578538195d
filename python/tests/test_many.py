"""Long-run responses of many hammers: one row each."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import DomainError, HammerWarning, steady
from sweeps import forbidden_runs

RIGID = {"fidelity": "Rigid"}
#: With feed the hammer has a cycle, without feed no two blows are equal.
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


@pytest.mark.parametrize("suffix", ["parquet", "csv"])
def test_the_same_call_has_its_rows_and_another_error_is_another_question(
    tmp_path: Path, suffix: str
) -> None:
    out = tmp_path / f"means.{suffix}"
    table = steady(GRID, error=0.03, out=out)
    with forbidden_runs():
        pd.testing.assert_frame_equal(steady(GRID, error=0.03, out=out), table)
        with pytest.raises(TypeError):
            steady(GRID, error=0.04, out=out)


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
