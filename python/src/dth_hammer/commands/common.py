"""Options and output that several subcommands share."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from .. import outputs
from ..errors import DomainError
from ..fixed import Fixed
from ..scene import rocks
from ..scene.band import reason, with_sides
from ..scene.quantities import alike, convert, with_units
from ..scene.scene import Scene
from ..scene.variables import VARIABLES, Variable
from ..study.cases import MODEL
from ..study.store import RUN
from .options import assignments

#: Most values that a range may stand for.
LONGEST = 1_000_000


def many(options: argparse.Namespace) -> Any:
    """The hammers of these options; none if none are given."""
    if options.over and options.rows:
        raise DomainError("give --over or --rows, not both")
    if options.units and options.out and (options.over or options.rows):
        raise DomainError("a file of many hammers keeps SI units: give --units without -o")
    if options.rows:
        table = outputs.read(options.rows)
        if {RUN, MODEL} <= {*table}:
            # A sweep's own file: what it was of, without what it found.
            settable = {v.name for v in VARIABLES.of("parameter", "input")}
            table = table[[name for name in table if name in settable]]
        return table
    axes = assignments(options.over)
    return {name: values(VARIABLES.settable(name), text) for name, text in axes.items()}


def tell_many(
    options: argparse.Namespace, table: pd.DataFrame, names: Sequence[str], base: Scene
) -> None:
    """Prints columns of many hammers, and why their rates have ranges."""
    refused = ["error"] if (table["error"] != "").any() else []
    printed = table[[*with_sides(names), *refused]]
    printed.attrs = table.attrs
    print(readable(in_units(printed, displayed_units(options.units, printed)), index=False))
    if not any(name.startswith("rock.specific_energy") for name in table.attrs["swept"]):
        print(reason(base.numbers))


def keep_rock(options: argparse.Namespace, parameters: Mapping[str, float]) -> None:
    """Writes the rock of a hammer, if that is asked for."""
    if options.write_rock:
        rocks.write(options.write_rock, parameters)


def values(variable: Variable, text: str) -> list[Any]:
    """Parses a list ``a,b,c`` or a range ``first:last:count``; each value may carry a unit."""
    if ":" not in text:
        return [part.strip() for part in text.split(",")]
    parts = text.split(":")
    refusal = DomainError(
        f"{text!r} is not FIRST:LAST:COUNT with a COUNT of 1 to {LONGEST}, as 1e3:9e3:5"
    )
    try:
        first, last = alike(parts[:2], variable.name)
        count = int(parts[2])
    except (IndexError, ValueError):
        raise refusal from None
    if len(parts) != 3 or not 1 <= count <= LONGEST:
        raise refusal
    return [float(x) for x in np.linspace(variable.number(first), variable.number(last), count)]


def in_units(table: pd.DataFrame, texts: Sequence[str]) -> pd.DataFrame:
    """The table in the requested units."""
    systems = [text for text in texts if "=" not in text]
    for system in systems:
        table = convert(table, system)
    return convert(table, assignments([text for text in texts if "=" in text]))


def by_name(table: pd.DataFrame, units: dict[str, str], texts: Sequence[str]) -> pd.DataFrame:
    """Returns a table with a quantity per row, in the requested units, named in its last column."""
    wide = table.T.astype(float)
    wide.attrs = {"units": Fixed(units)}
    converted = in_units(wide, texts)
    found = converted.T
    found["unit"] = [converted.attrs["units"][name] for name in found.index]
    return found


def systems(texts: Sequence[str]) -> list[Any]:
    """The requested units as `report` takes them, metric if no system is named."""
    named = assignments([text for text in texts if "=" in text])
    return [*([text for text in texts if "=" not in text] or ["metric"]), named]


def displayed_units(texts: Sequence[str], table: pd.DataFrame) -> list[str]:
    """The units of a printed table: those of the trade if no system is asked for."""
    systems_ = [] if any("=" not in text for text in texts) else ["metric"]
    return own_units([*systems_, *texts], table)


def own_units(texts: Sequence[str], table: pd.DataFrame) -> list[str]:
    """Returns the requested units that apply to a table's columns, a rate's to its range too."""
    chosen = []
    for text in texts:
        name, equals, unit = (part.strip() for part in text.partition("="))
        if equals:
            names = [*with_sides([name]), f"{name}_error"]
            chosen += [f"{column}={unit}" for column in names if column in table]
        else:
            chosen.append(text)
    return chosen


def check_units(texts: Sequence[str], known: dict[str, str]) -> None:
    """Raises if units are given for columns that the table will not have, by their SI units."""
    displayed = pd.DataFrame({name: [0.0] for name in known})
    displayed.attrs = {"units": known}
    in_units(displayed, texts)


def readable(table: pd.DataFrame, *, index: bool = True) -> str:
    """The table as text, columns with their units in the heading."""
    displayed = with_units(table)
    displayed.columns.name = displayed.index.name if index else None
    displayed.index.name = None
    return str(displayed.to_string(index=index, float_format="{:.5g}".format))
