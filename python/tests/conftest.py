"""Fixtures that the package's tests share."""

import signal
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

import pytest
from dth_hammer.cli import main
from interrupting import Interrupts, interrupted

Handler = Callable[[int, FrameType | None], Any]


@pytest.fixture
def handles() -> Iterator[Callable[[int, Handler], None]]:
    """Sets signal handlers, and restores the earlier ones after the test."""
    before: dict[int, Any] = {}

    def handle(number: int, handler: Handler) -> None:
        before.setdefault(number, signal.signal(number, handler))

    yield handle
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def ctrl_c(handles: Callable[[int, Handler], None]) -> Interrupts:
    """Makes Ctrl-C work, also if a shell runs the tests in its background and ignores it."""
    handles(signal.SIGINT, signal.default_int_handler)
    return interrupted


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command and returns its output, or its one line of refusal."""

    def run(*words: object, code: int = 0) -> str:
        capsys.readouterr()
        assert main([*map(str, words)]) == code
        said = capsys.readouterr()
        assert not code or len(said.err.strip().splitlines()) == 1
        return said.err if code else said.out

    return run
