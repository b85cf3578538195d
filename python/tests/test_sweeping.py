"""Many runs: all of them, once each, in order."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest
from dask.distributed import Client, LocalCluster
from dth_hammer import (
    DomainError,
    DthHammerError,
    FmuNotFoundError,
    Hammer,
    UnknownNameError,
    sweep,
    sweeping,
)

GRID = {"feed_force": [4e3, 5e3], "rock.stiffness": ["100 kN/mm", "200 kN/mm"]}
UNTIL = 0.15


def test_a_row_is_what_one_run_gives() -> None:
    table = sweep(GRID, UNTIL, scheduler="threads", workers=2, batch=1)
    assert table["feed_force"].tolist() == [4e3, 4e3, 5e3, 5e3]
    assert (table["error"] == "").all()
    with Hammer({"feed_force": 5e3, "rock.stiffness": 1e8}) as hammer:
        hammer.advance(UNTIL)
        assert table["rop"][2] == hammer["rop"]
    assert table.attrs["units"]["rop"] == "m/s"


def test_processes_and_threads_agree() -> None:
    one = sweep(GRID, UNTIL, scheduler="threads", workers=1)
    two = sweep(GRID, UNTIL, scheduler="processes", workers=1)
    pd.testing.assert_frame_equal(one, two)


def test_a_stopped_sweep_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "sweep.parquet"
    whole = sweep(GRID, UNTIL, scheduler="threads", workers=1)
    store = sweeping._Store(out)
    store.add(whole.iloc[:1])
    store.add(whole.iloc[1:2])
    ran: list[int] = []
    add = sweeping._Store.add

    def counted(store: sweeping._Store, table: pd.DataFrame) -> None:
        ran.append(len(table))
        add(store, table)

    monkeypatch.setattr(sweeping._Store, "add", counted)
    rest = sweep(GRID, UNTIL, scheduler="threads", workers=1, batch=1, out=out)
    assert ran == [1, 1]
    assert not store.parts.exists()
    again = sweep(GRID, UNTIL, out=out)
    assert ran == [1, 1]
    pd.testing.assert_frame_equal(rest, whole)
    pd.testing.assert_frame_equal(again, whole)


def test_a_refused_run_says_why_and_stops_nobody() -> None:
    table = sweep({"rock.unloading_ratio": [1.0, 4.0]}, UNTIL, scheduler="threads", workers=1)
    assert "rock.unloading_ratio" in table["error"][0]
    assert table["error"][1] == ""
    assert table["rop"].notna().tolist() == [False, True]


def test_mistakes_are_found_before_anything_runs() -> None:
    with pytest.raises(UnknownNameError):
        sweep({"feed_forse": [1.0]}, UNTIL)
    with pytest.raises(DomainError):
        sweep({"rock.stiffness": [1e8, -1.0]}, UNTIL)
    with pytest.raises(UnknownNameError):
        sweep(GRID, UNTIL, outputs=["ropp"])


def test_a_scheduler_that_is_not_there_is_named() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'threads'"):
        sweep(GRID, UNTIL, scheduler="thread")
    with pytest.raises(DthHammerError, match="no Dask scheduler answers at udp:"):
        sweep(GRID, UNTIL, scheduler="udp://127.0.0.1:1")


@contextmanager
def program(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """A program of Dask's, ended when its user is done."""
    process = subprocess.Popen(
        [sys.executable, "-m", *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield process
    finally:
        process.terminate()
        process.wait(timeout=30)


def test_a_cluster_by_its_address_gives_the_same_to_the_last_bit(tmp_path: Path) -> None:
    contact = tmp_path / "scheduler.json"
    shared = ("--scheduler-file", str(contact), "--host", "127.0.0.1", "--no-dashboard")
    with (
        program("distributed.cli.dask_scheduler", *shared, "--port", "0") as scheduler,
        program("distributed.cli.dask_worker", *shared, "--nworkers", "2", "--nthreads", "1"),
    ):
        for _ in range(300):
            if contact.is_file() and contact.read_text(encoding="utf-8").strip():
                break
            time.sleep(0.1)
        address = json.loads(contact.read_text(encoding="utf-8"))["address"]
        assert address.startswith("tcp://127.0.0.1:")
        far = sweep(GRID, UNTIL, scheduler=address, batch=1)
        # It is another's cluster: it must outlive the sweep, and serve the next one.
        assert scheduler.poll() is None
        with pytest.raises(FmuNotFoundError):
            sweep(GRID, UNTIL, scheduler=address, fmu=tmp_path / "nowhere.fmu")
        more = sweep({"feed_force": [6e3]}, UNTIL, scheduler=address)
    near = sweep(GRID, UNTIL, scheduler="threads", workers=2)
    pd.testing.assert_frame_equal(far, near, check_exact=True)
    assert more["error"].tolist() == [""]


def test_two_clients_in_one_process_do_not_meet() -> None:
    shape = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": ":0"}
    with (
        LocalCluster(processes=False, **shape) as near,
        Client(near) as one,
        LocalCluster(processes=False, **shape) as far,
        Client(far) as two,
    ):
        tables = [sweep(GRID, UNTIL, scheduler=client, batch=1) for client in (one, two)]
    pd.testing.assert_frame_equal(*tables)
