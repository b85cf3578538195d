"""The errors of this package; each message says what to do."""

import contextlib
import difflib
import re
import sys
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

HERE = str(Path(__file__).parent)


class DthHammerError(Exception):
    """Base of all errors of this package."""


class MissingError(DthHammerError, ImportError):
    """An optional package is missing; the message has the command that installs it."""


class FmuNotFoundError(DthHammerError, FileNotFoundError):
    """There is no FMU, or none for this machine."""


class ClosedError(DthHammerError, RuntimeError):
    """A hammer, or a state of one, was used after it was closed."""


class OutputError(DthHammerError, OSError):
    """A file cannot be written, or writing would lose its content."""


class TooFewBlowsError(DthHammerError, ValueError):
    """A run has too few blows."""


class InterruptedSweepError(KeyboardInterrupt):
    """The user stopped a sweep; the message says what is saved and how to continue."""


class LostWorkerError(DthHammerError, RuntimeError):
    """A worker or scheduler of a sweep ended early; the message says what is saved."""


class HammerWarning(UserWarning):
    """Input that is allowed but probably unintended."""


@contextlib.contextmanager
def reading(path: object, what: str, error: type[DthHammerError]) -> Iterator[None]:
    """Turns any error that reading a file raises into ``error``, as one line.

    The file may come from elsewhere and be damaged in any way.

    Args:
        path: the file.
        what: the kind of content that was expected, for instance ``"a table"``.
        error: the error of this package to raise.
    """
    try:
        yield
    except DthHammerError:
        raise
    except RecursionError:
        raise error(f"{path} cannot be read as {what}: it is nested too deep") from None
    except Exception as problem:  # Readers of archives and tables raise more kinds than they list.
        words = " ".join(str(problem).split()) or type(problem).__name__
        raise error(f"{path} cannot be read as {what}: {words[:LONGEST]}") from None


#: Most characters of another library's message that a message may contain.
LONGEST = 300
MOST = 12
#: Former names in saved scenes (for a dotted name its first part), and their replacements.
GONE = {
    "chambers": "the chambers are those of Air now (drive.source = Air, parameters air.*)",
    "hole_depth": "it is tip_depth now; the depth of the hole is drilled_length",
}


class UnknownNameError(DthHammerError, LookupError):
    """An unknown name; the message proposes the most similar known one."""

    def __init__(self, what: str, name: object, known: Iterable[str]) -> None:
        name, candidates = str(name), list(known)
        gone = GONE.get(name.partition(".")[0].lower())
        self.name, self.nearest = name, None if gone else nearest(name, candidates)
        hint = f"; did you mean {self.nearest!r}?" if self.nearest else ""
        hint = f"; {gone}" if gone else hint
        groups = {c.partition(".")[0] for c in candidates if "." in c}
        head = name if name in groups else name.rpartition(".")[0]
        siblings = [c.removeprefix(f"{head}.") for c in candidates if c.startswith(f"{head}.")]
        if not hint and head and siblings:
            own = dict.fromkeys(re.sub(r"\[\d+\]", "[i]", sibling) for sibling in siblings)
            hint = f"; {head} has {', '.join(own)}"
        elif not hint and 0 < len(candidates) <= MOST:
            hint = f"; there is {', '.join(candidates)}"
        super().__init__(f"no {what} is called {name!r}{hint}")


class DomainError(DthHammerError, ValueError):
    """A value outside its domain, of a wrong type, or in a wrong unit."""


class RefusedError(DthHammerError, RuntimeError):
    """The engine refused; the message says why."""


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Returns the known name that is most similar to a wrong one, in whole or in its last part."""
    candidates = list(known)
    # The same letters in another order.
    if turned := [c for c in candidates if sorted(c) == sorted(name)]:
        return turned[0]
    whole = difflib.get_close_matches(name, candidates, n=1, cutoff=0.8)
    if whole:
        return whole[0]
    # If the group exists, only its own names: a piston has no mass, but a casing has.
    group = name.rpartition(".")[0] + "."
    candidates = [c for c in candidates if len(group) > 1 and c.startswith(group)] or candidates
    # Of equal last parts the last in order: users mean the rock's stiffness more often than the
    # contact's.
    tails = {c.rsplit(".", 1)[-1]: c for c in sorted(candidates)}
    part = difflib.get_close_matches(name.rsplit(".", 1)[-1], tails, n=1, cutoff=0.75)
    begun = [c for c in candidates if len(name) > 2 and re.match(rf"{re.escape(name)}[._]", c)]
    return tails[part[0]] if part else begun[0] if len(begun) == 1 else None


def warn(text: str) -> None:
    """Warns at the line of the user's code that called this package."""
    depth, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(HERE):
        depth, frame = depth + 1, frame.f_back
    warnings.warn(text, HammerWarning, stacklevel=depth)
