"""`dth-hammer report`: simulates a hammer and writes one self-contained HTML page about it."""

import argparse
from pathlib import Path

from .. import outputs
from ..scene.variables import VARIABLES
from . import common
from .options import SN, UNITS, WRITE_ROCK, Call, Written

NEEDS = ("matplotlib",)
OUT = "page to write; the hammer's name with .html if not given"


def call() -> Call:
    """Returns the function with its options; it needs matplotlib."""
    from ..figures.page import report  # noqa: PLC0415

    out = Written("-o --out", type=Path, required=False, help=OUT)
    return Call(report, {"units": "--units, as of other commands"}, out=out, curve=SN)


ALSO = (UNITS, WRITE_ROCK)


def run(options: argparse.Namespace) -> None:
    """Reads the hammer, runs it and writes the page."""
    given = call().given(options)
    common.write_rock(options, given["hammer"].numbers)
    path_out = options.out or Path(options.hammer or "reference").with_suffix(".html")
    given["out"] = outputs.check(path_out, (".html", ".htm"))
    common.check_units(options.units, {v.name: v.unit for v in VARIABLES.of("output", "local")})
    path = call().function(**given, units=common.printed_units(options.units))
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB")
