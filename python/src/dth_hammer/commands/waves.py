"""`dth-hammer waves`: computes the stresses along piston and bit."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs, quantities
from ..diagram import Waves, waves
from ..errors import DomainError
from ..fmu.variant import configure
from ..mesh import ELEMENTS
from ..variables import numbers, whole
from . import common

HELP = "compute stresses along piston and bit, or write an FMU that does"
VARIANT = ".fmu"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_scene(parser)
    common.add_fmu(parser)
    parser.add_argument(
        "--elements",
        type=int,
        nargs=2,
        metavar=("PISTON", "BIT"),
        help="number of elements of each body",
    )
    parser.add_argument(
        "-o",
        "--out",
        type=Path,
        help="an .fmu with stress and velocity along that mesh among its outputs, or a table "
        f"of the stresses after the last impact: {outputs.either()}",
    )
    parser.add_argument(
        "--plot", type=Path, help="figure to write: wave diagram of the last impact"
    )


def run(options: argparse.Namespace) -> None:
    """Writes the requested files and prints the greatest stresses."""
    given = common.assignments(options.set)
    if options.elements:
        given |= dict(zip(ELEMENTS, options.elements, strict=True))
    until = quantities.duration(options.until, "--until")
    if options.out is None and options.plot is None:
        raise DomainError("nothing to write: give --plot, -o, or both")
    if options.out is not None:
        outputs.check(options.out, (*outputs.TABLES, VARIANT))
    common.check_outputs(None, options.plot)
    variant = options.out is not None and options.out.suffix == VARIANT
    if variant:
        _write_variant(options, numbers(options.preset, given))
    if variant and options.plot is None:
        return
    record = waves(given, until, preset=options.preset)
    if options.out and not variant:
        outputs.write(record.table(), options.out)
    if options.plot:
        from ..figures import wave_diagram  # noqa: PLC0415

        wave_diagram(record).savefig(options.plot)
    print(_extremes(record))


def _write_variant(options: argparse.Namespace, given: dict[str, float]) -> None:
    mesh = [int(whole(given)[name]) for name in ELEMENTS]
    added = configure(options.out, given, waves=True, fmu=options.fmu, fmi=options.fmi)
    print(f"{options.out}: {added} more outputs, along {mesh[0]} and {mesh[1]} elements")


def _extremes(record: Waves) -> str:
    lines = [f"impact at {record.notes['impact']:.6f} s"]
    for name, bar in (("piston", record.piston), ("bit", record.bit)):
        low, high = bar.stress.min() * 1e-6, bar.stress.max() * 1e-6
        lines.append(f"{name}: {low:.0f} to {high:.0f} MPa")
    return "\n".join(lines)
