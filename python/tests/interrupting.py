"""Ctrl-C as a terminal sends it, for tests: the fixture `ctrl_c` makes sure that it is heard."""

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest

#: What `interrupted` is, as the fixture hands it on.
Interrupts = Callable[..., AbstractContextManager[None]]


@contextlib.contextmanager
def interrupted(
    delay: float,
    begun: threading.Event | None = None,
    within: float = 1.0,
    match: str | None = None,
) -> Iterator[None]:
    """What is done meanwhile must end by a Ctrl-C, within some seconds of the processor's time.

    It is sent so many seconds after an event, if one is given. The engine promises 50 ms; by
    the clock a loaded machine may be late with all that it does, so there a minute is allowed.
    """
    sent, main = [(0.0, 0.0)], threading.get_ident()

    def send() -> None:
        if begun:
            # Where there is one core, it never begins.
            begun.wait(timeout=5.0)
        time.sleep(delay)
        sent.append((time.process_time(), time.monotonic()))
        # A thread that waits for a lock is woken by its own signals alone.
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
        # What was to be interrupted may have ended before.
        with contextlib.suppress(KeyboardInterrupt):
            thread.join()
        thread.join()
