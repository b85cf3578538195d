"""The benchmark of hosts in evidence/hosts: archives, closed forms, scores of hosts."""

from __future__ import annotations

import ctypes
import re
import sys
from pathlib import Path
from zipfile import ZipFile

import fmpy
import pytest
from fmpy.validation import validate_fmu
from programs import ran

pytestmark = pytest.mark.usefixtures("scratch")

HOSTS = Path(__file__).parents[2] / "evidence" / "hosts"
UNITS = HOSTS / "unit"
ARCHIVES = sorted(UNITS.glob("*.fmu"))
ZIG = Path(sys.prefix).with_name("venv-cross") / "bin" / "python"


def tell(program: str, *arguments: str | Path) -> str:
    return ran([sys.executable, HOSTS / program, *arguments])


def test_instants_are_in_closed_form() -> None:
    # Square roots are rounded alike on all machines.
    assert tell("score.py") == (HOSTS / "instants.csv").read_text(encoding="utf-8")
    # Energy is kept where the valve decides in time: the speed on the bit is that of a fall
    # from -1 mm, v^2 = 8.3^2 + 2 * 800 * 0.001, whatever was between. From -0.02 m, passed back at
    # |v| = sqrt(8.3^2 - 2 * 800 * 0.019), it takes the difference of the speeds over 800 m/s2.
    rows = [line.split(",") for line in tell("score.py", "--scene", "coupled").splitlines()[1:]]
    back, blow = float(rows[-3][0]), float(rows[-1][0])
    fast, slow = (8.3**2 + 1.6) ** 0.5, (8.3**2 - 30.4) ** 0.5
    assert blow - back == pytest.approx((fast - slow) / 800.0, rel=1e-14)


def test_events_are_kept_by_who_takes_early_returns_alone() -> None:
    table = [[cell.strip() for cell in line.split("|")] for line in tell("events.py").splitlines()]
    rows = {tuple(row[1:3]): row[-5:-3] for row in table if len(row) > 6}
    in_fmpy = "fmpy, event mode and early return"
    assert rows[in_fmpy, fmpy.__version__] == ["11 of 11", "11 of 11"]
    # A host without events misses two passages between two points.
    assert rows["fmpy, FMI 2.0", fmpy.__version__] == ["0 of 11", "9 of 11"]
    assert rows["changed", in_fmpy] == ["7 of 7", "7 of 7"]
    # A host may place a step at the jump of its input.
    assert rows["changed", "fmpy, neither"][0] == "1 of 7"
    assert rows["coupled", "a master over " + in_fmpy] == ["7 of 7", "7 of 7"]
    assert rows["coupled", "a master over fmpy, neither"][0] == "0 of 7"
    # Other masters step one unit after the other, or both at once with earlier values. Then the
    # valve is a step late, and the piston comes higher.
    late = ["0 of 7", "4 of 7"]
    pair = {host: row for (scene, host), row in rows.items() if scene == "coupled"}
    for fmi in ("", ", FMI 2.0"):
        assert pair[f"fmucontainer{fmi}"] == ["0 of 7", "6 of 7"]
    assert all(
        pair.get(host, late) == late for host in ("ecos", "ecos, FMI 2.0", "libcosim, FMI 2.0")
    )


@pytest.mark.parametrize("archive", ARCHIVES, ids=lambda path: path.stem)
def test_archives_are_valid_and_export_every_function(archive: Path, tmp_path: Path) -> None:
    assert validate_fmu(str(archive)) == []
    fmi = archive.stem[-1]
    with ZipFile(archive) as files:
        (name,) = (name for name in files.namelist() if name.startswith("binaries/"))
        library = ctypes.CDLL(files.extract(name, tmp_path)) if sys.platform == "linux" else None
    if library is not None:
        header = Path(fmpy.__file__).with_name("c-code") / f"fmi{fmi}FunctionTypes.h"
        names = re.findall(rf"(fmi{fmi}\w+)TYPE *\(", header.read_text(encoding="utf-8"))
        # For FMI 2.0 the ten functions of model exchange, between two of co-simulation, are left
        # out.
        if fmi == "2":
            first, last = map(
                names.index, ("fmi2EnterEventMode", "fmi2GetNominalsOfContinuousStates")
            )
            del names[first : last + 1]
        assert len(names) == {"2": 34, "3": 75}[fmi]
        assert [name for name in names if not hasattr(library, name)] == []


def test_archives_are_what_their_program_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(HOSTS)
    monkeypatch.syspath_prepend(UNITS)
    import build  # noqa: PLC0415

    # Uses the compiler if it is there (`cargo suite` installs it on Linux), else makes all but the
    # library.
    if ZIG.is_file():
        monkeypatch.setattr(build, "PYTHON", str(ZIG))
        monkeypatch.setenv("ZIG_GLOBAL_CACHE_DIR", str(ZIG.parents[2] / "linkers" / "cache"))
    else:
        monkeypatch.setattr(build, "library", lambda _: b"")
    build.write(tmp_path, "x86_64-linux-gnu.2.17", "x86_64-linux")
    assert [path.name for path in ARCHIVES] == sorted(path.name for path in tmp_path.iterdir())
    for archive in ARCHIVES:
        with ZipFile(archive) as committed, ZipFile(tmp_path / archive.name) as made:
            assert committed.namelist() == made.namelist()
            for name in made.namelist():
                if made.read(name):
                    assert committed.read(name) == made.read(name), name


def test_fmuloader_passes_events_of_the_piston(tmp_path: Path) -> None:
    # For Python 3.11 and newer.
    loader = pytest.importorskip("fmuloader.fmi3")
    rows = ["time,relative_position"]
    with loader.Fmi3Slave(UNITS / "thrown_fmi3.fmu", model_identifier="thrown") as piston:
        piston.instantiate_co_simulation("piston", instantiation_token="thrown")
        piston.enter_initialization_mode()
        piston.exit_initialization_mode()
        for step in range(22):
            (x,) = piston.get_float64([1])
            rows.append(f"{step * 1e-3!r},{x!r}")
            if step < 21:
                piston.do_step(step * 1e-3, 1e-3)
        piston.terminate()
        piston.free_instance()
    table = tmp_path / "rows.csv"
    table.write_text("\n".join(rows), encoding="utf-8")
    assert "| 0 of 11 | 9 of 11 |" in tell("score.py", table)
