"""`dth-hammer steady`: what a hammer does in the long run, with errors."""

from __future__ import annotations

import argparse

import pandas as pd

from .. import outputs
from ..fixed import Fixed
from . import common

HELP = "compute the long-run response of a hammer, periodic or not, with errors"


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it takes."""
    common.add_hammer(parser)
    parser.add_argument(
        "--error",
        type=float,
        default=0.01,
        help="relative standard error of the rate of penetration",
    )
    parser.add_argument("--blows", type=int, default=20_000, help="most blows to simulate")
    common.add_table(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Seeks the response, writes and prints means, errors and spreads."""
    common.check_outputs(options.out)

    from ..longrun import MEANS, steady, unit  # noqa: PLC0415

    displayed = pd.DataFrame(columns=pd.Index(MEANS), dtype=float)
    displayed.attrs = {"units": Fixed({name: unit(name) for name in MEANS})}
    common.in_units(displayed, options.units)
    found = steady(
        common.assignments(options.set),
        preset=options.preset,
        error=options.error,
        blows=options.blows,
        progress=not options.quiet,
    )
    displayed = pd.concat([displayed, found.outputs[["mean", "error", "spread"]].T])
    displayed.attrs = {"units": Fixed({name: unit(name) for name in MEANS})}
    converted = common.in_units(displayed, options.units)
    table = converted.T
    table["unit"] = [converted.attrs["units"][name] for name in table.index]
    if options.out:
        outputs.write(table, options.out)
    reached = "" if found.reached else f", the error of {options.error:g} was not reached"
    print(f"{found.kind}, {found.blows} blows{reached}")
    if found.blows:
        print(common.readable(table))
