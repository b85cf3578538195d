"""What does the runs of a sweep: threads of this process, processes, or a cluster of Dask's."""

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
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, TypeVar

from .errors import DthHammerError, LostWorkerError, UnknownNameError
from .extras import need
from .runs import Row, Run, Stand

if TYPE_CHECKING:
    from dask.distributed import Client

T = TypeVar("T")
#: Threads make a part of what comes within this time, s, if they are not told of how many rows.
PART = 0.5
#: Most runs of a task of Dask's, if nobody says.
TASK = 25
#: Most processes that Windows can wait for.
MOST = 61
#: What runs at Ctrl-C has this time to end, s.
PATIENCE = 2.0


def parts_of(
    runs: Sequence[Run],
    scheduler: str | Client | None,
    workers: int | None,
    batch: int | None,
) -> Generator[list[Row], None, None]:
    """The rows of runs as they come, in parts."""
    if scheduler is None:
        scheduler = "processes" if any(run.case.moves for run in runs) else "threads"
    if scheduler == "threads":
        yield from _by_threads(runs, workers or _cores(), batch)
        return
    size = batch or max(1, min(TASK, len(runs) // 40))
    tasks = [runs[i : i + size] for i in range(0, len(runs), size)]
    if scheduler == "processes":
        yield from _by_processes(tasks, workers or _cores())
        return
    with client_of(scheduler) as client:
        yield from _by_dask(tasks, client)


def _cores() -> int:
    """Those that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _by_threads(runs: Sequence[Run], count: int, batch: int | None) -> Iterator[list[Row]]:
    """Threads that take run after run; nothing goes through a pipe or a file."""
    todo: deque[Run] = deque(runs)
    done: queue.SimpleQueue[Row | BaseException] = queue.SimpleQueue()

    def work() -> None:
        try:
            with contextlib.closing(Stand()) as stand:
                while (run := next_run()) is not None:
                    done.put(run.row(stand))
        except BaseException as error:
            done.put(error)

    def next_run() -> Run | None:
        try:
            return todo.popleft()
        except IndexError:
            return None

    # Daemons: a run that takes long does not keep anyone who has interrupted the sweep.
    crew = [threading.Thread(target=work, daemon=True) for _ in range(min(count, len(runs)))]
    for thread in crew:
        thread.start()
    left, began = len(runs), time.monotonic()
    rows: list[Row] = []
    try:
        while left:
            left -= _taken(done, rows)
            full = len(rows) >= batch if batch else time.monotonic() - began >= PART
            if rows and (full or not left):
                yield rows
                rows, began = [], time.monotonic()
    except KeyboardInterrupt:
        todo.clear()
        _join(crew)
        while not done.empty():
            _taken(done, rows)
        if rows:
            yield rows
        raise
    finally:
        todo.clear()
        _join(crew)


def _join(crew: Sequence[threading.Thread]) -> None:
    until = time.monotonic() + PATIENCE
    for thread in crew:
        thread.join(max(0.0, until - time.monotonic()))


def _taken(done: queue.SimpleQueue[Row | BaseException], rows: list[Row]) -> int:
    """Takes one more row, if one comes while it waits; how many it took."""
    try:
        # Some systems hear of Ctrl-C between two waits only.
        found = done.get(timeout=PART)
    except queue.Empty:
        return 0
    if isinstance(found, BaseException):
        raise found
    rows.append(found)
    return 1


def _by_processes(tasks: list[Sequence[Run]], count: int) -> Iterator[list[Row]]:
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
                yield _next(done).result()
            pool.shutdown()
        except BrokenProcessPool:
            raise LostWorkerError("a worker process ended (killed, or out of memory)") from None
        finally:
            # Whoever is still at work ends now.
            writer.close()
            pool.shutdown(cancel_futures=True)


def _next(done: queue.SimpleQueue[T]) -> T:
    # Some systems hear of Ctrl-C between two waits only.
    while True:
        with contextlib.suppress(queue.Empty):
            return done.get(timeout=PART)


def _attend(alive: Connection) -> None:
    """Prepares a worker: it ends when the process that started it closes the pipe, or ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def leave() -> None:
        with contextlib.suppress(EOFError, OSError):
            alive.recv_bytes()
        os._exit(1)

    threading.Thread(target=leave, daemon=True).start()


def _unpickled(task: bytes) -> list[Row]:
    return _rows(pickle.loads(task))


def _by_dask(tasks: list[Sequence[Run]], client: Client) -> Iterator[list[Row]]:
    distributed = need("dask.distributed", "sweep")

    futures = [client.submit(_rows, task, pure=False) for task in tasks]
    try:
        # On this client's own loop: the default is that of the last client made.
        for _, rows in distributed.as_completed(futures, loop=client.loop, with_results=True):
            if isinstance(rows, BaseException):
                raise LostWorkerError("the Dask scheduler was lost") from None
            yield rows
    except distributed.KilledWorker:
        raise LostWorkerError("workers of the Dask cluster were killed") from None
    except KeyboardInterrupt:
        client.cancel(futures, force=True)
        raise


def _rows(runs: Sequence[Run]) -> list[Row]:
    with contextlib.closing(Stand()) as stand:
        return [run.row(stand) for run in runs]


@contextmanager
def client_of(scheduler: str | Client) -> Iterator[Client]:
    """A client of what is named: an address, or the client itself."""
    from dask.distributed import Client  # noqa: PLC0415, takes longer than a sweep

    if isinstance(scheduler, Client):
        yield scheduler
    else:
        with _connect(scheduler) as client:
            yield client


def _connect(address: str) -> Client:
    from dask.distributed import Client  # noqa: PLC0415

    if ":" not in address:
        raise UnknownNameError("scheduler", address, ("processes", "threads"))
    try:
        return Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise DthHammerError(f"no Dask scheduler answers at {address}: {error}") from None


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
    kept = {name: main.__dict__[name] for name in ("__file__", "__spec__") if name in vars(main)}
    for name in kept:
        delattr(main, name)
    main.__spec__ = None
    try:
        yield
    finally:
        main.__dict__.update(kept)
