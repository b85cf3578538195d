"""Optional packages, and the command that installs those that are missing."""

import importlib
import importlib.util
import re
from collections.abc import Iterable
from typing import Any

from .errors import MissingError


def need(module: str) -> Any:
    """Imports a module of an optional package.

    Raises:
        MissingError: the package is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        if error.name is not None and error.name.partition(".")[0] != package:
            raise
        raise _missing([package]) from None


def need_all(packages: Iterable[str]) -> None:
    """Raises one error that names all missing packages and the command that installs them."""
    if missing := [name for name in packages if importlib.util.find_spec(name) is None]:
        raise _missing(missing)


def bar(show: bool, items: Any = None, **named: Any) -> Any:
    """Returns a progress bar over items, or only the items if ``show`` is false.

    The bar is drawn only on a terminal.
    """
    options = {"leave": False, "disable": None} | named
    return need("tqdm").tqdm(items, **options) if show else items


def _missing(packages: list[str]) -> MissingError:
    extras = sorted({_extra(name) for name in packages})
    names = " and ".join([", ".join(packages[:-1]), packages[-1]] if packages[1:] else packages)
    text = f"this needs {names}: pip install 'dth-hammer[{','.join(extras)}]'"
    return MissingError(text, name=packages[0])


def _extra(package: str) -> str:
    """Returns the extra of this package that installs an optional package, from the metadata."""
    from importlib import metadata  # noqa: PLC0415, takes a third as long as NumPy

    lines = metadata.requires("dth-hammer") or []
    matches = (re.match(rf"{package}\b.*extra == .(\w+)", line) for line in lines)
    return next(match[1] for match in matches if match)
