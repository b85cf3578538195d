"""Optional packages, and the command that installs those that are missing."""

import importlib
import importlib.util
from collections.abc import Iterable
from typing import Any

from .errors import MissingError

#: The extra that brings each optional package.
EXTRAS = {
    "matplotlib": "plot",
    "scipy": "fit",
    "xlsxwriter": "excel",
    "pyarrow": "sweep",
    "tqdm": "sweep",
    "cloudpickle": "sweep",
    "rainflow": "life",
    "fmpy": "fmi",
}


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
    extras = sorted({EXTRAS[name] for name in packages})
    names = " and ".join([", ".join(packages[:-1]), packages[-1]] if packages[1:] else packages)
    text = f"this needs {names}: pip install 'dth-hammer[{','.join(extras)}]'"
    return MissingError(text, name=packages[0])
