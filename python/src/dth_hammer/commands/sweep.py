"""`dth-hammer sweep`: simulates a grid of hammers."""

from __future__ import annotations

import argparse

from .. import outputs, quantities
from ..errors import DomainError
from ..variables import VARIABLES
from . import common

HELP = "simulate a grid of hammers"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_scene(parser)
    common.add_table(parser, outputs.STORED)
    common.add_many(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Runs the grid points that the file does not have yet and prints one row per run."""
    until = quantities.duration(options.until, "--until")
    grid = common.many(options)
    if not len(grid):
        raise DomainError("give the hammers: --over feed_force=3e3,5e3 or --rows FILE")
    common.check_outputs(options.out, kinds=outputs.STORED)

    from ..sweeping import RESULTS, sweep  # noqa: PLC0415

    common.check_units(options.units, {n: VARIABLES[n].unit for n in [*grid, *RESULTS]})
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
    common.tell_many(options, table, [*grid, "blow_count", "blow_period", "blow_speed", "rop"])
