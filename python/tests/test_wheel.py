"""The wheel alone: no checkout, the FMU that it brings."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from dth_hammer.fmu import find

sys.path.insert(0, str(Path(__file__).parents[2] / "packaging"))

from wheels import wheel

A_TEST = """
import pytest

@pytest.mark.hammer(rock="granite")
def test_it_drills(hammer, assert_energy_balanced):
    hammer.advance(0.06)
    assert hammer["blow_count"] > 0
    assert_energy_balanced(hammer)
"""


def python(folder: Path, *arguments: str | Path, **more: str) -> str:
    """What Python prints that knows no checkout but what is named."""
    hidden = {"DTH_HAMMER_FMU", "PYTHONPATH"}
    env = {k: v for k, v in os.environ.items() if k not in hidden} | more
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the wheel is installed, as `cargo wheel` makes it."""
    folder = tmp_path_factory.mktemp("wheel")
    made = wheel(find(), folder, "native")
    pip = ("-m", "pip", "--disable-pip-version-check", "--quiet")
    python(folder, *pip, "install", "--no-deps", "--target", folder / "site", made)
    return folder / "site"


def test_it_has_the_licences_of_what_is_compiled_and_lists_no_more(site: Path) -> None:
    (info,) = site.glob("dth_hammer-*.dist-info")
    (bill,) = (info / "sboms").iterdir()
    text = bill.read_text(encoding="utf-8")
    listed = {part["name"] for part in json.loads(text)["components"]}
    # Of features that nobody asks for, of the tests, of the compiler's plugins.
    assert {"hammer", "dth-native", "nalgebra", "numpy", "pyo3"} <= listed
    assert not {"glam", "serde_json", "syn"} & listed
    assert not any(str(place) in text for place in (Path.home(), Path(__file__).parents[2]))
    licences = {
        path.name: path.read_text(encoding="utf-8") for path in (info / "licenses").iterdir()
    }
    assert {"LICENSE-MIT", "LICENSE-APACHE"} < licences.keys()
    assert all(name in licences["licenses.txt"] for name in listed)
    assert "License-File: LICENSE-MIT" in (info / "METADATA").read_text(encoding="utf-8")


def test_it_runs_with_its_own_fmu(site: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    run = ("-m", "dth_hammer.cli", "run", "--until", "60 ms", "--quiet", "-o", out)
    assert "blow_speed [m/s]" in python(tmp_path, *run, PYTHONPATH=str(site))
    assert out.is_file()
    where = "import dth_hammer; print(dth_hammer.fmu.find())"
    found = Path(python(tmp_path, "-c", where, PYTHONPATH=str(site)).strip())
    assert found == (site / "dth_hammer" / "data" / "dth_hammer.fmu").resolve()


def test_its_plugin_serves_a_foreign_project(site: Path, tmp_path: Path) -> None:
    (tmp_path / "test_mine.py").write_text(A_TEST, encoding="utf-8")
    said = python(tmp_path, "-m", "pytest", "-q", PYTHONPATH=str(site))
    assert "1 passed" in said
