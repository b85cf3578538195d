"""What can go wrong, each with a message that says what to do."""

from __future__ import annotations

import difflib
import sys
import warnings
from collections.abc import Iterable
from pathlib import Path

HERE = str(Path(__file__).parent)


class DthHammerError(Exception):
    """Base of all errors of this package."""


class MissingError(DthHammerError, ImportError):
    """A package that a plain install does not bring; says which command does."""


class FmuNotFoundError(DthHammerError, FileNotFoundError):
    """No FMU where one was looked for, or none for this machine."""


class ClosedError(DthHammerError, RuntimeError):
    """A hammer, or a state of one, that is used after its end."""


class OutputError(DthHammerError, OSError):
    """A file that cannot be written, or that would lose what is in it."""


class TooFewBlowsError(DthHammerError, ValueError):
    """A run with too few blows for what was asked of it."""


class InterruptedSweepError(KeyboardInterrupt):
    """A sweep that its user stopped; says what is kept and how to go on."""

    def __init__(self, done: int, total: int, path: object) -> None:
        self.done, self.total = done, total
        super().__init__(resuming(done, total, path) if path else f"stopped; {NOTHING_STORED}")


class LostWorkerError(DthHammerError, RuntimeError):
    """A sweep whose worker or scheduler ended before its runs; says what is kept."""

    def __init__(self, why: str, done: int = 0, total: int = 0, path: object = None) -> None:
        self.why, self.done, self.total = why, done, total
        super().__init__(f"{why}; {resuming(done, total, path) if path else NOTHING_STORED}")


NOTHING_STORED = "nothing is kept: give a file to keep runs in"


def resuming(done: int, total: int, path: object) -> str:
    """What is kept of a sweep, and how to go on."""
    return f"{done} of {total} runs are kept beside {path}: the same call goes on from there"


class HammerWarning(UserWarning):
    """Input that works but is doubtful."""


class UnknownNameError(DthHammerError, LookupError):
    """A name that is none; says which one is near."""

    def __init__(self, what: str, name: str, known: Iterable[str]) -> None:
        candidates = list(known)
        self.name, self.nearest = name, nearest(name, candidates)
        hint = f"; did you mean {self.nearest!r}?" if self.nearest else ""
        head = name.rpartition(".")[0]
        siblings = [c.removeprefix(f"{head}.") for c in candidates if c.startswith(f"{head}.")]
        if not hint and head and siblings:
            hint = f"; {head} has {', '.join(siblings)}"
        elif not hint and 0 < len(candidates) <= 6:
            hint = f"; there is {', '.join(candidates)}"
        super().__init__(f"no {what} is called {name!r}{hint}")


class DomainError(DthHammerError, ValueError):
    """A value outside its domain."""


class UnitError(DthHammerError, ValueError):
    """A unit that does not belong to the variable."""


class RefusedError(DthHammerError, RuntimeError):
    """The engine refused; the message says why."""


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name most like a wrong one, by the whole or by its last part."""
    candidates = list(known)
    whole = difflib.get_close_matches(name, candidates, n=1, cutoff=0.8)
    if whole:
        return whole[0]
    # Of equal tails the last by name: the rock's stiffness is meant more often than the contact's.
    tails = {c.rsplit(".", 1)[-1]: c for c in sorted(candidates)}
    part = difflib.get_close_matches(name.rsplit(".", 1)[-1], tails, n=1, cutoff=0.75)
    return tails[part[0]] if part else None


def warn(text: str) -> None:
    """Warns whoever called this package, at the line where they did."""
    depth, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(HERE):
        depth, frame = depth + 1, frame.f_back
    warnings.warn(text, HammerWarning, stacklevel=depth)
