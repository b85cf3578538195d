"""`dth-hammer life`: computes the hours until piston and bit break by fatigue."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs
from ..fatigue import SNCurve, life
from . import common

HELP = "compute the fatigue life of piston and bit from an S-N line"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    common.add_curve(parser, required=True)
    parser.add_argument("-o", "--out", type=Path, help=f"table of all places: {outputs.either()}")
    parser.add_argument(
        "--plot", type=Path, help="figure to write: wave diagram with the worst place"
    )


def run(options: argparse.Namespace) -> None:
    """Counts stress cycles, prints each section's worst place and writes the requested files."""
    common.check_outputs(options.out, options.plot)
    given = common.assignments(options.set)
    found = life(SNCurve.read(options.sn), given, preset=options.preset)
    print(found)
    if options.out:
        outputs.write(found.places, options.out)
    if options.plot:
        from ..diagram import waves  # noqa: PLC0415
        from ..figures import wave_diagram  # noqa: PLC0415

        wave_diagram(waves(given, preset=options.preset), found).savefig(options.plot)
