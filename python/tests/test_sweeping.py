"""Many runs: each is made once, and the table has their order."""

import contextlib
import math
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from dask.distributed import Client, LocalCluster
from dth_hammer import (
    DomainError,
    Hammer,
    HammerWarning,
    RefusedError,
    outputs,
    steady,
    sweep,
)
from dth_hammer.errors import LostWorkerError, OutputError
from dth_hammer.scene import quantities
from dth_hammer.study.store import Store
from interrupting import Interrupts
from sweeps import UNTIL, begun, forbidden_runs, written

GRID = {"feed_force": [4e3, 5e3], "rock.stiffness": ["100 kN/mm", "200 kN/mm"]}


def test_a_row_is_what_one_run_gives() -> None:
    table = sweep(GRID, UNTIL, workers=2)
    assert table["feed_force"].tolist() == [4e3, 4e3, 5e3, 5e3]
    assert (table["error"] == "").all()
    with Hammer({"feed_force": 5e3, "rock.stiffness": 1e8}) as hammer:
        hammer.advance(UNTIL)
        assert table["rop"][2] == hammer["rop"]
    assert table.attrs["units"]["rop"] == "m/s"


def test_each_rate_has_the_range_of_its_own_rock() -> None:
    # One table with two rocks: one known within a factor of 1.1, the other within 2.
    grid = {"rock.specific_energy_factor": [1.1, 2.0]}
    rates = ["rop", "rop_mean"]
    swept = sweep(grid, UNTIL, base={"fidelity": "Rigid"}, outputs=[*rates, "blow_energy"])
    for table in (swept, steady(grid | {"fidelity": "Rigid"})):
        for rate in [rate for rate in rates if rate in table]:
            wide = table["rock.specific_energy_factor"]
            assert (table[f"{rate}_low"] == table[rate] / wide).all()
            assert (table[f"{rate}_high"] == table[rate] * wide).all()
            assert table[rate].iloc[0] > 0.0
        units = quantities.convert(table, "metric").attrs["units"]
        assert {units[column] for column in units if column.startswith("rop")} == {"m/h"}
        assert "blow_energy_low" not in table


def test_a_stopped_sweep_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "sweep.parquet"
    whole = sweep(GRID, UNTIL, workers=1)
    store = Store(out)
    store.add(whole.iloc[:1])
    store.add(whole.iloc[1:2])
    ran: list[int] = []
    add = Store.add

    def counted(store: Store, table: pd.DataFrame) -> None:
        ran.append(len(table))
        add(store, table)

    monkeypatch.setattr(Store, "add", counted)
    rest = sweep(GRID, UNTIL, workers=1, out=out)
    assert sum(ran) == 2
    assert not store.parts.exists()
    again = sweep(GRID, UNTIL, out=out)
    assert sum(ran) == 2
    pd.testing.assert_frame_equal(rest, whole)
    pd.testing.assert_frame_equal(again, whole)


def test_executors_give_the_same_to_the_last_bit() -> None:
    near = sweep(GRID, UNTIL, workers=2)
    shape = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(processes=False, **shape) as cluster, Client(cluster) as client:
        far = sweep(GRID, UNTIL, scheduler=client.get_executor())
        # The scheduler belongs to the user: it must outlive the sweep, and serve the next one.
        more = sweep({"feed_force": [6e3]}, UNTIL, scheduler=client.get_executor())
    with ThreadPoolExecutor(2) as crew:
        side = sweep(GRID, UNTIL, scheduler=crew)
    pd.testing.assert_frame_equal(far, near, check_exact=True)
    pd.testing.assert_frame_equal(side, near, check_exact=True)
    assert more["error"].tolist() == [""]


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_another_grid_adds_its_rows_and_loses_none(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"sweep{suffix}"
    first = sweep({"feed_force": [4e3, 5e3]}, UNTIL, out=out)
    second = sweep({"rock.stiffness": [1e8], "bit.elements": [10]}, "0.1 s", out=out)
    assert len(Store(out).rows()) == 3
    if suffix == ".parquet":
        # If a sweep is killed between its last two steps, the file has rows twice.
        parts = out.with_name(f"{out.name}.parts")
        parts.mkdir()
        shutil.copy(out, parts / "part.parquet")
        assert len(Store(out).rows()) == 3
    # The results are found in the file, exactly as computed, and nothing is run again.
    with forbidden_runs():
        for table, grid, until in (
            (first, {"feed_force": [4e3, 5e3]}, UNTIL),
            (second, {"rock.stiffness": [1e8], "bit.elements": [10]}, 0.1),
        ):
            pd.testing.assert_frame_equal(sweep(grid, until, out=out), table, check_exact=True)
    assert out.read_bytes()[:4] == (b"PAR1" if suffix == ".parquet" else b"run,")


def test_what_is_left_of_a_file_that_was_cut_is_read_and_the_rest_run_again(tmp_path: Path) -> None:
    grid = {"fidelity": ["Rigid"], "feed_force": [4e3, 5e3]}
    out = tmp_path / "sweep.csv"
    # With one worker the rows are in order.
    whole = sweep(grid, "20 ms", out=out, workers=1)
    text = out.read_text()
    header = text.index("\n") + 1
    # Cut within the first row, at its end, within a number of the last, before the last line's end.
    ends = [header, header + 9, text.index("\n", header) + 1, len(text) - 30, len(text) - 1]
    for end in [*ends, *range(header, len(text), len(text) // 5)]:
        out.write_text(text[:end])
        again = sweep(grid, "20 ms", out=out, workers=1)
        pd.testing.assert_frame_equal(again, whole, check_exact=True)
        assert out.read_text() == text
    for end in (3, header // 2):
        out.write_text(text[:end])
        with forbidden_runs(), pytest.raises(OutputError, match=r"sweep\.csv is there and is no"):
            sweep(grid, "20 ms", out=out)


def test_a_file_that_lost_a_column_is_refused_by_its_name(tmp_path: Path) -> None:
    grid = {"fidelity": ["Rigid"], "feed_force": [4e3]}
    for suffix in (".csv", ".parquet"):
        out = tmp_path / f"sweep{suffix}"
        sweep(grid, "20 ms", out=out)
        table = outputs.read(out)
        outputs.write(table.rename(columns={"rop": "ro\0p"}), out, index=False)
        with forbidden_runs(), pytest.raises(OutputError, match="has lost its column rop"):
            sweep({**grid, "feed_force": [4e3, 5e3]}, "20 ms", out=out)


def test_a_row_that_was_changed_in_the_file_is_no_answer(tmp_path: Path) -> None:
    grid = {"fidelity": ["Rigid"], "feed_force": [4e3, 5e3]}
    for suffix in (".csv", ".parquet"):
        out = tmp_path / f"sweep{suffix}"
        whole = sweep(grid, "20 ms", out=out)
        table = Store(out).rows()
        # Changes of an input, an output and a text; also the next float and an empty cell.
        changes = [
            ("feed_force", 4001.0),
            ("rop", np.nextafter(table["rop"][0], np.inf)),
            ("rop", math.nan),
            ("warning", "hot"),
            ("checksum", ""),
        ]
        for column, value in changes:
            changed = table.copy()
            changed.loc[0, column] = value
            outputs.write(changed, out, index=False)
            with forbidden_runs(), pytest.raises(OutputError, match=f"{table['run'][0]} was chang"):
                sweep(grid, "20 ms", out=out)
            # Rows of other runs are not checked.
            sweep({**grid, "feed_force": [float(table["feed_force"][1])]}, "20 ms", out=out)
        outputs.write(table.drop(index=0), out, index=False)
        pd.testing.assert_frame_equal(sweep(grid, "20 ms", out=out), whole, check_exact=True)


def test_a_file_that_is_no_sweep_s_is_left_alone(tmp_path: Path) -> None:
    for name, writer in (
        ("mine.csv", pd.DataFrame.to_csv),
        ("mine.parquet", pd.DataFrame.to_parquet),
    ):
        mine = tmp_path / name
        writer(pd.DataFrame({"precious": [1.0]}), mine)
        before = mine.read_bytes()
        with forbidden_runs(), pytest.raises(OutputError, match="would be lost"):
            sweep(GRID, UNTIL, out=mine)
        assert mine.read_bytes() == before


@pytest.mark.parametrize("name", ["x.xlsx", "x", "nodir.csv/x.csv", "none/x.csv"])
def test_a_file_that_cannot_be_written_is_refused_before_anything_runs(
    tmp_path: Path, name: str
) -> None:
    (tmp_path / "nodir.csv").touch()
    with forbidden_runs(), pytest.raises(OutputError):
        sweep(GRID, UNTIL, out=tmp_path / name)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(
    ("grid", "message"),
    [
        ({"feed_force": []}, "feed_force has no value"),
        ({"feed_force": {"low": 3e3}}, "or a list of"),
        ({"feed_force": None}, "or a list of"),
        ({}, "grid is empty"),
        (pd.DataFrame(), "grid is empty"),
        (pd.DataFrame({"feed_force": [3e3, float("nan")]}), "feed_force must be finite"),
    ],
)
def test_a_grid_that_is_none_is_refused(grid: Any, message: str) -> None:
    with forbidden_runs(), pytest.raises(DomainError, match=message):
        sweep(grid, UNTIL)


def test_a_point_that_is_there_twice_has_two_rows_and_one_run() -> None:
    table = sweep({"feed_force": ["4000 N", "4 kN", "5 kN"]}, UNTIL)
    assert table["feed_force"].tolist() == [4e3, 4e3, 5e3]
    assert table["run"].nunique() == 2


def test_what_is_doubtful_in_a_run_is_told_once_and_stands_in_its_row() -> None:
    grid = {"piston.length": [0.168, 168.0]}
    with pytest.warns(HammerWarning, match="1 of 2 runs: .*is the unit right") as message:
        table = sweep(grid, 1e-3)
    assert len(message) == 1
    assert [bool(text) for text in table["warning"]] == [False, True]


def test_runs_that_follow_each_other_on_one_instance_do_not_meet() -> None:
    # Runs with a doubtful value, a drive without pressure, or a refusal, each before every other.
    odd: list[dict[str, Any]] = [
        {"piston.length": 168.0},
        {"drive.source": "Force"},
        {"rock.stiffness": 1e300},
        {"drive.source": "Pressure"},
    ]
    plain = {"piston.length": 0.168, "drive.source": "Relay", "rock.stiffness": 1.2e8}
    grid = pd.DataFrame([plain | row for row in [*odd, {}, *odd[::-1], {}]])
    with pytest.warns(HammerWarning):
        table = sweep(grid, 0.05, workers=1)
    message = table[["rop", "energy_drive", "warning", "error"]].itertuples(index=False, name=None)
    for row, point in zip(message, grid.to_dict("records"), strict=True):
        if row[3]:
            with pytest.raises(RefusedError, match=re.escape(row[3])):
                Hammer(point, quiet=True)
            continue
        with Hammer(point, quiet=True) as alone:
            alone.advance(0.05)
            assert row[:2] == (alone["rop"], alone["energy_drive"])
            # A hammer warns in order of discovery, a sweep in one text at the end.
            assert sorted(row[2].split("; ")) == sorted(alone.warnings) or not row[2]
            assert bool(row[2]) == bool(alone.warnings)
    assert table["error"].astype(bool).sum() == 2
    assert table["warning"].astype(bool).sum() == 6


#: The command line, which receives Ctrl-C even if a shell runs these tests in the background.
HEARD = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from dth_hammer.cli import main
raise SystemExit(main())
"""


def wait_for_a_part(folder: Path) -> Store:
    """The table once it has rows."""
    store = Store(folder / "x.parquet")
    for _ in range(2400):
        if any(store.parts.glob("*.parquet")):
            return store
        time.sleep(0.05)
    raise TimeoutError("no row came in two minutes")


@pytest.mark.skipif(sys.platform == "win32", reason="no process groups to interrupt")
def test_an_interrupted_sweep_says_in_a_line_what_is_kept(tmp_path: Path) -> None:
    command = "sweep --until 40 --over feed_force=3e3:9e3:300 -o x.parquet"
    command += " --quiet"
    process = begun(tmp_path, "-c", HEARD, *command.split())
    wait_for_a_part(tmp_path)
    # Like a terminal, this sends the signal to the whole group.
    os.killpg(process.pid, signal.SIGINT)
    said, complaints = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said == ""
    assert len(complaints.strip().splitlines()) == 1
    message = re.search(r"(\d+) of 300 runs are kept .* goes on from there", complaints)
    assert message is not None
    assert 0 < int(message[1]) == len(Store(tmp_path / "x.parquet").rows())


def test_ctrl_c_ends_a_run_of_a_month_at_once(ctrl_c: Interrupts) -> None:
    # The engine takes some minutes for a day.
    with ctrl_c(1.0, within=20.0, match="nothing is kept"):
        sweep({"feed_force": [4e3, 5e3]}, 2.6e6, workers=2)


LONG = """
import time
from dth_hammer import sweep

def slow(hammer):
    time.sleep(0.02)

sweep({"feed_force": [3e3 + k for k in range(300)]}, 0.05, control=slow, step="1 ms", version=1,
      out="x.parquet")
"""


@pytest.fixture
def at_work(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A sweep in a process of its own that has kept a row and will take minutes more."""
    process = begun(tmp_path, written(tmp_path, LONG))
    try:
        wait_for_a_part(tmp_path)
        yield process
    finally:
        process.kill()
        process.communicate()


def test_a_second_writer_is_told_of_the_first_and_takes_over_when_it_is_dead(
    at_work: subprocess.Popen[str], tmp_path: Path
) -> None:
    out, grid = tmp_path / "x.parquet", {"feed_force": [4e3]}
    message = (
        f"is being written by process {at_work.pid} on {re.escape(socket.gethostname())} since"
    )
    with pytest.raises(OutputError, match=message):
        sweep(grid, 0.01, out=out)
    at_work.kill()
    at_work.wait()
    before = len(Store(out).rows())
    sweep(grid, 0.01, out=out)
    assert len(Store(out).rows()) == before + 1


@pytest.mark.weekly
def test_a_cluster_whose_worker_is_killed_loses_no_row() -> None:
    shape = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    grid = {"feed_force": [4e3 + 10.0 * k for k in range(40)]}
    with LocalCluster(**shape) as cluster, Client(cluster) as client:
        pid = client.submit(os.getpid, pure=False).result()
        killer = threading.Timer(1.0, os.kill, (pid, signal.SIGKILL))
        killer.start()
        far = sweep(grid, "20 s", scheduler=client.get_executor())
        killer.join()
        assert pid not in client.run(os.getpid).values()
    near = sweep(grid, "20 s")
    pd.testing.assert_frame_equal(far, near, check_exact=True)


@pytest.mark.weekly
def test_a_cluster_whose_scheduler_is_killed_keeps_what_has_come(tmp_path: Path) -> None:
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--no-dashboard"]
    file, out = tmp_path / "scheduler.json", tmp_path / "rows.parquet"
    grid = {"feed_force": [4e3 + 10.0 * k for k in range(40)]}
    with contextlib.ExitStack() as stack:
        started = []
        for part, *options in (("scheduler", "--port", "0"), ("worker", "--nthreads", "1")):
            dask[2] = f"distributed.cli.dask_{part}"
            words = [*dask, *options, "--scheduler-file", str(file)]
            started.append(stack.enter_context(subprocess.Popen(words)))
            stack.callback(started[-1].kill)
        while not file.exists():
            time.sleep(0.1)
        client = stack.enter_context(Client(scheduler_file=str(file)))
        client.wait_for_workers(1)
        threading.Timer(5.0, started[0].kill).start()
        with pytest.raises(LostWorkerError, match="are kept beside"):
            sweep(grid, "20 s", scheduler=client.get_executor(), out=out)
    assert 0 < len(Store(out).rows()) < 40
