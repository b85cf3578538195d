"""Optional packages, and the command that installs those that are missing."""

import importlib
import importlib.util
import re
from collections.abc import Iterable
from importlib import metadata
from typing import Any

from .errors import MissingError


def need(module: str) -> Any:
    """A module of an optional package; if it is missing, the error says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        if error.name is not None and error.name.partition(".")[0] != package:
            raise
        raise _missing([package]) from None


def need_all(packages: Iterable[str]) -> None:
    """Raises one error that names every missing package and the command that installs all."""
    if lacking := [name for name in packages if importlib.util.find_spec(name) is None]:
        raise _missing(lacking)


def bar(shown: bool, each: Any = None, **named: Any) -> Any:
    """A progress bar over items, drawn on a terminal alone; the items if none is wanted."""
    ways = {"leave": False, "disable": None} | named
    return need("tqdm").tqdm(each, **ways) if shown else each


def _missing(packages: list[str]) -> MissingError:
    extras = sorted({_extra(name) for name in packages})
    names = " and ".join([", ".join(packages[:-1]), packages[-1]] if packages[1:] else packages)
    text = f"this needs {names}: pip install 'dth-hammer[{','.join(extras)}]'"
    return MissingError(text, name=packages[0])


def _extra(package: str) -> str:
    """The extra that brings an optional package, as this package's metadata has it."""
    lines = metadata.requires("dth-hammer") or []
    found = (re.match(rf"{package}\b.*extra == .(\w+)", line) for line in lines)
    return next(match[1] for match in found if match)
