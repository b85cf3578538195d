"""`dth-hammer sweep`: simulates a grid of hammers."""

from __future__ import annotations

import argparse

from .. import outputs, quantities
from ..band import reason, with_sides
from ..errors import DomainError
from ..variables import VARIABLES, numbers
from . import common

HELP = "simulate a grid of hammers"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_scene(parser)
    common.add_table(parser, outputs.STORED)
    parser.add_argument(
        "--over",
        action="append",
        required=True,
        metavar="NAME=VALUES",
        help="values as feed_force=3e3,5e3,8e3, or first:last:number as feed_force=1e3:9e3:5",
    )
    parser.add_argument(
        "--scheduler", help="threads, processes, or the address of a Dask scheduler"
    )
    parser.add_argument("--workers", type=int, help="number of workers; one per core if not given")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Runs the grid points that the file does not have yet and prints one row per run."""
    until = quantities.duration(options.until, "--until")
    axes = common.assignments(options.over)
    grid = {n: common.values(VARIABLES.settable(n), text) for n, text in axes.items()}
    common.check_outputs(options.out, kinds=outputs.STORED)
    if options.out and options.units:
        raise DomainError("a sweep's file keeps SI units: give --units without -o")

    from ..sweeping import RESULTS, sweep  # noqa: PLC0415

    displayed = [*grid, "blow_count", "blow_period", "blow_speed", "rop"]
    common.check_units(options.units, {n: VARIABLES[n] for n in [*grid, *RESULTS]})
    table = sweep(
        grid,
        until,
        parameters=common.assignments(options.set),
        preset=options.preset,
        scheduler=options.scheduler,
        workers=options.workers,
        progress=not options.quiet,
        out=options.out,
    )
    attrs = table.attrs
    table = table[[*with_sides(displayed), "error"]]
    table.attrs = attrs
    units = common.own_units(options.units, table)
    print(common.readable(common.in_units(table, units), index=False))
    if not any(name.startswith("rock.specific_energy") for name in grid):
        print(reason(numbers(options.preset, common.assignments(options.set))))
