"""`dth-hammer report`: simulates a scene and writes one self-contained HTML page about it."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from .. import outputs
from ..scene.scene import Scene
from ..scene.variables import VARIABLES
from . import common
from .options import SN, listed

NEEDS = ("matplotlib",)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    parser.add_argument("scene", type=Path, help="JSON: preset, start_values, inputs, until")
    parser.add_argument(
        "-o", "--out", type=Path, help="page to write; the scene's name with .html if not given"
    )
    common.add_units(parser)
    common.add_rock(parser, read=True)
    parser.add_argument(
        "--gradient",
        metavar="NAME,...",
        type=listed,
        default=[],
        help="parameters by which the page tells trends and exact slopes of the long-run response",
    )
    parser.add_argument("--sn", help=SN.help, **SN.keywords)


def run(options: argparse.Namespace) -> None:
    """Reads the scene, runs it and writes the page."""
    scene = Scene.read(options.scene)
    scene = replace(scene, rock=options.rock)
    common.keep_rock(options, scene.numbers)
    out = outputs.check(options.out or options.scene.with_suffix(".html"), (".html", ".htm"))
    common.check_units(options.units, {v.name: v.unit for v in VARIABLES.of("output", "local")})

    from ..figures.page import report  # noqa: PLC0415

    units = common.systems(options.units)
    curve = SN.read(options.sn) if options.sn else None
    path = report(scene, out, units=units, gradient=options.gradient, curve=curve)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB")
