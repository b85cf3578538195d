"""Workers of a sweep: threads of the engine, processes, or a Dask cluster."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import queue
import signal
import sys
import threading
import time
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

from .. import _native
from ..errors import DomainError, DthHammerError, LostWorkerError, UnknownNameError
from ..extras import need
from .cases import Job, Row
from .longrun import Wanted, cores, responses

if TYPE_CHECKING:
    from dask.distributed import Client

#: The engine's threads make a part of what comes within this time, s, if they are not told of
#: how many rows.
PART = 0.5
#: Most runs of a task, if nobody says.
TASK = 25
#: Most processes that Windows can wait for.
MOST = 61


def parts_of(
    runs: Sequence[Job],
    scheduler: str | Client | None,
    workers: int | None,
    batch: int | None,
) -> Generator[list[Row], None, None]:
    """Yields the rows of runs in parts, as they are completed."""
    count = workers or cores()
    if not (scheduler is None or isinstance(scheduler, str) or hasattr(scheduler, "submit")):
        raise DomainError(
            f"scheduler = {scheduler!r} is not threads, processes, an address, or a Dask client"
        )
    if scheduler in {None, "threads"}:
        yield from _by_engine([run for run in runs if not run.case.moves], count, batch)
        runs = [run for run in runs if run.case.moves]
    if scheduler == "threads":
        # What Python plays holds Python's lock: threads would wait for each other.
        yield from ([run.row()] for run in runs)
        return
    size = batch or max(1, min(TASK, len(runs) // 40))
    tasks = [runs[i : i + size] for i in range(0, len(runs), size)]
    if scheduler in {None, "processes"}:
        yield from _by_processes(tasks, count) if tasks else ()
    else:
        with _client_of(scheduler) as client:
            yield from _by_dask(tasks, client)


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


def _by_processes(tasks: list[Sequence[Job]], count: int) -> Iterator[list[Row]]:
    """Processes that talk to this one through pipes: no socket is opened."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise DthHammerError(
            "a sweep began while a worker was starting: put what the script does under "
            "`if __name__ == '__main__':`"
        )
    cloudpickle = need("cloudpickle", "sweep")
    fresh = multiprocessing.get_context("spawn")
    reader, writer = fresh.Pipe(duplex=False)
    pool = ProcessPoolExecutor(min(count, len(tasks), MOST), fresh, _attend, (reader,))
    done: queue.SimpleQueue[Future[list[Row]]] = queue.SimpleQueue()
    with reader, writer:
        try:
            with _ignoring_interrupts(), _without_main():
                for task in tasks:
                    future = pool.submit(_unpickled, cloudpickle.dumps(task))
                    future.add_done_callback(done.put)
            for _ in tasks:
                yield _next(done)
            pool.shutdown()
        except BrokenProcessPool:
            raise LostWorkerError("a worker process ended (killed, or out of memory)") from None
        finally:
            # Whoever is still at work ends now.
            writer.close()
            pool.shutdown(cancel_futures=True)


def _next(done: queue.SimpleQueue[Future[list[Row]]]) -> list[Row]:
    # Some systems hear of Ctrl-C between two waits only.
    while True:
        with contextlib.suppress(queue.Empty):
            return done.get(timeout=PART).result()


def _attend(alive: Connection) -> None:
    """Prepares a worker, which ends when its parent closes the pipe or ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def leave() -> None:
        with contextlib.suppress(EOFError, OSError):
            alive.recv_bytes()
        os._exit(1)

    threading.Thread(target=leave, daemon=True).start()


def _unpickled(task: bytes) -> list[Row]:
    return _rows(pickle.loads(task))


def _by_dask(tasks: list[Sequence[Job]], client: Client) -> Iterator[list[Row]]:
    dask = need("dask.distributed", "cluster")
    futures = [client.submit(_rows, task, pure=False) for task in tasks]
    try:
        # On this client's own loop: the default is that of the last client made.
        for _, rows in dask.as_completed(futures, loop=client.loop, with_results=True):
            if isinstance(rows, BaseException):
                raise LostWorkerError("the Dask scheduler was lost") from None
            yield rows
    except dask.KilledWorker:
        raise LostWorkerError("workers of the Dask cluster were killed") from None
    except KeyboardInterrupt:
        client.cancel(futures, force=True)
        raise


def _rows(runs: Sequence[Job]) -> list[Row]:
    return [run.row() for run in runs]


@contextmanager
def _client_of(scheduler: str | Client) -> Iterator[Client]:
    """Returns a Dask client from an address, or the client itself."""
    if not isinstance(scheduler, str):
        yield scheduler
        return
    if ":" not in scheduler:
        raise UnknownNameError("scheduler", scheduler, ("processes", "threads"))
    dask = need("dask.distributed", "cluster")
    try:
        client = dask.Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise DthHammerError(f"no Dask scheduler answers at {scheduler}: {error}") from None
    with client:
        yield client


@contextmanager
def _ignoring_interrupts() -> Iterator[None]:
    """Processes that start now leave Ctrl-C to the one that started them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _without_main() -> Iterator[None]:
    """Processes that start now do not run the script again that started them.

    They need nothing of it, and a script that does not say `if __name__ == "__main__"` would
    begin its sweep in each of them.
    """
    main: Any = sys.modules["__main__"]
    saved = {name: main.__dict__[name] for name in ("__file__", "__spec__") if name in vars(main)}
    for name in saved:
        delattr(main, name)
    main.__spec__ = None
    try:
        yield
    finally:
        main.__dict__.update(saved)
