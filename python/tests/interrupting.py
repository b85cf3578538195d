"""Ctrl-C as a terminal sends it, for tests; the fixture `ctrl_c` makes sure that it arrives."""

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest

#: The type of `interrupted`, as the fixture returns it.
Interrupts = Callable[..., AbstractContextManager[None]]


@contextlib.contextmanager
def interrupted(
    delay: float,
    begun: threading.Event | None = None,
    within: float = 1.0,
    match: str | None = None,
) -> Iterator[None]:
    """The statements inside must end by Ctrl-C, within some seconds of the processor's time.

    It is sent so many seconds after an event, if one is given. The engine promises 50 ms; by
    the clock a loaded machine may be late with all that it does, so there a minute is allowed.
    """
    sent, main = [(0.0, 0.0)], threading.get_ident()

    def send() -> None:
        if begun:
            # On a machine with one core, the event may never begin.
            begun.wait(timeout=5.0)
        time.sleep(delay)
        sent.append((time.process_time(), time.monotonic()))
        # Only a signal of its own wakes a thread that waits for a lock.
        if sys.platform == "win32":
            signal.raise_signal(signal.SIGINT)
        else:
            signal.pthread_kill(main, signal.SIGINT)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        with pytest.raises(KeyboardInterrupt, match=match):
            yield
        worked, clock = sent[-1]
        assert time.process_time() - worked < within
        assert time.monotonic() - clock < 60.0
    finally:
        # The work may have ended before the interrupt.
        with contextlib.suppress(KeyboardInterrupt):
            thread.join()
        thread.join()
