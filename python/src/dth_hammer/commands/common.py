"""What several subcommands take and do."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .. import outputs
from ..errors import DomainError
from ..quantities import SYSTEMS, convert
from ..run import unit
from ..variables import Variable

#: Most values that a range may stand for.
LONGEST = 1_000_000


def add_fmu(parser: argparse.ArgumentParser) -> None:
    """From which FMU a file is made."""
    parser.add_argument("--fmu", type=Path, help="FMU to take instead of the one found")
    parser.add_argument("--fmi", type=int, choices=(2, 3), default=2, help="version of FMI")


def add_hammer(parser: argparse.ArgumentParser) -> None:
    """Which hammer."""
    parser.add_argument("--preset", help="parameter set to start from: see `dth-hammer info`")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help='a parameter, for instance rock.stiffness=2e9 or "piston.length=7 in"',
    )


def add_scene(parser: argparse.ArgumentParser) -> None:
    """Which hammer, and for how long."""
    add_hammer(parser)
    parser.add_argument("--until", help='duration, for instance 1 or "500 ms"')


def add_table(parser: argparse.ArgumentParser) -> None:
    """Which table to write and show."""
    parser.add_argument("-o", "--out", type=Path, help="table to write: .parquet or .csv")
    add_units(parser)


def add_units(parser: argparse.ArgumentParser) -> None:
    """Which units to show."""
    parser.add_argument(
        "--units",
        action="append",
        default=[],
        metavar="UNITS",
        help=f"units to show and write: {', '.join(SYSTEMS)}, or NAME=UNIT, as rop=m/h",
    )


def assignments(texts: Sequence[str]) -> dict[str, Any]:
    """Names and values of several ``NAME=VALUE``."""
    pairs: dict[str, Any] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name:
            raise DomainError(f"{text!r} is not NAME=VALUE")
        if name in pairs:
            raise DomainError(f"{name} is given twice")
        pairs[name] = value
    return pairs


def values(variable: Variable, text: str) -> list[Any]:
    """A list ``a,b,c`` or a range ``first:last:count``, each with a unit if one likes."""
    if ":" not in text:
        return [part.strip() for part in text.split(",")]
    parts = text.split(":")
    refusal = DomainError(
        f"{text!r} is not FIRST:LAST:COUNT with a COUNT of 1 to {LONGEST}, as 1e3:9e3:5"
    )
    try:
        first, last, count = parts[0], parts[1], int(parts[2])
    except (IndexError, ValueError):
        raise refusal from None
    if len(parts) != 3 or not 1 <= count <= LONGEST:
        raise refusal
    return [float(x) for x in np.linspace(variable.number(first), variable.number(last), count)]


def in_units(table: pd.DataFrame, texts: Sequence[str]) -> pd.DataFrame:
    """The table in the units asked for."""
    systems = [text for text in texts if "=" not in text]
    for system in systems:
        table = convert(table, system)
    return convert(table, assignments([text for text in texts if "=" in text]))


def own_units(texts: Sequence[str], table: pd.DataFrame) -> list[str]:
    """Those of the units asked for that a table has a column for."""
    return [u for u in texts if "=" not in u or u.split("=")[0].strip() in table]


def check_units(texts: Sequence[str], known: dict[str, Variable]) -> None:
    """Refuses units that the columns to come will not have."""
    displayed = pd.DataFrame({name: [0.0] for name in known})
    displayed.attrs = {"units": {name: v.unit for name, v in known.items()}}
    in_units(displayed, texts)


def check_outputs(table: Path | None, figure: Path | None = None) -> None:
    """Looks at the files to be written, before any work is done."""
    if table is not None:
        outputs.check(table)
    if figure is not None:
        outputs.check_figure(figure)


def readable(table: pd.DataFrame, *, index: bool = True) -> str:
    """The table as text, columns with their units in the heading."""
    displayed = table.rename_axis(index=None)
    name = table.index.name if index else None
    displayed.columns = pd.Index([heading(table, str(c)) for c in table], name=name)
    return displayed.to_string(index=index, float_format="{:.6g}".format)


def heading(table: pd.DataFrame, column: str) -> str:
    """A column's name and unit; a pure number has none."""
    named = unit(table, column)
    return column if named in ("", "1") else f"{column} [{named}]"
