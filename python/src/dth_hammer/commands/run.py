"""`dth-hammer run`: simulates one hammer over time."""

from __future__ import annotations

import argparse
from contextlib import suppress
from pathlib import Path

from .. import outputs, quantities
from ..band import reason
from ..errors import TooFewBlowsError
from ..run import simulate
from ..summary import readable
from ..variables import STEP, VARIABLES
from . import common

HELP = "simulate one hammer"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_scene(parser)
    common.add_table(parser)
    parser.add_argument(
        "--step", default=f"{STEP:g} s", help="communication step: the interval between two rows"
    )
    parser.add_argument("--pipe", help='outside diameter of the drill pipe, as "76 mm"')
    parser.add_argument("--rotation", help='turns of the bit per time, as "30 1/min"')
    parser.add_argument("--plot", type=Path, help="figure to write")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Simulates, writes, and prints a row per blow."""
    until = quantities.duration(options.until, "--until")
    step = quantities.duration(options.step, "--step")
    common.check_outputs(options.out, options.plot)
    displayed = {v.name: v.unit for v in VARIABLES.of("output", "local")}
    common.check_units(options.units, displayed)
    made = simulate(
        common.assignments(options.set),
        until,
        preset=options.preset,
        step=step,
        progress=not options.quiet,
    )
    if options.out:
        written = common.in_units(made.frame, options.units)
        written.attrs |= {"parameters": dict(made.parameters), "model": made.model}
        outputs.write(written, options.out)
    table = made.blows
    if options.plot:
        made.plot().savefig(options.plot)
    if len(table):
        units = common.own_units(options.units, table)
        print(common.readable(common.in_units(table, units)))
        with suppress(TooFewBlowsError):
            found = made.summary(pipe=options.pipe, rotation=options.rotation)
            print(f"\nfrom {made.time[-1] / 2:g} s on:\n{readable(found)}")
        print(reason(made.parameters))
    else:
        print("no blow")
    if made["stalled"].any():
        print(f"stalled at {made.time[made['stalled']][0]:g} s")
