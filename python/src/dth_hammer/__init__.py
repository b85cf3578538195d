"""Run, couple, sweep and test with a down-the-hole percussive drilling hammer.

A native module simulates the hammer, exactly in time between events. This package adds studies,
coupling, figures and files. ``__init__.pyi`` lists the public names; each is imported when it is
first used.
"""

import ast
import importlib
from importlib import metadata
from pathlib import Path
from typing import Any

_LISTED = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
#: The module that each public name is imported from; None for a name that is a module itself.
_PLACES: dict[str, str | None] = {
    name.name: node.module
    for node in _LISTED.body
    if isinstance(node, ast.ImportFrom)
    for name in node.names
}
#: Modules that need further packages, or that few need, are attributes alone.
_ATTRIBUTES = ("figures", "models", "testing")
__all__ = sorted({*_PLACES}.difference(_ATTRIBUTES))  # noqa: PLE0605, a list of names
__version__ = metadata.version("dth-hammer")


def __getattr__(name: str) -> Any:
    """Imports a public name when it is first used."""
    if name in _PLACES:
        place = _PLACES[name]
        if place is None:
            return importlib.import_module(f".{name}", __name__)
        return getattr(importlib.import_module(f".{place}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Returns the public names alone, for completion in an editor."""
    return sorted([*_PLACES, "__all__", "__doc__", "__file__", "__name__", "__version__"])
