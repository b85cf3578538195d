"""Optional packages, and the command that installs one that is missing."""

from __future__ import annotations

import importlib
from typing import Any

from .errors import MissingError


def need(module: str, extra: str) -> Any:
    """A module of an optional package; if it is missing, the error says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        if error.name is not None and error.name.partition(".")[0] != package:
            raise
        raise MissingError(
            f"this needs {package}: pip install 'dth-hammer[{extra}]'", name=package
        ) from None
