"""Runs of a sweep that something acts on: what they are, and what tells them apart."""

from __future__ import annotations

import shutil
import threading
from pathlib import Path

import pandas as pd
import pytest
from dth_hammer import PRESETS, Case, DomainError, Hammer, simulate, sweep
from dth_hammer.store import Store
from sweeps import UNTIL, begun, forbidden_runs, written


def harder_when_deeper(hammer: Hammer) -> None:
    """A controller: more feed after the first half millimetre."""
    hammer.set(feed_force=8e3 if hammer["hole_depth"] > 5e-4 else 3e3)


class Counting:
    """A controller with a memory, which no other run may share."""

    def __init__(self) -> None:
        self.steps = 0

    def __call__(self, hammer: Hammer) -> None:
        self.steps += 1
        if self.steps > 1000:
            raise RuntimeError("another run's steps were counted")


RAMP = pd.Series([3e3, 8e3], index=[0.0, UNTIL])
CASES = {
    "plain": Case(),
    "granite": Case(preset="granite"),
    "ramp": Case(inputs={"feed_force": RAMP}, step="1 ms"),
    "controlled": Case(control=harder_when_deeper, step=1e-3),
    "counted": Case(control=Counting(), step=UNTIL / 600),
}


@pytest.mark.parametrize("scheduler", ["threads", "processes"])
def test_a_case_is_what_simulate_gives(scheduler: str, tmp_path: Path) -> None:
    grid = {"rock.viscosity": [1e5, 2e5]}
    out = tmp_path / "cases.parquet"
    table = sweep(grid, UNTIL, cases=CASES, scheduler=scheduler, workers=1, out=out)
    assert table["error"].tolist() == [""] * 10
    for _, row in table.iterrows():
        case = CASES[row["case"]]
        run = simulate(
            {"rock.viscosity": row["rock.viscosity"]},
            UNTIL,
            dict(case.inputs),
            preset=case.preset,
            step=case.step,
            control=case.control if row["case"] == "controlled" else None,
            outputs=["rop", "hole_depth"],
        )
        if row["case"] != "counted":
            assert run.frame.iloc[-1].tolist() == row[["rop", "hole_depth"]].tolist()
    with forbidden_runs():
        pd.testing.assert_frame_equal(sweep(grid, UNTIL, cases=CASES, out=out), table)


def test_a_case_is_told_from_another_by_its_inputs_and_its_code(tmp_path: Path) -> None:
    out, grid = tmp_path / "cases.csv", {"rock.viscosity": [1e5]}
    for inputs in ({"feed_force": 3e3}, {"feed_force": 4e3}):
        sweep(grid, 0.01, cases={"fed": Case(inputs=inputs)}, scheduler="threads", out=out)
    for control in (harder_when_deeper, Counting()):
        sweep(grid, 0.01, cases={"led": Case(control=control)}, scheduler="threads", out=out)
    assert len(Store(out).rows()) == 4


def test_a_controller_that_fails_says_so_in_its_row() -> None:
    def fails(hammer: Hammer) -> None:
        raise KeyError(hammer.time)

    grid = {"feed_force": [4e3]}
    cases = {"fails": Case(control=fails), "goes": Case()}
    table = sweep(grid, 0.01, cases=cases, scheduler="threads")
    assert table["error"].tolist() == ["KeyError: 0.0", ""]
    with pytest.raises(DomainError, match="feed_force is in the grid and an input of the case"):
        sweep(grid, 0.01, cases={"both": Case(inputs={"feed_force": 5e3})})


EDITED = """
import controllers
from dth_hammer import Case, sweep
from dth_hammer.store import Store

add, ran = Store.add, []
Store.add = lambda store, table, key: (ran.append(len(table)), add(store, table, key))
cases = {"led": Case(control=controllers.ease, step="1 ms"), "free": Case()}
table = sweep({"feed_force": [4e3]}, 0.02, cases=cases, scheduler="threads", out="x.parquet")
print(sum(ran), table["hole_depth"][0])
"""
EASE = """
LEAST = 3e3

def ease(hammer):
    hammer.set(feed_force=LEAST)
"""


def test_an_edited_controller_runs_again_and_an_unchanged_one_does_not(tmp_path: Path) -> None:
    script, module = written(tmp_path, EDITED), tmp_path / "controllers.py"
    message = []
    for text in (EASE, EASE, EASE.replace("LEAST)", "2 * LEAST)"), EASE.replace("3e3", "6e3")):
        module.write_text(text, encoding="utf-8")
        shutil.rmtree(tmp_path / "__pycache__", ignore_errors=True)
        said, complaints = begun(tmp_path, script).communicate(timeout=300)
        assert not complaints
        message.append(said.split())
    assert [ran for ran, _ in message] == ["2", "0", "1", "1"]
    # Twice 3 kN by the code or by a global is the same feed; once is another.
    assert message[0][1] == message[1][1] != message[2][1] == message[3][1]


def test_a_controller_that_nothing_tells_from_an_edited_one_keeps_no_rows(tmp_path: Path) -> None:
    lock = threading.Lock()

    def control(hammer: Hammer) -> None:
        with lock:
            hammer.set(feed_force=4e3)

    cases = {"locked": Case(control=control, step="1 ms")}
    grid = {"rock.viscosity": [1e5]}
    with pytest.raises(DomainError, match=r"no rows can be kept of the case 'locked'.*lock"):
        sweep(grid, 0.01, cases=cases, scheduler="threads", out=tmp_path / "x.csv")
    assert sweep(grid, 0.01, cases=cases, scheduler="threads")["error"].tolist() == [""]


def test_an_input_over_time_goes_before_that_of_the_preset() -> None:
    """At the start the rock bears the bit's weight and the feed of the first instant."""
    preset, inputs = "hammer_3_inch", {"feed_force": 3e3}
    table = sweep(
        {"gravity": [0.0]},
        1e-6,
        cases={"": Case(preset=preset, inputs=inputs)},
        outputs=["rock_force"],
    )
    run = simulate({"gravity": 0.0}, 1e-6, preset=preset, inputs=inputs)
    assert PRESETS[preset].values["feed_force"] != inputs["feed_force"]
    # Statics, solved for to rounding.
    for force in (table["rock_force"].iloc[0], run["rock_force"].iloc[0]):
        assert force == pytest.approx(inputs["feed_force"], rel=1e-9)
