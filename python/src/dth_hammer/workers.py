"""Who runs a sweep: a Dask client, of this machine's own workers or of a cluster."""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import dask
from dask.distributed import Client, LocalCluster

from .errors import DthHammerError, UnknownNameError


@contextmanager
def client_of(scheduler: str | Client, workers: int | None) -> Iterator[Client]:
    """A client of what is named: processes, threads, an address, or the client itself."""
    if isinstance(scheduler, Client):
        yield scheduler
    elif scheduler in ("processes", "threads"):
        apart = scheduler == "processes"
        if apart and getattr(multiprocessing.current_process(), "_inheriting", False):
            raise DthHammerError(
                "a sweep began while a worker was starting: put what the script does under "
                "`if __name__ == '__main__':`"
            )
        shape = {"n_workers": workers} if apart else {"n_workers": 1}
        threads = 1 if apart else (workers or dask.system.CPU_COUNT)
        with _quiet(), contextlib.ExitStack() as stack:
            with _ignoring_interrupts(), _without_main():
                cluster = stack.enter_context(
                    LocalCluster(
                        **shape,
                        threads_per_worker=threads,
                        processes=apart,
                        dashboard_address=None,
                        silence_logs=logging.CRITICAL,
                    )
                )
            yield stack.enter_context(Client(cluster))
    else:
        with _connect(scheduler) as client:
            yield client


def _connect(address: str) -> Client:
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


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask's own words about workers that end are for its developers."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(before)
