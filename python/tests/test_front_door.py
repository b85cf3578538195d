"""Names, shapes and functions that people type first, and which must agree."""

import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from dth_hammer import VARIABLES, DomainError, Run, Scene, mesh_for, simulate, steady, sweep

RIGID = {"fidelity": "Rigid"}
#: A user's own drive, as in the guide, and one that only has the function.
USER = """
from collections.abc import Callable, Mapping
from dth_hammer import (Calibration, Coupling, Hammer, Life, Mesh, Motion, Optimum, Partner, Rock,
    Run, Steady, Trend, Waves, simulate)
class Mine:
    def outputs(self) -> Mapping[str, float]:
        return {"drive_pressure": 1e6}
    def advance(self, size: float, motion: Motion) -> None:
        position, velocity = motion(size)
class Bare:
    def outputs(self) -> dict[str, float]:
        return {}
    def advance(self, size: float, motion: Callable[[float], tuple[float, float]]) -> None: ...
def drive(hammer: Hammer) -> None:
    for partner in (Mine(), Bare()):
        one: Partner = partner
        Coupling(hammer, one, step="1 ms").advance("2 ms")
run: Run = simulate()
speeds: list[float] = run["blow_speed"].tolist()
"""


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(RIGID, until=0.1)


def test_length_names_and_dictionary_of_a_run_agree(run: Run) -> None:
    assert len(run) == len(list(run)) == len(dict(run))
    assert all(dict(run)[name].equals(run[name]) for name in run)
    assert run == simulate(RIGID, until=0.1)
    assert run != simulate(RIGID, until=0.1, step=2e-3)
    assert run != simulate({**RIGID, "feed_force": "4 kN"}, until=0.1)
    assert run != 1


def test_outputs_are_drawn_into_ones_own_axes_or_a_panel_each(run: Run) -> None:
    _, ax = plt.subplots()
    run.plot("piston_position", "bit_position", ax=ax)
    drawn = [np.asarray(line.get_ydata()) for line in ax.get_lines()]
    assert (drawn[0] == run["piston_position"]).all()
    assert (drawn[1] == run["bit_position"]).all()
    panels = run.convert({"tip_depth": "mm"}).plot("tip_depth", "contact_force").axes
    assert [panel.get_ylabel() for panel in panels] == ["tip_depth (mm)", "contact_force (N)"]
    assert (panels[0].get_lines()[0].get_ydata() == 1e3 * run["tip_depth"]).all()
    with pytest.raises(DomainError, match="named outputs"):
        run.plot(ax=ax)


def test_a_row_of_a_table_is_a_hammer_and_a_column_stands_in_it_once() -> None:
    table = sweep({"feed_force": [3e3, 5e3], "fidelity": ["Rigid"]}, 0.05)
    row = table[["feed_force", "fidelity"]].iloc[1]
    assert simulate(row, until=0.05).parameters["feed_force"] == 5e3
    assert steady(row).parameters["feed_force"] == 5e3
    with pytest.raises(DomainError, match="feed_force"):
        simulate(pd.Series({"feed_force": float("nan")}), until=0.05)
    twice = pd.DataFrame([[3e3, 5e3]], columns=["feed_force", "feed_force"])
    with pytest.raises(DomainError, match="feed_force"):
        sweep(twice, 0.05)


def test_a_run_and_a_mean_tell_the_error_of_their_mesh() -> None:
    # The engine's law, which its own test holds to finer meshes: 1 % on spans of four widths of the
    # front, and the power 3.6 of the span. The default mesh is that of a rate.
    mesh = mesh_for(error=0.01)
    per_cent = (mesh.span / (4.0 * mesh.front)) ** 3.6
    for answer in (simulate(until=0.02), steady()):
        (told,) = (text for text in answer.in_words() if "error of the mesh" in text)
        assert f"of `rop` up to {per_cent:.2g} %" in told
    finer = simulate({"piston.elements": 32, "bit.elements": 32}, until=0.02).in_words()[-1]
    assert f"of `rop` up to {per_cent * 2**-3.6:.2g} %" in finer
    assert "not known" in simulate({"mesh.degree": 1}, until=0.02).in_words()[-1]
    assert len(simulate(RIGID, until=0.02).in_words()) == 1


def test_a_number_as_a_rock_is_asked_about() -> None:
    for call in (simulate, steady):
        with pytest.raises(DomainError, match="is it a strength, rock='180 MPa'"):
            call(RIGID, rock=180)  # type: ignore[call-overload, arg-type]


def test_variables_and_a_scene_show_themselves_in_a_notebook() -> None:
    assert all(f"<th>{name}</th>" in VARIABLES._repr_html_() for name in VARIABLES)
    page = Scene("one & two", preset="air_4_inch", parameters={"feed_force": "6 kN"})._repr_html_()
    assert "one &amp; two" in page
    assert "air_4_inch" in page
    assert "6000 N" in page


def test_programs_of_users_pass_the_strict_checks_of_types(tmp_path: Path) -> None:
    program = tmp_path / "user.py"
    program.write_text(USER, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--no-incremental", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout
