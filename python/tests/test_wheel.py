"""The wheel alone: without a checkout, with the FMU in it."""

import json
import os
import shutil
import sys
import zipfile
from pathlib import Path

import pytest
from dth_hammer.fmu import find
from programs import ran

sys.path.insert(0, str(Path(__file__).parents[2] / "packaging"))

from wheels import wheel

ROOT = Path(__file__).parents[2]


def python(folder: Path, *arguments: str | Path, **more: str) -> str:
    """Returns the output of a Python that finds no checkout except by the given variables."""
    hidden = {"DTH_HAMMER_FMU", "PYTHONPATH"}
    env = {k: v for k, v in os.environ.items() if k not in hidden} | more
    return ran([sys.executable, *arguments], folder, env)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Makes the wheel as `cargo wheel` does."""
    return wheel(find(), tmp_path_factory.mktemp("wheel"), "native")


@pytest.fixture(scope="module")
def site(made: Path) -> Path:
    """Installs the wheel, and returns the folder."""
    folder = made.parent
    pip = ("-m", "pip", "--disable-pip-version-check", "--quiet")
    python(folder, *pip, "install", "--no-deps", "--target", folder / "site", made)
    return folder / "site"


def test_it_has_the_package_s_sources_its_module_and_its_units_alone(made: Path) -> None:
    sources = {f for f in (ROOT / "python" / "src").rglob("*") if f.suffix in {".py", ".pyi"}}
    expected = {path.relative_to(ROOT / "python" / "src").as_posix() for path in sources}
    expected |= {f"dth_hammer/data/dth_hammer{end}.fmu" for end in ("", "_fmi3")}
    names = {name for name in zipfile.ZipFile(made).namelist() if ".dist-info/" not in name}
    (module,) = (name for name in names - expected if name.startswith("dth_hammer/_native."))
    assert names - expected - {module, "dth_hammer/py.typed"} == set()
    assert expected <= names
    # No file has the time of its making, so two wheels of one commit are the same bytes.
    assert {file.date_time[:3] for file in zipfile.ZipFile(made).infolist()} == {(1980, 1, 1)}


def test_it_has_the_licences_of_what_is_compiled_and_lists_no_more(site: Path) -> None:
    (info,) = site.glob("dth_hammer-*.dist-info")
    (bill,) = (info / "sboms").iterdir()
    text = bill.read_text(encoding="utf-8")
    listed = {part["name"] for part in json.loads(text)["components"]}
    # Not listed: crates of unused features, of the tests, and of the compiler's plugins.
    assert {"dth-hammer", "dth-native", "nalgebra", "numpy", "pyo3"} <= listed
    assert not {"glam", "serde_json", "syn"} & listed
    assert not any(str(place) in text for place in (Path.home(), ROOT))
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
    # Runs elsewhere without this project's settings, so that only the installed package counts.
    shutil.copytree(ROOT / "examples" / "controller", tmp_path, dirs_exist_ok=True)
    words = ("-m", "pytest", "-q", "--strict-markers", "-W", "error")
    assert "3 passed" in python(tmp_path, *words, PYTHONPATH=str(site))
