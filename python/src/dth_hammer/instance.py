"""An instance of the FMU whose every call is safe, with a log that stays with its instance.

fmpy can hand a Python function to an FMU, but keeps only one for the whole process and
frees it with the instance that brought it: another instance's message then calls what is
gone. Here one function lives as long as the process, and sorts messages by instance.

fmpy also unloads the library when it frees an instance, and a call after that ends the
process. So no one calls fmpy's object but `Instance.call`, which knows whether it is open.
"""

from __future__ import annotations

import contextlib
import itertools
import platform
import sys
import threading
import warnings
from collections.abc import Callable, Iterable
from ctypes import CDLL, CFUNCTYPE, ArgumentError, c_char_p, c_int, c_void_p, cast, string_at
from pathlib import Path
from typing import Any, ClassVar

import fmpy
from fmpy import calloc, free
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

from .errors import ClosedError, DomainError, FmuNotFoundError, HammerWarning, RefusedError
from .package import Package

WARNING = 1  # fmi2Warning
HERE = str(Path(__file__).parent)

_numbers = itertools.count(1)
_logs: dict[str, Log] = {}
# The FMU logs "%s" and one text. A sixth argument is where C passes that text, but for
# one platform that passes what follows "..." elsewhere.
_TEXT_FOLLOWS = not (sys.platform == "darwin" and platform.machine() == "arm64")


class Log:
    """What an instance has said: all of it, and the warnings that nobody was told yet."""

    def __init__(self) -> None:
        self.messages: list[str] = []
        self.untold: list[str] = []

    def write(self, status: int, text: str) -> None:
        """Keeps a message of the FMU."""
        if status:
            self.messages.append(text)
        if status == WARNING:
            self.untold.append(text)


def _write(
    _env: int, name: bytes, status: int, _category: bytes, pattern: bytes, text: int | None
) -> None:
    log = _logs.get(name.decode("utf-8", "replace"))
    if log is None:
        return
    whole = string_at(text) if pattern == b"%s" and _TEXT_FOLLOWS and text else pattern
    # The standard writes a plain "#" twice.
    log.write(status, whole.decode("utf-8", "replace").replace("##", "#"))


_log = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_void_p)(_write)
_CALLBACKS = fmi2CallbackFunctions()
_CALLBACKS.logger = cast(_log, fmi2CallbackLoggerTYPE)
_CALLBACKS.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
_CALLBACKS.freeMemory = fmi2CallbackFreeMemoryTYPE(free)


class FMU2Hammer(FMU2Slave):  # type: ignore[misc]  # fmpy has no types
    """fmpy's, but for how it loads the library.

    fmpy makes the library's folder the working directory while it loads, for libraries that
    need others beside them. This one needs none, and the working directory is the whole
    process's: a thread that loads would send what others write there, two that load at once
    could leave the process there, and one that fails leaves it there. Each function's
    signature is made once, not per instance.
    """

    _signatures: ClassVar[dict[str, tuple[Any, Any, Any]]] = {}

    def __init__(self, package: Package, name: str) -> None:
        # All that fmpy's own sets; it has no way to load without moving.
        self.guid = package.description.guid
        self.modelIdentifier = package.description.coSimulation.modelIdentifier
        self.unzipDirectory = package.folder
        self.instanceName = name
        self.fmiCallLogger = None
        self.requireFunctions = True
        self.component = None
        self.callbacks = None
        self._functions: dict[str, Any] = {}
        library = Path(package.folder, "binaries", fmpy.platform, self.modelIdentifier)
        self.dll = CDLL(f"{library}{fmpy.sharedLibraryExtension}")
        self._loadFunctions()

    def _loadFunctions(self) -> None:  # noqa: N802, its name there
        if not self._signatures:
            super()._loadFunctions()
            found = self._functions.items()
            type(self)._signatures = {n: (f.argnames, f.argtypes, f.restype) for n, f in found}
            return
        for name, signature in self._signatures.items():
            function = getattr(self.dll, name)
            function.argnames, function.argtypes, function.restype = signature
            self._functions[name] = function


_kept: dict[str, FMU2Hammer] = {}


def keep_loaded(package: Package) -> None:
    """Keeps a package's library loaded as long as the process lives.

    Instances that follow each other then share their decompositions: the library forgets them
    when it is unloaded, and making them takes as long as many blows. Not under Windows, where
    the file of a library that is loaded cannot be removed. A library that does not load says so
    when an instance is made.
    """
    folder = str(package.folder)
    if sys.platform != "win32" and folder not in _kept:
        with contextlib.suppress(Exception):
            _kept[folder] = FMU2Hammer(package, "kept")


class Instance:
    """One instance of the FMU, until it is closed; calls by several threads go in turn."""

    def __init__(self, package: Package, tell: Callable[[str], None]) -> None:
        self._tell_user = tell
        name = f"hammer {next(_numbers)}"
        self.log = _logs[name] = Log()
        self._lock = threading.RLock()
        self._open = False
        try:
            self.slave = FMU2Hammer(package, name)
        except Exception as error:
            del _logs[name]
            platforms = ", ".join(package.platforms) or "no platform"
            raise FmuNotFoundError(
                f"{package.path.name} is for {platforms} and does not load here: {error}"
            ) from None
        try:
            self.slave.instantiate(callbacks=_CALLBACKS)
        except Exception as error:
            del _logs[name]
            self.slave.freeLibrary()
            said = self.log.messages
            raise RefusedError(said[-1] if said else str(error)) from None
        self._open = True

    def call(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        """Calls a function of `slave`; a refusal is raised in the FMU's words."""
        with self._lock:
            if not self._open:
                raise ClosedError("this hammer is closed: read it before, or make another")
            before = len(self.log.messages)
            try:
                found = function(*arguments, **named)
            except FMICallException as error:
                said = self.log.messages[before:]
                raise RefusedError(said[-1] if said else str(error)) from None
            except (ArgumentError, TypeError, OverflowError) as error:
                raise DomainError(f"not what the FMU can take: {error}") from None
        if self.log.untold:
            self._tell()
        return found

    def close(self, states: Iterable[Any] = ()) -> None:
        """Frees states and the instance, and forgets its log; does nothing a second time."""
        with self._lock:
            if not self._open:
                return
            self._open = False
            for state in states:
                self.slave.freeFMUstate(state)
            self.slave.freeInstance()
            _logs.pop(self.slave.instanceName, None)

    @property
    def is_open(self) -> bool:
        """Whether it can be called."""
        return self._open

    def _tell(self) -> None:
        told, self.log.untold = self.log.untold, []
        for text in told:
            self._tell_user(text)


def warn(text: str) -> None:
    """Warns whoever called this package, at the line where they did."""
    depth, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(HERE):
        depth, frame = depth + 1, frame.f_back
    warnings.warn(text, HammerWarning, stacklevel=depth)
