"""Workers of a sweep: threads of the engine, processes, or an executor."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, ProcessPoolExecutor, wait
from multiprocessing.connection import Connection
from typing import Any

from .. import _native
from ..errors import DthHammerError, LostWorkerError, UnknownNameError
from ..extras import need
from .cases import Job, Row
from .longrun import Wanted, cores, responses

SCHEDULERS = ("processes", "threads")
#: The engine's threads make a part of what comes within this time, s, if they are not told of
#: how many rows.
PART = 0.5
#: Most runs of a task, if nobody says.
TASK = 25
#: Most processes that Windows can wait for.
MOST = 61


def parts_of(
    runs: Sequence[Job],
    scheduler: str | Executor | None,
    workers: int | None,
    batch: int | None,
) -> Generator[list[Row], None, None]:
    """Yields the rows of runs in parts, as they are completed."""
    count = workers or cores()
    if isinstance(scheduler, str) and scheduler not in SCHEDULERS:
        raise UnknownNameError("scheduler", scheduler, SCHEDULERS)
    if scheduler in {None, "threads"}:
        yield from _by_engine([run for run in runs if not run.case.moves], count, batch)
        runs = [run for run in runs if run.case.moves]
    if scheduler == "threads":
        # What Python plays holds Python's lock: threads would wait for each other.
        yield from ([run.row()] for run in runs)
        return
    size = batch or max(1, min(TASK, len(runs) // 40))
    tasks = [runs[i : i + size] for i in range(0, len(runs), size)]
    if isinstance(scheduler, Executor):
        yield from _by_executor(scheduler, tasks)
    elif tasks:
        with _processes(min(count, len(tasks), MOST)) as crew:
            yield from _by_executor(crew, tasks)


def _by_engine(runs: Sequence[Job], count: int, batch: int | None) -> Iterator[list[Row]]:
    """Threads of the engine, which need nothing of Python while they work."""
    if not runs:
        return
    until = runs[0].until
    if isinstance(until, Wanted):
        yield from _by_responses(runs, until, count, batch)
        return
    scenes = [[*run.numbers.items()] for run in runs]
    native = _native.Batch(scenes, until, _native.Selection([*runs[0].names]), count)
    try:
        while (found := native.take(batch or len(runs), None if batch else PART)) is not None:
            if found:
                yield [runs[k].result(values, why, warnings) for k, values, why, warnings in found]
    except KeyboardInterrupt:
        if found := native.stop():
            yield [runs[k].result(values, why, warnings) for k, values, why, warnings in found]
        raise
    finally:
        native.stop()


def _by_responses(
    runs: Sequence[Job], wanted: Wanted, count: int, batch: int | None
) -> Iterator[list[Row]]:
    rows: list[Row] = []
    begun = time.monotonic()
    try:
        for k, found in responses([run.numbers for run in runs], wanted, threads=count):
            rows.append(runs[k].answer(found))
            if len(rows) >= batch if batch else time.monotonic() - begun >= PART:
                yield rows
                rows, begun = [], time.monotonic()
    except KeyboardInterrupt:
        yield rows
        raise
    if rows:
        yield rows


def _by_executor(crew: Executor, tasks: Sequence[Sequence[Job]]) -> Iterator[list[Row]]:
    dumps = need("cloudpickle", "sweep").dumps
    with _quietly():
        pending = {crew.submit(_rows, dumps(task)) for task in tasks}
    try:
        while pending:
            # Some systems hear of Ctrl-C between two waits only.
            done, pending = wait(pending, PART, FIRST_COMPLETED)
            for future in done:
                yield future.result()
    except DthHammerError:
        raise
    except Exception as error:
        why = f"{type(error).__name__}: {error}".rstrip(": ")
        raise LostWorkerError(f"a worker ended (killed, or out of memory: {why})") from error
    finally:
        for future in pending:
            future.cancel()


@contextlib.contextmanager
def _processes(count: int) -> Iterator[Executor]:
    """Processes that talk to this one through pipes: no socket is opened."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise DthHammerError(
            "a sweep began while a worker was starting: put what the script does under "
            "`if __name__ == '__main__':`"
        )
    fresh = multiprocessing.get_context("spawn")
    reader, writer = fresh.Pipe(duplex=False)
    crew = ProcessPoolExecutor(count, fresh, _attend, (reader,))
    with reader, writer:
        try:
            yield crew
            crew.shutdown()
        finally:
            # Whoever is still at work ends now.
            writer.close()
            crew.shutdown(cancel_futures=True)


def _attend(alive: Connection) -> None:
    """Prepares a worker, which ends when its parent closes the pipe or ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def leave() -> None:
        with contextlib.suppress(EOFError, OSError):
            alive.recv_bytes()
        os._exit(1)

    threading.Thread(target=leave, daemon=True).start()


def _rows(task: bytes) -> list[Row]:
    return [run.row() for run in pickle.loads(task)]


@contextlib.contextmanager
def _quietly() -> Iterator[None]:
    """Processes that start now leave Ctrl-C to this one, and do not run its script again.

    They need nothing of it, and a script that does not say `if __name__ == "__main__"` would
    begin its sweep in each of them.
    """
    main: Any = sys.modules["__main__"]
    saved = {name: main.__dict__[name] for name in ("__file__", "__spec__") if name in vars(main)}
    hears = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, signal.SIG_IGN) if hears else None
    for name in saved:
        delattr(main, name)
    main.__spec__ = None
    try:
        yield
    finally:
        main.__dict__.update(saved)
        if hears:
            signal.signal(signal.SIGINT, before)
