"""`dth-hammer steady`: computes the long-run means of a hammer, or of many, with errors."""

from __future__ import annotations

import argparse

import pandas as pd

from .. import _native, outputs
from ..variables import VARIABLES
from . import common

HELP = "compute the long-run response of hammers, periodic or not, with errors"


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
    common.add_many(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Computes the long-run responses, then writes and prints means and errors."""
    from ..longrun import MEANS, unit  # noqa: PLC0415
    from ..response import steady  # noqa: PLC0415

    grid, given = common.many(options), common.assignments(options.set)
    common.check_outputs(options.out, kinds=outputs.STORED if len(grid) else outputs.TABLES)
    units = {name: unit(name) for name in MEANS}
    asked = {"preset": options.preset, "error": options.error, "blows": options.blows}
    asked["progress"] = not options.quiet
    if len(grid):
        common.check_units(options.units, units | {n: VARIABLES.settable(n).unit for n in grid})
        shared = {name: value for name, value in given.items() if name not in grid}
        rows = grid.assign(**shared) if isinstance(grid, pd.DataFrame) else grid | shared
        by = {"scheduler": options.scheduler, "workers": options.workers, "out": options.out}
        table = steady(rows, **asked, **by)
        read = ["rop", "rop_error", "blow_frequency", "blow_energy"]
        common.tell_many(options, table, [*grid, "kind", "blows", *read])
        return
    common.by_name(pd.DataFrame(index=pd.Index(MEANS)), units, options.units)
    found = steady(given, **asked)
    table = common.by_name(found.outputs.drop(columns="unit"), units, options.units)
    if options.out:
        outputs.write(table, options.out)
    reached = "" if found.reached else f", the error of {options.error:g} was not reached"
    print(f"{found.kind}, {found.blows} blows{reached}")
    if found.blows:
        print(found.rate)
        print(common.readable(table))
