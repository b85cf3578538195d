"""Options and output that several subcommands share."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import Any

from .. import tables
from ..errors import DomainError
from ..frames import np, pd
from ..scene import rocks
from ..scene.band import reason, with_sides
from ..scene.quantities import Fixed, Units, alike, convert, with_units
from ..scene.scene import Scene
from ..scene.variables import VARIABLES, Variable, whole
from ..study.cases import MODEL
from ..study.store import RUN
from .options import assignments

LONGEST = 1_000_000


def many(options: argparse.Namespace) -> Any:
    """Returns the hammers that ``--over`` or ``--rows`` gives; an empty mapping if neither does."""
    if options.over and options.rows:
        raise DomainError("give --over or --rows, not both")
    if options.units and options.out and (options.over or options.rows):
        raise DomainError("a file of many hammers keeps SI units: give --units without -o")
    if options.rows:
        settable = [v.name for v in VARIABLES.of("parameter", "input")]
        table = tables.rows_of(options.rows, settable)
        if {RUN, MODEL} <= {*table}:
            # A table from a sweep: its parameters are used, its results are not.
            table = table[[name for name in table if name in settable]]
        return table
    axes = assignments(options.over)
    return {name: values(VARIABLES.settable(name), text) for name, text in axes.items()}


def print_many(
    options: argparse.Namespace, table: pd.DataFrame, names: Sequence[str], base: Scene
) -> None:
    """Prints columns of many hammers, and the reason for the ranges of their rates."""
    refused = ["error"] if (table["error"] != "").any() else []
    printed = table[[*with_sides(names), *refused]]
    printed.attrs = table.attrs
    print(readable(convert(printed, printed_units(options.units), skip_missing=True), index=False))
    if not any(name.startswith("rock.specific_energy") for name in table.attrs["swept"]):
        print(reason(base.numbers))


def print_air(parameters: Mapping[str, float]) -> None:
    """Prints the air's pressure both ways: absolute, as in the scene, and as a gauge shows it."""
    given = whole(parameters)
    if VARIABLES["drive.source"].text(given["drive.source"]) == "Air":
        supply, exhaust = given["supply_pressure"], given["exhaust_pressure"]
        absolute, gauge = (f"{1e-5 * x:.4g} bar" for x in (supply, supply - exhaust))
        print(f"supply_pressure, {absolute}, is absolute: {gauge} over the exhaust's")


def write_rock(options: argparse.Namespace, parameters: Mapping[str, float]) -> None:
    """Writes the rock of a hammer to a file, if the user gave one."""
    if options.write_rock:
        rocks.write(options.write_rock, parameters)


def values(variable: Variable, text: str) -> list[Any]:
    """Parses a list ``a,b,c`` or a range ``first:last:count``; each value may have a unit."""
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


def by_name(table: pd.DataFrame, units: dict[str, str], requested: Sequence[Units]) -> pd.DataFrame:
    """Returns a table with one quantity per row and its unit in the last column."""
    wide = table.T.astype(float)
    wide.attrs = {"units": Fixed(units)}
    converted = convert(wide, requested)
    found = converted.T
    found["unit"] = [converted.attrs["units"][name] for name in found.index]
    return found


def printed_units(units: Sequence[Units]) -> list[Units]:
    """Returns the units to print in; those of the trade if the user chose no system."""
    return [*([] if any(isinstance(each, str) for each in units) else ["metric"]), *units]


def check_units(requested: Sequence[Units], known: dict[str, str]) -> None:
    """Raises an error for a unit of a column that is not in the table."""
    displayed = pd.DataFrame({name: [0.0] for name in known})
    displayed.attrs = {"units": known}
    convert(displayed, requested)


def readable(table: pd.DataFrame, *, index: bool = True) -> str:
    """Returns the table as text, with the units in the headings."""
    displayed = with_units(table)
    displayed.columns.name = displayed.index.name if index else None
    displayed.index.name = None
    return str(displayed.to_string(index=index, float_format="{:.5g}".format))
