"""`dth-hammer log`: the rock's specific energy over the depth of a hole, from a drilling log."""

import argparse
from pathlib import Path
from typing import Any

from .. import outputs
from ..scene.quantities import convert
from ..study.drilling import specific_energy
from . import common
from .options import A_HAMMER, UNITS, Call, Written, assignments, hammer_of, table

CALL = Call(
    specific_energy,
    log=Written("log", type=Path),
    sheet=Written("--sheet", hammer_of, help=A_HAMMER, type=str),
    unit=Written(
        "--unit",
        assignments,
        help="unit of a column whose heading has none, rop=m/h; repeatable",
        action="append",
        metavar="NAME=UNIT",
    ),
    column=Written(
        "--column",
        assignments,
        help="the heading to be taken as depth, rop, pressure, feed or frequency; repeatable",
        action="append",
        metavar="NAME=HEADING",
    ),
)


ALSO = (table("table to write"), UNITS)


def run(options: argparse.Namespace) -> Any:
    """Prints and writes the table, in metric units unless the user chose others."""
    found = specific_energy(**CALL.given(options))
    displayed = convert(found, options.units or "metric")
    if options.out:
        outputs.write(displayed, options.out, index=False)
    print(common.readable(displayed, index=False))
    print(*found.attrs["said"], sep="\n")
    return found
