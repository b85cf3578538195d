"""`dth-hammer system`: writes a hammer and its drive as one SSP file."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs
from ..fmu.system import STEP, write_system
from . import common

HELP = "write an .ssp of the hammer and its drive, connected by name"
NEEDS = ("fmpy",)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_scene(parser)
    common.add_fmu(parser)
    parser.add_argument(
        "--partner",
        action="append",
        required=True,
        metavar="NAME=FILE",
        help="another FMU and its name in the system, for instance drive=drive.fmu",
    )
    parser.add_argument("--step", default=STEP, help='communication step, in s or as "20 us"')
    parser.add_argument("-o", "--out", type=Path, required=True, help=".ssp to write")


def run(options: argparse.Namespace) -> None:
    """Writes the system."""
    outputs.check(options.out, (".ssp",))
    connected = write_system(
        options.out,
        common.assignments(options.partner),
        common.assignments(options.set),
        preset=options.preset,
        step=options.step,
        until=options.until,
        fmu=options.fmu,
        fmi=options.fmi,
    )
    for (giver, output), (taker, taken) in connected:
        print(f"{giver}.{output} -> {taker}.{taken}")
