"""`dth-hammer log`: the rock's specific energy over the depth of a hole, from a drilling log."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs
from ..scene.datasheet import from_datasheet
from ..study.drilling import specific_energy
from . import common
from .options import Call, Written, assignments, listed

SHEET = "the hammer's datasheet: od=124mm,pressure=24bar,power=31.7kW,hole=140mm"
CALL = Call(
    specific_energy,
    log=Written("log", type=Path),
    sheet=Written(
        "--sheet", lambda text: from_datasheet(**assignments(listed(text))), help=SHEET, type=str
    ),
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the file and the units."""
    common.add_files(parser, table="table to write", units=True)


def run(options: argparse.Namespace) -> None:
    """Prints and writes the table, in metric units unless others are asked for."""
    common.check_outputs(options.out)
    table = common.in_units(specific_energy(**CALL.given(options)), options.units or ["metric"])
    if options.out:
        outputs.write(table, options.out, index=False)
    print(common.readable(table, index=False))
