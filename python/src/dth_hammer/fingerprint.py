"""A digest of code and of all that it refers to, the same in every process.

A function counts by its bytecode, defaults, closure and the globals that it names, and so do
the functions, classes and modules that these refer to, recursively. What is installed (the
standard library, packages) counts by its name and version. Other objects count by what a copy
of them would be made from, see ``object.__reduce_ex__``. What code reaches in no such way, by
``eval`` or from a file, does not count.
"""

from __future__ import annotations

import dis
import functools
import hashlib
import importlib
import sys
from collections.abc import Iterable, Iterator, Mapping, Set
from pathlib import Path
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import pandas as pd

ATOMS = (type(None), type(...), bool, int, float, complex, str, bytes)
#: What a class has of its own making, and what only says where it stands.
PLAIN = {"__dict__", "__weakref__", "__module__", "_abc_impl"}
PLAIN |= {"__firstlineno__", "__static_attributes__"}
HERE = __name__.partition(".")[0]


def digest(value: object) -> str:
    """The digest of a value.

    Raises:
        TypeError: the value refers to something that cannot be copied, such as a lock.
    """
    return _Traversal().digest(value)


class _Traversal:
    """One walk over what a value refers to. Code is entered once, so that recursion ends."""

    def __init__(self, entered: Mapping[int, object] | None = None) -> None:
        #: Functions and classes by identity, in the order in which they were met.
        self._entered: dict[int, object] = dict(entered or {})
        #: What the walk is in the middle of.
        self._above: list[object] = []

    def digest(self, value: object) -> str:
        found = hashlib.sha256()
        for word in self._words(value):
            found.update(f"{len(word)} {word}".encode("utf-8", "surrogatepass"))
        return found.hexdigest()

    def _words(self, value: object) -> Iterator[str]:
        if isinstance(value, ATOMS) and not hasattr(value, "__dict__"):
            yield f"{type(value).__name__} {value!r}"
        elif id(value) in self._entered:
            yield f"number {[*self._entered].index(id(value))}"
        elif any(one is value for one in self._above):
            yield f"level {next(k for k, one in enumerate(self._above) if one is value)}"
        else:
            if isinstance(value, (FunctionType, type)):
                self._entered[id(value)] = value
            self._above.append(value)
            yield type(value).__name__
            for part in self._parts(value):
                yield from self._words(part)
            yield "end"
            self._above.pop()

    def _parts(self, value: Any) -> Iterable[object]:  # noqa: PLR0912, a case a kind
        """What makes the value what it is."""
        match value:
            case FunctionType():
                return _function(value)
            case type():
                own = {n: part for n, part in vars(value).items() if n not in PLAIN}
                return installed(value.__module__, value.__qualname__) or (*value.__bases__, own)
            case CodeType():
                tables = getattr(value, "co_exceptiontable", b"")
                return value.co_code, value.co_names, value.co_consts, value.co_varnames, tables
            case MethodType() | staticmethod() | classmethod():
                return value.__func__, getattr(value, "__self__", None)
            case property():
                return value.fget, value.fset, value.fdel
            case functools.cached_property():
                return (value.func,)
            case BuiltinFunctionType() if isinstance(value.__self__, (ModuleType, type(None))):
                return value.__module__, value.__qualname__
            case Set():
                # The order of a set is another one in every process.
                return sorted(_Traversal(self._entered).digest(one) for one in value)
            case pd.Series():
                return value.index.tolist(), value.tolist()
            case Mapping() if type(value).__module__ == "builtins":
                return (part for item in value.items() for part in item)
            case tuple() | list() if type(value) in {tuple, list}:
                return value
            case CellType():
                return _content(value)
        copied = value.__reduce_ex__(4)
        if isinstance(copied, str):
            # Made by decorators such as functools.cache.
            return type(value), copied, getattr(value, "__wrapped__", None)
        return (list(part) if isinstance(part, Iterator) else part for part in copied)


def installed(module: str, name: str) -> tuple[str, ...]:
    """Name and version of what is installed; nothing of a user's own code."""
    top = module.partition(".")[0]
    file = getattr(sys.modules.get(module), "__file__", None) or ""
    if top in sys.stdlib_module_names - {"__main__"} or top == HERE:
        return module, name
    if {"site-packages", "dist-packages"} & {*Path(file).parts}:
        return module, name, str(getattr(sys.modules[top], "__version__", ""))
    return ()


def _content(cell: CellType) -> tuple[object, ...]:
    try:
        return (cell.cell_contents,)
    except ValueError:
        return ()


def _function(function: FunctionType) -> Iterator[object]:
    # A decorator may have given it another's __module__.
    named = installed(function.__globals__.get("__name__", ""), function.__qualname__)
    yield from named or (function.__code__, function.__defaults__, function.__kwdefaults__)
    yield from (function.__closure__ or (), vars(function))
    if not named:
        codes = [*_codes(function.__code__)]
        names = sorted({name for code in codes for name in code.co_names})
        yield from _named(function.__globals__, names, set())
        for name in sorted({name for code in codes for name in _imports(code)}):
            yield from _of_module(importlib.import_module(name), names, set())


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _imports(code: CodeType) -> Iterator[str]:
    """Modules that code imports when it runs."""
    before: list[Any] = [None, None]
    for instruction in dis.get_instructions(code):
        if instruction.opname == "IMPORT_NAME":
            if before[0]:
                raise TypeError(f"it imports {instruction.argval!r} by a relative name")
            yield instruction.argval
        before = [before[1], instruction.argval]


def _named(space: Mapping[str, Any], names: list[str], passed: set[int]) -> Iterator[object]:
    """What names stand for in a namespace; of a module, what the same names are in it."""
    for name in names:
        if isinstance(space.get(name), ModuleType):
            yield from _of_module(space[name], names, passed)
        elif name in space:
            yield from (name, space[name])


def _of_module(module: ModuleType, names: list[str], passed: set[int]) -> Iterator[object]:
    own = installed(module.__name__, "")
    yield from own or (module.__name__,)
    if not own and id(module) not in passed:
        passed.add(id(module))
        yield from _named(vars(module), names, passed)
