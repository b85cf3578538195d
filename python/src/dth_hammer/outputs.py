"""Output files, checked before any work is done, so that no result is lost."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import DomainError, OutputError
from .extras import need

if TYPE_CHECKING:
    import pandas as pd

#: What a table can be written as, by the file's suffix; what can be read back and added to.
TABLES = (".parquet", ".csv", ".xlsx", ".mat")
STORED = TABLES[:2]


def either(kinds: tuple[str, ...] = TABLES) -> str:
    """Joins suffixes as words."""
    return " or ".join((", ".join(kinds[:-1]), kinds[-1]) if kinds[:-1] else kinds)


def check(path: str | Path, kinds: Iterable[str] = TABLES) -> Path:
    """Returns the path if a file of one of these kinds can be written there; creates its folder."""
    path, kinds = Path(path).expanduser(), tuple(kinds)
    if path.suffix.lower() not in kinds:
        raise OutputError(f"{path.name} must end in {either(kinds)}")
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
            raise OutputError(f"cannot write into {path.parent}")
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from None
    return path


def check_figure(path: str | Path) -> Path:
    """Checks the path of a figure, of the kinds that matplotlib writes."""
    canvas = need("matplotlib.backend_bases", "plot").FigureCanvasBase
    return check(path, sorted(f".{kind}" for kind in canvas.get_supported_filetypes()))


def write(table: pd.DataFrame, path: Path, *, index: bool = True) -> None:
    """Writes a table in the format of the suffix; the file is always whole, old or new."""
    new = path.with_name(path.name + ".new")
    kind = path.suffix.lower()
    try:
        if kind == ".csv":
            table.to_csv(new, index=index)
        elif kind == ".xlsx":
            need("xlsxwriter", "excel")
            with new.open("wb") as file:
                table.to_excel(file, index=index, engine="xlsxwriter")
        elif kind == ".mat":
            _write_matlab(table.reset_index() if index else table, new)
        else:
            need("pyarrow", "sweep")
            table.to_parquet(new, index=index)
        new.replace(path)
    except OSError as error:
        new.unlink(missing_ok=True)
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from None


def read(path: Path) -> pd.DataFrame:
    """Reads a table that has values as they are written, with units or without."""
    import pandas as pd  # noqa: PLC0415

    if path.suffix.lower() not in STORED:
        raise DomainError(f"{path.name} must end in {either(STORED)}")
    try:
        if path.suffix.lower() == ".csv":
            with path.open(encoding="utf-8-sig") as file:
                between = max(",;\t", key=file.readline().count)
            # As text: how pandas reads a float has changed, and float() is exact.
            table = pd.read_csv(
                path, sep=between, dtype=str, keep_default_na=False, encoding="utf-8-sig"
            )
            # Where no comma is between columns, it is a decimal one.
            return table if between == "," else table.map(lambda cell: cell.replace(",", "."))
        return pd.read_parquet(path)
    except (ValueError, TypeError, OSError) as error:
        raise DomainError(f"{path} cannot be read as a table: {error}") from None


def _write_matlab(table: pd.DataFrame, path: Path) -> None:
    """A variable for each column, numbers or cells of text, and one with their names and units.

    MATLAB's names have letters, digits and underscores: another character becomes an underscore.
    """
    savemat = need("scipy.io", "fit").savemat
    units = table.attrs.get("units", {})
    names = {str(column): re.sub(r"\W", "_", str(column)).strip("_") for column in table}
    columns: dict[str, Any] = {
        names[str(column)]: values.to_numpy(float)
        if values.dtype.kind in "fiub"
        else values.astype(str).to_numpy(object)
        for column, values in table.items()
    }
    columns["units"] = {names[name]: units.get(name, "") for name in names}
    with path.open("wb") as file:
        savemat(file, columns, long_field_names=True, oned_as="column")
