"""Files that are written: looked at before any work is done, so that none is lost."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import OutputError
from .extras import need

if TYPE_CHECKING:
    import pandas as pd

#: What a table can be written as, by the file's suffix.
TABLES = (".parquet", ".csv")


def check(path: str | Path, kinds: Iterable[str] = TABLES) -> Path:
    """The path, if a file of one of these kinds can be written there; its folder is made."""
    path, kinds = Path(path).expanduser(), tuple(kinds)
    if path.suffix.lower() not in kinds:
        allowed = " or ".join((", ".join(kinds[:-1]), kinds[-1]) if kinds[:-1] else kinds)
        raise OutputError(f"{path.name} must end in {allowed}")
    if path.is_dir():
        raise OutputError(f"{path} is a folder")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        there = path.exists()
        with path.open("ab"):
            pass
        if not there:
            path.unlink()
        # A file is written beside its name and then takes it: the folder must allow that.
        if not os.access(path.parent, os.W_OK):
            raise OutputError(f"nothing can be written into {path.parent}")
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from None
    return path


def check_figure(path: str | Path) -> Path:
    """The same for a figure, of the kinds that matplotlib writes."""
    canvas = need("matplotlib.backend_bases", "plot").FigureCanvasBase
    return check(path, sorted(f".{kind}" for kind in canvas.get_supported_filetypes()))


def write(table: pd.DataFrame, path: Path, *, index: bool = True) -> None:
    """Writes a table by the file's suffix; what is there is whole, the old or the new."""
    new = path.with_name(path.name + ".new")
    try:
        if path.suffix.lower() == ".csv":
            table.to_csv(new, index=index)
        else:
            need("pyarrow", "sweep")
            table.to_parquet(new, index=index)
        new.replace(path)
    except OSError as error:
        new.unlink(missing_ok=True)
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from None
