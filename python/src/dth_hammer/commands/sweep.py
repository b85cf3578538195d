"""`dth-hammer sweep`: simulates a grid of hammers."""

import argparse
from typing import Any

from ..errors import DomainError
from ..scene.variables import UNTIL, VARIABLES
from ..study.sweeping import RESULTS, sweep
from . import common
from .options import MANY, SHARED, UNITS, Call, Written

CALL = Call(
    sweep,
    {
        "hammers": "--over or --rows",
        "cases": "other hammers",
        "control": "a function",
        "version": "of functions",
    },
    until=Written(
        "--until",
        SHARED["until"].read,
        help=f'duration of a run in s, or as "500 ms" (default: {UNTIL:g})',
        required=False,
        default=UNTIL,
    ),
)


ALSO = (*MANY, UNITS)


def run(options: argparse.Namespace) -> Any:
    """Simulates the grid points that are not in the file yet, and prints one row per run."""
    given = CALL.given(options)
    grid = common.many(options)
    if not len(grid):
        raise DomainError("give the hammers: --over feed_force=3e3,5e3 or --rows FILE")
    outputs = options.outputs or RESULTS
    common.check_units(options.units, {n: VARIABLES[n].unit for n in [*grid, *outputs]})
    columns = options.outputs or ["blow_speed", "rop"]
    table = sweep(grid, **given)
    common.print_many(options, table, [*grid, *columns], given["base"])
    return table
