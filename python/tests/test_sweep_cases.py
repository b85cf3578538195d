"""Runs of a sweep with inputs, controls or other options, and how they are told apart."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pandas as pd
import pytest
from dth_hammer import PRESETS, VARIABLES, DomainError, Hammer, Scene, simulate, sweep
from dth_hammer.study.store import Store
from sweeps import UNTIL, forbidden_runs


def harder_when_deeper(hammer: Hammer) -> None:
    """A controller: more feed after the first half millimetre."""
    hammer.set(feed_force=8e3 if hammer["tip_depth"] > 5e-4 else 3e3)


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
    "plain": None,
    "granite": Scene(rock="granite"),
    "ramp": Scene(inputs={"feed_force": RAMP}),
    "preset": "water_hammer",
}


def test_a_case_is_what_simulate_gives(tmp_path: Path) -> None:
    grid, read = {"rock.viscosity": [1e4, 2e4]}, ["rop", "tip_depth"]
    ways = {"cases": CASES, "step": "1 ms", "out": tmp_path / "cases.parquet"}
    table = sweep(grid, UNTIL, **ways)
    assert table["error"].tolist() == [""] * 8
    # A parameter that only another case sets has its start value.
    start = VARIABLES["drive.stroke"].start
    own = PRESETS["water_hammer"].values["drive.stroke"]
    assert table["drive.stroke"].tolist() == [*[start] * 6, own, own]
    for _, row in table.iterrows():
        with Hammer(CASES[row["case"]] if row["case"] != "ramp" else None) as one:
            point = one.numbers | {"rock.viscosity": row["rock.viscosity"]}
        inputs = {"feed_force": RAMP} if row["case"] == "ramp" else {}
        run = simulate(point, UNTIL, inputs, step="1 ms", outputs=read)
        assert run.frame.iloc[-1].tolist() == row[read].tolist()
    with forbidden_runs():
        pd.testing.assert_frame_equal(sweep(grid, UNTIL, **ways), table)


def test_each_run_has_a_controller_of_its_own() -> None:
    ways = {"outputs": ["tip_depth"]}
    grid = {"rock.viscosity": [1e4, 2e4]}
    counted = sweep(grid, UNTIL, control=Counting(), step=UNTIL / 600, **ways)
    assert counted["error"].tolist() == ["", ""]
    table = sweep(grid, UNTIL, control=harder_when_deeper, step=1e-3, **ways)
    with ProcessPoolExecutor(1, get_context("spawn")) as crew:
        far = sweep(grid, UNTIL, control=harder_when_deeper, step=1e-3, scheduler=crew, **ways)
    pd.testing.assert_frame_equal(far, table, check_exact=True)
    run = simulate({"rock.viscosity": 1e4}, UNTIL, step=1e-3, control=harder_when_deeper)
    assert table["tip_depth"][0] == run["tip_depth"].iloc[-1]


def test_a_case_is_told_from_another_by_its_inputs_and_its_version(tmp_path: Path) -> None:
    out, grid = tmp_path / "cases.csv", {"rock.viscosity": [1e4]}
    ramps = [pd.Series([3e3, end], index=[0.0, UNTIL]) for end in (4e3, 5e3, 5e3)]
    for feed in ("3 kN", 3e3, 4e3, *ramps):
        cases = {"fed": Scene(inputs={"feed_force": feed})}
        sweep(grid, 0.01, cases=cases, out=out)
    # Two numbers and two ramps are four runs; repeated ones are not run again.
    assert len(Store(out).rows()) == 4
    for version in (1, 1, 2):
        ways = {"control": harder_when_deeper, "version": version}
        sweep(grid, 0.01, out=out, **ways)
    assert len(Store(out).rows()) == 6
    # Another step makes another run.
    sweep(grid, 0.01, out=out, step="2 ms", **ways)
    assert len(Store(out).rows()) == 7


def test_code_without_a_version_keeps_no_rows(tmp_path: Path) -> None:
    grid = {"rock.viscosity": [1e4]}
    fed = {"cases": {"led": Scene(inputs={"feed_force": lambda _: 5e3})}}
    for code in ({"control": harder_when_deeper}, fed):
        with pytest.raises(DomainError, match=r"the case '(led)?' has code .*version=1"):
            sweep(grid, 0.01, out=tmp_path / "x.csv", **code)
        assert sweep(grid, 0.01, **code)["error"].tolist() == [""]


def test_what_a_controller_raised_is_tried_again_and_a_refusal_is_not(
    tmp_path: Path,
) -> None:
    full, out = tmp_path / "full", tmp_path / "rows.parquet"

    def logs(hammer: Hammer) -> None:
        if full.exists():
            raise OSError("No space left on device")

    grid = {"rock.unloading_ratio": [4.0], "rock.stiffness": [1e8, 1e300]}
    ways = {"control": logs, "step": "5 ms", "version": 1, "out": out}
    full.touch()
    rows = sweep(grid, 0.01, **ways)
    message, refusal = rows["error"]
    assert message == "OSError: No space left on device"
    assert "of a magnitude" in refusal
    assert Store(out).rows()["error"].tolist() == [refusal]
    full.unlink()
    again = sweep(grid, 0.01, **ways)
    assert again["error"].tolist() == ["", refusal]
    assert len(Store(out).rows()) == 2


def test_a_controller_that_fails_says_so_in_its_row() -> None:
    def fails(hammer: Hammer) -> None:
        raise KeyError(hammer.time)

    grid = {"feed_force": [4e3]}
    table = sweep(grid, 0.01, control=fails)
    assert table["error"].tolist() == ["KeyError: 0.0"]
    with pytest.raises(DomainError, match="feed_force is in the grid and an input of the case"):
        sweep(grid, 0.01, base=Scene(inputs={"feed_force": 5e3}))


def test_an_input_over_time_goes_before_that_of_the_preset() -> None:
    """At the start the rock bears the bit's weight and the feed of the first instant."""
    preset, inputs = "top_hammer", {"feed_force": 3e3}
    table = sweep(
        {"gravity": [0.0], "contact.stiffness": [1e9]},
        1e-6,
        base=Scene(preset=preset, inputs=inputs),
        outputs=["rock_force"],
    )
    run = simulate({"gravity": 0.0, "contact.stiffness": 1e9}, 1e-6, preset=preset, inputs=inputs)
    assert PRESETS[preset].values["feed_force"] != inputs["feed_force"]
    # The static equilibrium is solved to rounding.
    for force in (table["rock_force"].iloc[0], run["rock_force"].iloc[0]):
        assert force == pytest.approx(inputs["feed_force"], rel=1e-9)
