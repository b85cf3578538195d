"""The file of a sweep. Rows are only added, never changed."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import socket
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

from .. import outputs
from ..errors import OutputError
from ..frames import pd

#: Columns: the run's key, and the checksum of the rest of its row.
RUN, CHECKSUM = "run", "checksum"
#: Columns of text, which may be empty or look like numbers.
TEXTS = (RUN, "case", "error", "warning", "model", "kind", CHECKSUM)


class Store:
    """A table's file, and a folder of parts while the sweep is incomplete."""

    def __init__(self, path: Path) -> None:
        self.path = outputs.check(path, outputs.STORED)
        self.parts = self.path.with_name(self.path.name + ".parts")
        if self.path.is_file() and self.path.stat().st_size:
            self._read(self.path)

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """Locks the table against other sweeps; the lock ends with the process."""
        self.parts.mkdir(exist_ok=True)
        lock = self.parts / "lock"
        while True:
            file = lock.open("a+", encoding="utf-8")
            try:
                _lock(file)
            except OSError:
                file.seek(0)
                holder = file.read() or "another process"
                file.close()
                raise OutputError(
                    f"{self.path} is being written by {holder}: wait for it, stop it, or choose "
                    "another file"
                ) from None
            with contextlib.suppress(OSError):
                if os.path.samestat(os.fstat(file.fileno()), lock.stat()):
                    break
            # The former holder has removed this file: lock a new one.
            file.close()
            self.parts.mkdir(exist_ok=True)
        with file:
            file.truncate(0)
            began = time.strftime("%Y-%m-%d %H:%M:%S %z")
            file.write(f"process {os.getpid()} on {socket.gethostname()} since {began}")
            file.flush()
            try:
                yield
            finally:
                # Remove it while it is locked; otherwise it could already be the next writer's.
                # Windows cannot.
                if os.name != "nt":
                    lock.unlink()
        with contextlib.suppress(OSError):
            if os.name == "nt":
                lock.unlink()
            self.parts.rmdir()

    def rows(self) -> pd.DataFrame:
        """Returns all stored rows, each once."""
        return self._together(self._files())

    def whole(self, columns: Mapping[str, Iterable[str]]) -> pd.DataFrame:
        """Returns all stored rows.

        Raises:
            OutputError: a row of these runs lacks a column, or was changed since it was written.
        """
        table = self.rows()
        for row in table.to_dict("records"):
            for column in (*columns.get(row[RUN], ()), CHECKSUM):
                if row[RUN] in columns and column not in table:
                    raise OutputError(
                        f"{self.path} has lost its column {column}: choose another file"
                    )
            if row[RUN] in columns and row[CHECKSUM] != _checksum(row):
                raise OutputError(
                    f"{self.path}: the row of run {row[RUN]} was changed since it was written: "
                    "delete the row, which is then run again, or choose another file"
                )
        return table

    def add(self, table: pd.DataFrame) -> None:
        """Stores rows as a new part."""
        self.parts.mkdir(exist_ok=True)
        table = _plain(table)
        table[CHECKSUM] = [_checksum(row) for row in table.to_dict("records")]
        outputs.write(table, self.parts / f"{table[RUN].iloc[0]}.parquet", index=False)

    def finish(self) -> None:
        """Merges all rows into one file, including those of other grids and sweeps."""
        files = self._files()
        if files == [self.path]:
            return
        outputs.write(self._together(files), self.path, index=False)
        for part in files:
            if part != self.path:
                part.unlink(missing_ok=True)

    def _files(self) -> list[Path]:
        own = [self.path] if self.path.is_file() and self.path.stat().st_size else []
        return own + sorted(self.parts.glob("*.parquet"))

    def _together(self, files: list[Path]) -> pd.DataFrame:
        tables = [self._read(file) for file in files]
        if not tables:
            return pd.DataFrame()
        table = pd.concat(tables, ignore_index=True).drop_duplicates(RUN, ignore_index=True)
        texts = [name for name in TEXTS if name in table]
        table[texts] = table[texts].fillna("")
        return table

    def _read(self, path: Path) -> pd.DataFrame:
        try:
            table = outputs.read(path)
            if RUN not in table:
                raise OutputError(f"{path} is there and is no sweep's table: it would be lost")
            return _plain(table)
        except (ValueError, TypeError) as error:
            raise OutputError(f"{path} is there and is no sweep's table: {error}") from None


def _plain(table: pd.DataFrame) -> pd.DataFrame:
    """Returns the table with all numbers as floats, however a sweep has written them."""
    table = table.reset_index(drop=True)
    # Texts as a list, because pyarrow decodes each when it is first read.
    return pd.DataFrame({n: [*c] if n in TEXTS else _numbers(c) for n, c in table.items()})


def filled(row: Mapping[Any, Any]) -> dict[Any, Any]:
    """Returns the entries of a row that are not empty; other sweeps may have more columns."""
    return {name: cell for name, cell in row.items() if cell != "" and pd.notna(cell)}


def _checksum(row: Mapping[Any, Any]) -> str:
    said = sorted(pair for pair in filled(row).items() if pair[0] != CHECKSUM)
    return hashlib.sha256(json.dumps(said).encode()).hexdigest()[:16]


def _numbers(column: pd.Series) -> pd.Series:
    """Returns a column as floats, NaN where it is empty."""
    words = {"": math.nan, "True": 1.0, "False": 0.0}
    numbers = [words[v] if v in words else math.nan if pd.isna(v) else float(v) for v in column]
    return pd.Series(numbers, dtype=float)


#: Offset of the lock in its file under Windows, where locked bytes cannot be read.
BEYOND = 1 << 20


def _lock(file: IO[str]) -> None:
    """Locks a file for this process, or raises an OSError at once."""
    if sys.platform == "win32":
        import msvcrt  # noqa: PLC0415

        file.seek(BEYOND)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        file.seek(0)
    else:
        import fcntl  # noqa: PLC0415

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
