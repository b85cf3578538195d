"""`dth-hammer steady`: computes the long-run means of a hammer, with errors."""

from __future__ import annotations

import argparse

import pandas as pd

from .. import _native, outputs
from . import common

HELP = "compute the long-run response of a hammer, periodic or not, with errors"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    wanted = _native.wanted()
    parser.add_argument(
        "--error",
        type=float,
        default=wanted["error"],
        help="relative standard error of the rate of penetration",
    )
    blows = int(wanted["blows"])
    parser.add_argument(
        "--blows", type=int, default=blows, help="largest number of blows to simulate"
    )
    common.add_table(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Computes the long-run response, then writes and prints means, errors and spreads."""
    common.check_outputs(options.out)

    from ..longrun import MEANS, steady, unit  # noqa: PLC0415

    units = {name: unit(name) for name in MEANS}
    common.by_name(pd.DataFrame(index=pd.Index(MEANS)), units, options.units)
    found = steady(
        common.assignments(options.set),
        preset=options.preset,
        error=options.error,
        blows=options.blows,
        progress=not options.quiet,
    )
    table = common.by_name(found.outputs.drop(columns="unit"), units, options.units)
    if options.out:
        outputs.write(table, options.out)
    reached = "" if found.reached else f", the error of {options.error:g} was not reached"
    print(f"{found.kind}, {found.blows} blows{reached}")
    if found.blows:
        print(found.rate)
        print(common.readable(table))
