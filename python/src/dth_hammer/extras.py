"""Optional packages, and the command that installs those that are missing."""

import importlib
import importlib.util
from collections.abc import Iterable
from typing import Any

from .errors import MissingError

#: The extra that brings each optional package of a command.
EXTRAS = {
    "matplotlib": "plot",
    "scipy": "fit",
    "xlsxwriter": "excel",
    "pyarrow": "sweep",
    "tqdm": "sweep",
    "rainflow": "life",
    "fmpy": "fmi",
}


def need(module: str, extra: str) -> Any:
    """A module of an optional package; if it is missing, the error says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        if error.name is not None and error.name.partition(".")[0] != package:
            raise
        raise _missing([package], [extra]) from None


def need_all(packages: Iterable[str]) -> None:
    """Raises one error that names every missing package and the command that installs all."""
    lacking = [name for name in packages if importlib.util.find_spec(name) is None]
    if lacking:
        raise _missing(lacking, sorted({EXTRAS[name] for name in lacking}))


def _missing(packages: list[str], extras: list[str]) -> MissingError:
    names = " and ".join([", ".join(packages[:-1]), packages[-1]] if packages[1:] else packages)
    text = f"this needs {names}: pip install 'dth-hammer[{','.join(extras)}]'"
    return MissingError(text, name=packages[0])
