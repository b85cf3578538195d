"""Makes fmpy's object of an instance, with a log that stays with its instance.

fmpy can hand a Python function to an FMU, but keeps only one for the whole process and
frees it with the instance that brought it: another instance's message then calls what is
gone. Here one function lives as long as the process, and sorts messages by instance.
"""

from __future__ import annotations

import itertools
import platform
import sys
from ctypes import CFUNCTYPE, c_char_p, c_int, c_void_p, cast, string_at

from fmpy import calloc, free
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

from .errors import FmuNotFoundError, RefusedError
from .package import Package

_numbers = itertools.count(1)
_messages: dict[str, list[str]] = {}
# The FMU logs "%s" and one text. A sixth argument is where C passes that text, but for
# one platform that passes what follows "..." elsewhere.
_TEXT_FOLLOWS = not (sys.platform == "darwin" and platform.machine() == "arm64")


def _write(
    _env: int, name: bytes, status: int, _category: bytes, pattern: bytes, text: int | None
) -> None:
    messages = _messages.get(name.decode("utf-8", "replace"))
    if not status or messages is None:
        return
    whole = string_at(text) if pattern == b"%s" and _TEXT_FOLLOWS and text else pattern
    messages.append(whole.decode("utf-8", "replace"))


_log = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_void_p)(_write)
_CALLBACKS = fmi2CallbackFunctions()
_CALLBACKS.logger = cast(_log, fmi2CallbackLoggerTYPE)
_CALLBACKS.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
_CALLBACKS.freeMemory = fmi2CallbackFreeMemoryTYPE(free)


def instantiate(package: Package) -> tuple[FMU2Slave, list[str]]:
    """A new instance, and the list that its warnings and errors are added to."""
    name = f"hammer {next(_numbers)}"
    messages: list[str] = []
    _messages[name] = messages
    try:
        slave = FMU2Slave(
            instanceName=name,
            guid=package.description.guid,
            unzipDirectory=package.folder,
            modelIdentifier=package.description.coSimulation.modelIdentifier,
        )
    except Exception as error:
        platforms = ", ".join(package.platforms) or "no platform"
        raise FmuNotFoundError(
            f"{package.path.name} is for {platforms} and does not load here: {error}"
        ) from None
    try:
        slave.instantiate(callbacks=_CALLBACKS)
    except Exception as error:
        raise RefusedError(messages[-1] if messages else str(error)) from None
    return slave, messages


def release(slave: FMU2Slave) -> None:
    """Frees the instance and forgets its log."""
    slave.freeInstance()
    _messages.pop(slave.instanceName, None)
