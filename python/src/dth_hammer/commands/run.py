"""`dth-hammer run`: one hammer over time."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs, quantities
from ..package import load
from ..run import blows, simulate
from . import common

HELP = "simulate one hammer"


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it takes."""
    common.add_scene(parser)
    common.add_table(parser)
    parser.add_argument("--step", help="communication step: how often outputs are read")
    parser.add_argument("--plot", type=Path, help="figure of the run to write")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Simulates, writes, and prints a row per blow."""
    package = load(options.fmu)
    until = quantities.duration(options.until or package.stop, "--until")
    step = quantities.duration(options.step or package.step, "--step")
    common.check_outputs(options.out, options.plot)
    shown = {v.name: v for v in package.variables.of("output", "local")}
    common.check_units(options.units, shown)
    frame = simulate(
        common.assignments(options.set),
        until,
        preset=options.preset,
        step=step,
        fmu=package,
        progress=not options.quiet,
    )
    if options.out:
        outputs.write(common.in_units(frame, options.units), options.out)
    table = blows(frame)
    if options.plot:
        from ..figures import overview  # noqa: PLC0415

        overview(frame).savefig(options.plot)
    if len(table):
        units = [u for u in options.units if "=" not in u or u.split("=")[0].strip() in table]
        print(common.readable(common.in_units(table, units)))
    else:
        print("no blow")
    if frame["stalled"].any():
        print(f"stalled at {frame.index[frame['stalled']][0]:g} s")
