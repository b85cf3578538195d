"""Output files, checked before any work is done, so that no result is lost."""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from .errors import DomainError, OutputError, UnknownNameError, reading
from .extras import need
from .frames import pd

#: File types of tables, by suffix; and those that can be read back and extended.
TABLES = (".parquet", ".csv", ".xlsx", ".mat")
STORED = TABLES[:2]


def either(kinds: tuple[str, ...] = TABLES) -> str:
    """Joins suffixes as words."""
    return " or ".join((", ".join(kinds[:-1]), kinds[-1]) if kinds[:-1] else kinds)


def check(path: str | Path, kinds: Iterable[str] = TABLES) -> Path:
    """Returns the path if a file of one of these kinds can be written; creates no folder."""
    path, kinds = Path(path).expanduser(), tuple(kinds)
    if path.suffix.lower() not in kinds:
        raise OutputError(f"{path.name} must end in {either(kinds)}")
    if path.is_dir():
        raise OutputError(f"{path} is a folder")
    if not path.parent.is_dir():
        raise OutputError(f"{path} cannot be written: there is no folder {path.parent}")
    try:
        there = path.exists()
        with path.open("ab"):
            pass
        if not there:
            path.unlink()
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from None
    # A file is written under another name and then renamed, so the folder must be writable.
    if not os.access(path.parent, os.W_OK):
        raise OutputError(f"cannot write into {path.parent}")
    return path


def check_figure(path: str | Path) -> Path:
    """Checks the path of a figure, of the kinds that matplotlib writes."""
    canvas = need("matplotlib.backend_bases").FigureCanvasBase
    return check(path, sorted(f".{kind}" for kind in canvas.get_supported_filetypes()))


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yields a path to write to, which then replaces the file, so that no file is half written."""
    new = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        yield new
        new.replace(path)
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        new.unlink(missing_ok=True)


def write(table: pd.DataFrame, path: Path, *, index: bool = True) -> None:
    """Writes a table in the format of the suffix."""
    kind = path.suffix.lower()
    with whole(path) as new:
        if kind == ".csv":
            table.to_csv(new, index=index)
        elif kind == ".xlsx":
            need("xlsxwriter")
            plain = {"strings_to_formulas": False, "strings_to_urls": False}
            with (
                new.open("wb") as file,
                pd.ExcelWriter(file, "xlsxwriter", engine_kwargs={"options": plain}) as book,
            ):
                table.to_excel(book, index=index)
        elif kind == ".mat":
            _write_matlab(table.reset_index() if index else table, new)
        else:
            need("pyarrow")
            table.to_parquet(new, index=index)


def as_json(found: Any) -> str:
    """Returns the result of a command as JSON in SI units; a table becomes a list of its rows."""

    def plain(value: Any) -> Any:
        if isinstance(value, pd.DataFrame):
            is_labelled = any(value.index.names) or value.index.dtype == object
            return plain((value.reset_index() if is_labelled else value).to_dict("records"))
        if isinstance(value, Mapping):
            return {str(name): plain(item) for name, item in value.items()}
        if isinstance(value, list | tuple):
            return [plain(item) for item in value]
        value = value.item() if hasattr(value, "item") else value
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(plain(found), indent=2, ensure_ascii=False)


def read(path: Path) -> pd.DataFrame:
    """Reads a table that `write` has written. All cells of a CSV file are text.

    An incomplete last line (an interrupted write) is ignored. `tables` reads other files.
    """
    with reading(path, "a table", DomainError):
        if path.suffix.lower() != ".csv":
            return pd.read_parquet(path)
        text = path.read_text("utf-8-sig", "replace")
        # A line break within quotes does not end a row.
        while text and (text[-1] != "\n" or text.count('"') % 2):
            text = text[: text.rfind("\n", 0, -1) + 1]
        # As text, because pandas' reading of floats has changed between versions, and float() is
        # exact.
        return pd.read_csv(io.StringIO(text), dtype=str, keep_default_na=False)


def read_object(path: Path, known: Collection[str], what: str) -> dict[str, Any]:
    """Reads a JSON object with known keys; no key may occur twice."""

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        names = [name for name, _ in pairs]
        if twice := [name for name in names if names.count(name) > 1]:
            raise DomainError(f"{path.name} says {twice[0]} twice")
        return dict(pairs)

    with reading(path, "JSON", DomainError):
        content = json.loads(path.read_text("utf-8-sig"), object_pairs_hook=once)
    if not isinstance(content, dict):
        raise DomainError(f"{path}: it must be an object in braces")
    for key in content:
        if key not in known:
            raise UnknownNameError(f"{what} ({path.name})", key, known)
    return content


def _write_matlab(table: pd.DataFrame, path: Path) -> None:
    """Writes a variable for each column, numbers or cells of text, and one with names and units.

    MATLAB's names have letters, digits and underscores; any other character becomes an underscore.
    """
    savemat = need("scipy.io").savemat
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
