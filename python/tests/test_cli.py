"""The command line."""

import contextlib
import io
import json
import os
import re
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import matplotlib.image as mpimg
import pandas as pd
import pytest
from dth_hammer import VARIABLES, DomainError, Hammer, outputs, simulate, steady, sweep
from dth_hammer import rock as dth_rock
from dth_hammer.cli import main
from dth_hammer.commands import COMMANDS
from dth_hammer.fmu import load
from dth_hammer.scene.hammers import numbers_of
from dth_hammer.tables import rows_of
from scipy.io import loadmat

QUICK = ["--until", "150 ms"]


def test_run_writes_the_table_and_the_figure(tmp_path: Path, cli: Callable[..., str]) -> None:
    table, plot = tmp_path / "out.parquet", tmp_path / "out.png"
    command = ["run", "--rock", "granite", *QUICK, "--set", "rock.stiffness=2e9", "--quiet"]
    assert "blow_speed [m/s]" in cli(*command, "-o", table, "--plot", plot)
    frame = pd.read_parquet(table)
    assert frame.attrs["parameters"]["rock.stiffness"] == 2e9
    assert frame.index[-1] == pytest.approx(0.15)
    assert mpimg.imread(plot).shape[0] > 500


def test_sweep_takes_lists_and_ranges(tmp_path: Path, cli: Callable[..., str]) -> None:
    table = tmp_path / "out.csv"
    command = ["sweep", *QUICK, "--over", "feed_force=3:5 kN:3", "--over", "rock.viscosity=0,1e5"]
    heads, *lines = cli(*command, "--quiet", "-o", table).splitlines()
    assert len(pd.read_csv(table)) == 6
    assert "feed_force [kN]" in heads
    # The written file is itself a table of hammers, in an order of its own.
    again = cli("sweep", *QUICK, "--quiet", "--rows", table).splitlines()
    assert sorted(again[1:7]) == sorted(lines[:6])


NAMES = [variable.name for variable in VARIABLES.of("parameter", "input")]


@pytest.mark.parametrize(
    ("text", "refused"),
    [
        ("\ufefffeed_force;rock.stiffness\n4000;1,2e8\n", ""),
        ("feed_force [kN],rock.stiffness [MN/m]\n4,120\n", ""),
        ("feed_force, rock.stiffness\n4000, 1.2e8\n", ""),
        ("feed_force,gravity\n4000,9.81\n,9.81\n", "row 3: feed_force = ''"),
        ("feed_force,feed_force\n4000,5000\n", "two columns are feed_force"),
    ],
)
def test_tables_are_read_as_people_have_them(text: str, refused: str, tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    file.write_text(text, encoding="utf-8")
    if refused:
        with pytest.raises(DomainError, match=refused):
            sweep(rows_of(file, NAMES), 0.01)
    else:
        assert sweep(rows_of(file, NAMES), 0.01)["feed_force"].tolist() == [4e3]


def test_a_scene_s_file_is_a_hammer_of_every_command(
    tmp_path: Path, cli: Callable[..., str]
) -> None:
    sheet = tmp_path / "hammer.json"
    cli("datasheet", "--power", "20kW", "--frequency", "30Hz", "--hole", "140mm", "-o", sheet)
    # A byte order mark at the beginning, as Windows' Notepad writes it.
    sheet.write_text(sheet.read_text(encoding="utf-8"), encoding="utf-8-sig")
    cli("run", sheet, "--rock", "granite", "--until", "50 ms", "--quiet")
    found = numbers_of(str(sheet), rock="granite")
    assert found["rock.stiffness"] == dth_rock("granite", hole=0.14)["rock.stiffness"]
    cli("mesh", sheet)
    twice = tmp_path / "twice.json"
    twice.write_text('{"start_values": {"gravity": 1, "gravity": 2}}', encoding="utf-8")
    assert "twice.json says gravity twice" in cli("run", twice, code=2)


@pytest.mark.skipif(sys.platform == "win32", reason="no terminal to open")
@pytest.mark.parametrize(
    "command",
    [
        "report --set fidelity=Rigid -o page.html",
        "life --set mesh.degree=3 --set piston.elements=4 --set bit.elements=4 --sn 300e6,1e7,8",
        "optimise --set fidelity=Rigid --free feed_force=3e3:6e3 --starts 1 --tolerance 0",
    ],
)
def test_long_work_shows_how_far_it_is_on_a_terminal_and_nothing_in_a_pipe(
    command: str, tmp_path: Path
) -> None:
    import fcntl  # noqa: PLC0415
    import pty  # noqa: PLC0415
    import termios  # noqa: PLC0415

    ours, theirs = pty.openpty()
    # A terminal without a size has no room for a bar.
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 24, 80, 0, 0))
    words = [sys.executable, "-m", "dth_hammer.cli", *command.split()]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=theirs, cwd=tmp_path):
        os.close(theirs)
        printed = b""
        with contextlib.suppress(OSError):
            while part := os.read(ours, 4096):
                printed += part
    os.close(ours)
    assert re.search(rb"(part|blow|design)/s", printed)
    done = subprocess.run(words, check=True, capture_output=True, cwd=tmp_path)
    assert b"/s" not in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="no such devices")
def test_a_stream_that_takes_nothing_is_told_in_a_line(
    tmp_path: Path, cli: Callable[..., str]
) -> None:
    command = f"{sys.executable} -m dth_hammer info"
    for stream, code, said in ((" >/dev/full", 2, "cannot write: No space"), (" >&-", 0, "")):
        done = subprocess.run(command + stream, shell=True, capture_output=True, text=True)  # noqa: PLW1510
        assert done.returncode == code
        assert said in done.stderr
        assert "Traceback" not in done.stderr
    quick = f"{sys.executable} -m dth_hammer.cli run --quiet --set fidelity=Rigid --until 0.3"
    ascii_ = os.environ | {"PYTHONIOENCODING": "ascii"}
    assert subprocess.run(quick, shell=True, env=ascii_, check=True, capture_output=True)
    cli()
    cli("rnu", code=2)
    cli("fmu", "-o", tmp_path)
    assert load(tmp_path / "dth_hammer_fmi3.fmu").fmi == 3


def test_means_of_many_hammers_come_from_a_file_and_only_what_is_missing_is_sought(
    tmp_path: Path, cli: Callable[..., str]
) -> None:
    rows, table = tmp_path / "rows.csv", tmp_path / "means.csv"
    rows.write_text("feed_force,gravity\n4 kN,9.81\n5000,9.81\n", encoding="utf-8")
    command = ["steady", "--set", "fidelity=Rigid", "--quiet"]
    cli(*command, "--rows", rows, "-o", table)
    # The file has the rows in the order in which they ended.
    assert sorted(pd.read_csv(table)["feed_force"]) == [4e3, 5e3]
    # A known row is not computed again: otherwise it would follow the others.
    known = table.read_text(encoding="utf-8").splitlines()[1:]
    with rows.open("a", encoding="utf-8") as file:
        file.write("6 kN,9.81\n")
    cli(*command, "--rows", rows, "-o", table)
    assert table.read_text(encoding="utf-8").splitlines()[1:-1] == known
    over = cli(*command, "--over", "feed_force=4e3:6e3:2", "--units", "rop=m/h")
    heads, first, *_ = over.splitlines()
    assert "rop_error [m/h]" in heads
    assert "cycle" in first
    for options, message in (
        (["--rows", rows, "--over", "gravity=0"], "not both"),
        (["--rows", "nowhere.csv"], "nowhere.csv cannot be read"),
        (["--rows", rows, "-o", "x.csv", "--units", "us"], "keeps SI units"),
    ):
        assert message in cli(*command, *options, code=2)


def test_info_tells_units_domains_and_presets(cli: Callable[..., str]) -> None:
    text = cli("info")
    assert "preset air_4_inch" in text
    assert "rock: stiffness" in text
    assert "bit_stress[i]" in text
    assert "fidelity = Elastic" in cli("info", "parameters")
    assert "tunable parameter" in cli("info", "rock.unloading_ratio")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["info", "rock.stifness"], "did you mean 'rock.stiffness'"),
        (["run", "--set", "rock.stiffness"], "not NAME=VALUE"),
        (["run", "--until", "3 parsec"], "not in 'parsec'"),
        (["run", "--until", "nan"], "--until must be finite"),
        (["run", "--until", "0"], "--until = 0 s is not above 0"),
        (["run", "-o", "out.xls"], "out.xls must end in .parquet, .csv, .xlsx or .mat"),
        (["run", "-o", "."], "must end in"),
        (["run", "--plot", "x.foo"], "x.foo must end in"),
        (["run", "--plot", "/proc/nodir/x.png"], "x.png cannot be written"),
        (["configure", "-o", "x.fmu", "--fmu", "nowhere.fmu"], "no FMU at"),
        (["configure", "-o", "x.fmu", "--fmu", __file__], "cannot be read as an FMU"),
        (["run", "--units", "rop=kg"], "rop is given in m/s"),
        (["run", "--units", "roman"], "no system of units"),
        (["run", "--set", "piston.mass=3"], "piston has length, elements"),
        (["run", "--set", "feed_force=1", "--set", "feed_force=2"], "feed_force is given twice"),
        (["sweep", "--over", "feed_force=a:b:c"], "not FIRST:LAST:COUNT"),
        (["sweep", "--over", "feed_force=1:2:0"], "a COUNT of 1 to"),
        (["sweep", "--over", "feed_force=1:2"], "not FIRST:LAST:COUNT"),
        (["sweep", "--over", "feed_force=1:2 m:3"], "not in 'm'"),
        (["sweep", "--over", "feed_force=1", "-o", "x.xlsx"], "x.xlsx must end in"),
        (["sweep", "--over", "feed_force=1", "--workers", "0"], "workers = 0"),
        (["calibrate", "--measured", "rop=1:0.1", "--free", "rock.stifness"], "did you mean"),
        (["calibrate", "--measured", "rop=1:0.1", "--free", "rock.stiffness=3"], "LOW:HIGH"),
        (["calibrate", "--measured", "rop=1", "--free", "rock.stiffness"], "three or more values"),
        (["calibrate", "--measured", "rpo=1:2", "--free", "rock.stiffness"], "no mean is called"),
        (["optimise", "--free", "feed_force"], "is not NAME=LOW:HIGH"),
        (["optimise", "--goal", "rpo", "--free", "feed_force=1:2"], "no mean is called"),
        (["optimise", "--free", "feed_force=1:"], "feed_force"),
        (["waves", "-o", "x.foo"], "must end in .parquet, .csv, .xlsx or .mat"),
        (["report", __file__], "cannot be read as JSON"),
        (["report", "none.json"], "cannot be read"),
        (["report", "-o", "x.pdf"], "must end in .html or .htm"),
        (["report", "--units", "roman"], "no system of units"),
        (["configure", "-o", "my.csv"], "must end in"),
        (["datasheet"], "nothing is given"),
        (["life", "--sn", "200 MPa,1e7"], "is not STRENGTH,CYCLES,SLOPE"),
        (["run", "--unitl", "1"], "did you mean '--until'"),
        # A prefix is not accepted as an option: --bit might be --bit-mass or --bit-length.
        (["datasheet", "--bit", "3"], "no option of dth-hammer datasheet is called '--bit'"),
        (["run", "reference", "again"], "no use for 'again'"),
        (["run", "--until"], "expected one argument: see dth-hammer run --help"),
        (["life"], "required: --sn: see dth-hammer life --help"),
    ],
)
def test_mistakes_are_told_in_a_line_before_anything_runs(
    arguments: list[str], message: str, cli: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if not any("=" in word and "piston" in word for word in arguments):
        monkeypatch.setattr(Hammer, "run", None)
        monkeypatch.setattr("dth_hammer.study.sweeping.parts_of", None)
    assert message in cli(*arguments, code=2)


def test_units_of_the_field_are_shown_and_written(tmp_path: Path, cli: Callable[..., str]) -> None:
    table = tmp_path / "out.csv"
    command = ["run", *QUICK, "--quiet"]
    said = cli(*command, "--units", "us", "--units", "rop=m/h", "-o", table)
    assert "rop [m/h]" in said
    assert "blow_energy [ft.lbf]" in said
    plain = tmp_path / "plain.csv"
    cli(*command, "-o", plain)
    one, two = pd.read_csv(table)["rop"], pd.read_csv(plain)["rop"]
    assert one.iloc[-1] == pytest.approx(3600 * two.iloc[-1], rel=1e-12)


def cells(path: Path) -> list[list[str]]:
    """Returns the rows of a workbook's first sheet, from its XML."""
    space = {"": "http://schemas.openxmlformats.org/spreadsheetml/2006/main"}
    with zipfile.ZipFile(path) as book:
        texts = [
            "".join(t.itertext()) for t in ElementTree.fromstring(book.read("xl/sharedStrings.xml"))
        ]
        sheet = ElementTree.fromstring(book.read("xl/worksheets/sheet1.xml"))
    rows = []
    for row in sheet.iterfind(".//row", space):
        found = [(cell.get("t"), cell.findtext("v", "", space)) for cell in row]
        rows.append([texts[int(value)] if kind == "s" else value for kind, value in found])
    return rows


def test_what_is_found_is_printed_for_programs(cli: Callable[..., str]) -> None:
    hammer = ["--set", "fidelity=Rigid", "--quiet"]
    blows = json.loads(cli("run", *hammer, *QUICK, "--json"))["blows"]
    table = pd.read_csv(io.StringIO(cli("run", *hammer, *QUICK, "-o", "-")))
    # JSON and table show the same run to the last digit, because both use SI units.
    last = table[table["blow_count"] == len(blows)].iloc[-1]
    assert blows[-1]["blow_energy"] == last["blow_energy"]
    found = simulate({"fidelity": "Rigid"}, until=QUICK[1]).blows
    assert [blow["blow_time"] for blow in blows] == found["blow_time"].tolist()
    many = ["sweep", *QUICK, *hammer, "--over", "feed_force=3e3,5e3"]
    assert [row["feed_force"] for row in json.loads(cli(*many, "--json"))] == [3e3, 5e3]
    assert "--json" in cli("fmu", "--json", code=2)


def test_a_shell_completes_every_command_and_its_options(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for shell in ("bash", "zsh"):
        with pytest.raises(SystemExit, match="0"):
            main(["--completion", shell])
        said = capsys.readouterr().out
        assert all(word in said for word in (*COMMANDS, "--write-rock", "--over", "--sn"))


@pytest.mark.parametrize(
    ("words", "unused"),
    [
        ("--version", {"numpy", "pandas", "dth_hammer._native"}),
        ("--help", {"numpy", "pandas", "dth_hammer._native"}),
        *((words, {"numpy", "pandas"}) for words in ("mesh", "info", "info rock", "rock granite")),
    ],
)
def test_a_command_that_shows_no_table_imports_what_it_uses(words: str, unused: set[str]) -> None:
    script = (
        "import atexit, sys; from dth_hammer.cli import main; "
        f"atexit.register(lambda: print({unused} & {{*sys.modules}}, file=sys.stderr)); "
        f"main({words.split()})"
    )
    ran = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    assert ran.stdout
    assert ran.stderr == "set()\n"


def test_excel_and_matlab_get_the_numbers_of_the_table(
    tmp_path: Path, cli: Callable[..., str]
) -> None:
    command = ["run", "--until", "100 ms", "--quiet", "--set", "hole.diameter=90 mm", "-o"]
    for name in ("out.csv", "out.xlsx", "out.mat"):
        cli(*command, tmp_path / name)
    table = pd.read_csv(tmp_path / "out.csv")
    head, *rows = cells(tmp_path / "out.xlsx")
    assert head == [*table]
    depth, mode = head.index("tip_depth"), head.index("rock_mode")
    # Excel keeps 16 digits, so a number may differ by 1e-15 of it.
    assert [float(row[depth]) for row in rows] == pytest.approx([*table["tip_depth"]], rel=1e-14)
    assert [row[mode] for row in rows] == [*table["rock_mode"]]
    text = "=1+1"
    outputs.write(pd.DataFrame({text: [text]}), tmp_path / "text.xlsx", index=False)
    # A formula's cell has no type, and differs from that of a shared string.
    assert cells(tmp_path / "text.xlsx") == [[text], [text]]
    read = loadmat(tmp_path / "out.mat", squeeze_me=True)
    assert {*table} <= {*read}
    assert [*read["tip_depth"]] == [*table["tip_depth"]]
    assert [*read["rock_mode"]] == [*table["rock_mode"]]
    assert read["units"]["rop"] == "m/s"
    for name in ("sweep.xlsx", "sweep.mat"):  # It could not be read back and added to.
        cli("sweep", "--over", "feed_force=1", "-o", tmp_path / name, code=2)


def test_a_rock_is_calibrated_from_what_was_measured(
    tmp_path: Path, cli: Callable[..., str]
) -> None:
    truth = 1.5e8
    mean = steady({"fidelity": "Rigid", "rock.stiffness": truth}).mean
    table = tmp_path / "rock.csv"
    command = ["calibrate", "--set", "fidelity=Rigid", "--quiet", "-o", table]
    command += ["--free", "rock.stiffness=50 MN/m:400 MN/m", "--units", "rock.stiffness=MN/m"]
    rate = f"{1e3 * mean['tip_rate']:.6f} mm/s:{1e3 * 0.01 * mean['tip_rate']:.6f} mm/s"
    ratio = ",".join(str(f * mean["rebound_ratio"]) for f in (0.99, 1.0, 1.01))
    command += ["--measured", f"tip_rate={rate}", "--measured", f"rebound_ratio={ratio}"]
    said = cli(*command)
    found = pd.read_csv(table, index_col=0)
    value, low, high, _, error, unit = found.loc["rock.stiffness"]
    assert low < 1e-6 * truth < high
    # The measurement has no noise, so the deviation is roughness, which is part of the error.
    assert abs(value - 1e-6 * truth) < 2.0 * error < 0.1 * value
    assert unit == "MN/m"
    assert "chi-square" in said
    assert "1 degrees of freedom" in said


def test_the_best_feed_is_found_by_a_command(tmp_path: Path, cli: Callable[..., str]) -> None:
    table = tmp_path / "designs.csv"
    command = ["optimise", "--set", "fidelity=Rigid", "--free", "feed_force=1 kN:10 kN"]
    command += ["--goal", "tip_rate", "--limit", "tip_rate=:40 mm/s", "--starts", "2"]
    said = cli(*command, "--units", "tip_rate=mm/s", "-o", table)
    (rate,) = (float(line.split()[1]) for line in said.splitlines() if line.startswith("tip_rate"))
    # The rate rises with the feed, so the limit determines the optimum. Steps end at 0.5 % of the
    # bounds, which is 0.04 mm/s.
    assert 39.96 < rate <= 40.0 * (1.0 + 1e-4)
    assert "held by tip_rate" in said
    # Printed with six digits.
    assert (1e3 * pd.read_csv(table)["goal"] / rate - 1.0).abs().min() < 1e-5


def test_a_doubt_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--until", "2 ms", "--quiet", "--set", "drive_pressure=1e6"]) == 0
    error = capsys.readouterr().err.strip()
    assert error.startswith("dth-hammer: warning: drive_pressure is ignored")
    assert len(error.splitlines()) == 1


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    said = capsys.readouterr().out
    assert said.startswith("dth-hammer 0.")
    assert load().version in said


@pytest.mark.skipif(sys.platform == "win32", reason="no signals")
def test_ctrl_c_during_imports_is_told_in_a_line(tmp_path: Path) -> None:
    # This module stands for NumPy: the signal arrives while it is imported.
    text = "import os, signal\nos.kill(os.getpid(), signal.SIGINT)\nraise AssertionError\n"
    (tmp_path / "numpy.py").write_text(text, encoding="utf-8")
    # Calls `main` as the entry point does; a shell's background job would ignore the signal.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    script = (
        f"{heard}; import sys; from dth_hammer.cli import main; sys.exit(main(['run', '--quiet']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )
    assert (done.returncode, done.stderr) == (130, "\ndth-hammer: stopped\n")


@pytest.mark.parametrize(
    ("arguments", "packages", "extras"),
    [
        ("run --plot a.png -o a.xlsx", "tqdm, matplotlib and xlsxwriter", "excel,plot,sweep"),
        ("run -o a.mat --quiet", "scipy", "fit"),
        (
            "trend --over feed_force=0.1 --plot a.png -o a.parquet --quiet",
            "scipy, matplotlib and pyarrow",
            "fit,plot,sweep",
        ),
        (
            "report scene.json --sn 300e6,1e7,8",
            "matplotlib, tqdm and rainflow",
            "life,plot,sweep",
        ),
    ],
)
def test_a_plain_install_is_told_all_that_a_command_lacks_at_once(
    arguments: str,
    packages: str,
    extras: str,
    monkeypatch: pytest.MonkeyPatch,
    cli: Callable[..., str],
) -> None:
    monkeypatch.setattr("dth_hammer.extras.importlib.util.find_spec", lambda _: None)
    expected = f"dth-hammer: this needs {packages}: pip install 'dth-hammer[{extras}]'\n"
    assert cli(*arguments.split(), code=2) == expected
