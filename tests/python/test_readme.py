"""The README says what happens."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import dth_hammer
import front
import pytest
from programs import ran

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language: str, after: str) -> str:
    """Returns the first code block of a language after a phrase."""
    text = README[README.index(after) :]
    found = re.search(rf"```{language}\n(.*?)```", text, re.DOTALL)
    assert found, f"no {language} block after {after!r}"
    return found[1]


def test_ten_lines_are_ten_and_the_rust_block_prints_what_python_simulates() -> None:
    # python/tests/test_first_day.py runs the Python block; the doctest of src/lib.rs compiles and
    # runs the Rust block.
    assert len(block("python", "Ten lines").splitlines()) <= 10
    assert len(block("rust", "## In Rust").splitlines()) <= 14
    lines = block("text", "## In Rust").splitlines()
    for line, stiffness in zip(lines, (6e7, 1.2e8, 2.4e8), strict=True):
        found = dth_hammer.simulate({"rock.stiffness": stiffness}, until=0.6).summary()
        rate, low, high = 3600 * found.loc["rate of penetration", ["mean", "low", "high"]]
        energy = found.loc["blow energy", "mean"]
        expected = f"{rate:.1f} m/h ({low:.1f} to {high:.1f}), {energy:.0f} J per blow"
        assert line.split(": ")[1] == expected


def test_what_is_said_of_speed_and_exactness_is_in_the_reports() -> None:
    before, after = front.split(README)
    assert before + front.text() + after == README, "run `cargo front`"


def test_the_errors_of_the_default_mesh_are_as_said() -> None:
    # 80 cubic elements per bar are converged: 160 change the largest contact force by 0.03 %.
    fine = {"piston.elements": 80, "bit.elements": 80, "mesh.degree": 3}
    coarse, fine = (
        dth_hammer.simulate(hammer, until=0.7, step=0.7).blows.iloc[-1] for hammer in ({}, fine)
    )
    said = " ".join(README[README.index("* **Mesh.**") : README.index("* **Statistics.**")].split())
    for column, words in {
        "tip_rate": "tip's gain that is 0.9 % larger",
        "blow_period": "period that is 0.04 % shorter",
        "rock_force_peak": "largest rock force that is 0.4 % larger",
        "contact_force_peak": "largest contact force that is 21 % larger",
    }.items():
        assert words in said
        number = re.search(r"is (\S+) %", words)[1]
        decimals = len(number.partition(".")[2])
        off = abs(coarse[column] / fine[column] - 1)
        assert f"{100 * off:.{decimals}f}" == number, column
        assert (coarse[column] > fine[column]) == ("larger" in words)
    forces = (coarse["contact_force_peak"], fine["contact_force_peak"])
    assert [f"{force / 1e3:.0f} kN" for force in forces] == re.findall(r"\d+ kN", said)


def test_the_demo_prints_what_is_shown_and_draws(tmp_path: Path) -> None:
    # This is the program of `cargo demo` after the FMU is packaged.
    picture = tmp_path / "reference.png"
    command = [sys.executable, "demo/reference.py", "--figure", str(picture)]
    said = ran(command, ROOT)
    # Speed and the figure's path belong to this run, not to the model.
    own = ("real-time factor", "figure: ")
    printed, expected = (
        [line for line in text.splitlines() if not line.startswith(own)]
        for text in (said, block("text", "<!-- demo -->"))
    )
    assert printed == expected
    assert picture.stat().st_size > 10_000


def test_the_first_lines_of_output_are_the_demo_s() -> None:
    first = block("text", "cargo suite").splitlines()
    assert len(first) == 6
    assert set(first) < set(block("text", "<!-- demo -->").splitlines())


def test_every_folder_is_named_and_every_link_leads_somewhere() -> None:
    # Commands make these folders; a folder that begins with a dot belongs to a tool.
    made = {"dist", "target", "__pycache__"}
    folders = {p.name for p in ROOT.iterdir() if p.is_dir() and p.name[0] != "."} - made
    rows = README[README.index("## What is where") :]
    assert folders == set(re.findall(r"`(\w+)/", rows[: rows.index("\n\n[")])) - made
    for link in re.findall(r'(?:\]\(|src=")([^)"#]+)', README):
        assert link.startswith("https://") or (ROOT / link).exists(), link


@pytest.mark.parametrize(("ci", "code"), [("", 0), ("true", 1)])
def test_ci_fails_where_it_lacks_what_can_be_installed(tmp_path: Path, ci: str, code: int) -> None:
    lines = ["import pytest", "def test_it():", "    pytest.skip('no browser: apt install it')"]
    (tmp_path / "test_it.py").write_text("\n".join(lines), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "conftest", "-c", "/dev/null", tmp_path],
        env=os.environ | {"CI": ci, "PYTHONPATH": str(ROOT)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout


def test_each_fault_that_was_found_is_held_by_a_test_that_exists() -> None:
    rows = re.findall(r"\| `(\S+)` `(\w+)` \|", (ROOT / "docs/faults.md").read_text("utf-8"))
    assert len(rows) >= 30
    for file, test in rows:
        pattern = rf"(fn|def) {test}\("
        assert re.search(pattern, (ROOT / file).read_text("utf-8")), f"{file} has no {test}"
