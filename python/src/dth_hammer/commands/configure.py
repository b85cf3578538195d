"""`dth-hammer configure`: writes an FMU that starts with your parameters, for any host."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs
from ..fmu.package import load
from ..fmu.variant import configure
from ..variables import PRESETS
from . import common

HELP = "write an FMU that starts with your parameters, for hosts that cannot set them"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    common.add_fmu(parser)
    parser.add_argument(
        "--waves",
        action="store_true",
        help="add stresses and velocities along its mesh to the outputs",
    )
    parser.add_argument(
        "--arrays",
        action="store_true",
        help="with --fmi 3: add those, and the blows of a step, as arrays",
    )
    parser.add_argument("-o", "--out", type=Path, required=True, help=".fmu to write")


def run(options: argparse.Namespace) -> None:
    """Writes the FMU."""
    outputs.check(options.out, (".fmu",))
    given = common.assignments(options.set)
    preset, package = options.preset, load(options.fmu, fmi=options.fmi)
    added = configure(
        options.out,
        given,
        preset=preset,
        waves=options.waves,
        arrays=options.arrays,
        fmu=package,
    )
    started = {*given, *(PRESETS[preset].values if preset else ())}
    more = f", {added} more outputs" if added else ""
    print(f"{options.out}: {len(started)} start values{more}")
