"""`dth-hammer datasheet`: finds the hammer that a datasheet describes."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .. import outputs
from ..datasheet import UNITS, from_datasheet
from ..errors import UnknownNameError
from . import common

HELP = "find the hammer that a datasheet describes: energy, frequency, pressure, bore, stroke"
#: What may be given besides.
OTHERS = ("feed_force", "specific_energy")


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it takes."""
    parser.add_argument(
        "given",
        nargs="+",
        metavar="NAME=VALUE",
        help=f'what is known, as "blow_energy=350 ft.lbf": {", ".join((*UNITS, *OTHERS))}',
    )
    parser.add_argument("--preset", help="rock to drill: see `dth-hammer info`")
    parser.add_argument("-o", "--out", type=Path, help="scene to write: .json, for run and report")


def run(options: argparse.Namespace) -> None:
    """Solves, prints, writes a scene."""
    out = outputs.check(options.out, (".json",)) if options.out else None
    given = common.assignments(options.given)
    for name in given:
        if name not in (*UNITS, *OTHERS):
            raise UnknownNameError("number of a datasheet", name, (*UNITS, *OTHERS))
    sheet = from_datasheet(**given, preset=options.preset)
    print(sheet)
    if out:
        scene = {"description": "; ".join(options.given), "start_values": dict(sheet.parameters)}
        out.write_text(json.dumps(scene, indent=2) + "\n", encoding="utf-8")
