"""`dth-hammer waves`: computes the stresses along piston and bit."""

from __future__ import annotations

import argparse
from dataclasses import replace

from .. import outputs
from ..errors import DomainError
from ..fmu.package import load
from ..fmu.variant import configure
from ..run.diagram import Waves, waves
from ..scene.mesh import ELEMENTS
from ..scene.variables import whole
from . import common
from .options import Call

VARIANT = ".fmu"


CALL = Call(waves, {"times": "instants about an impact that is not known before"})
FILE = Call(load)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds mesh and files."""
    parser.add_argument(
        "--elements",
        type=int,
        nargs=2,
        metavar=("PISTON", "BIT"),
        help="number of elements of each body",
    )
    common.add_files(
        parser,
        table="an .fmu with stress and velocity along that mesh among its outputs, or a table of "
        "the stresses after the last impact",
        figure="figure to write: wave diagram of the last impact",
    )


def run(options: argparse.Namespace) -> None:
    """Writes the requested files and prints the greatest stresses."""
    given = CALL.given(options)
    if options.elements:
        mesh = dict(zip(ELEMENTS, options.elements, strict=True))
        scene = given["hammer"]
        given["hammer"] = replace(scene, parameters=scene.parameters | mesh)
    if options.out is None and options.plot is None:
        raise DomainError("nothing to write: give --plot, -o, or both")
    if options.out is not None:
        outputs.check(options.out, (*outputs.TABLES, VARIANT))
    common.check_outputs(None, options.plot)
    variant = options.out is not None and options.out.suffix == VARIANT
    if variant:
        _write_variant(options, given["hammer"].numbers)
    if variant and options.plot is None:
        return
    record = waves(**given)
    if options.out and not variant:
        outputs.write(record.table(), options.out)
    if options.plot:
        from ..figures import wave_diagram  # noqa: PLC0415

        wave_diagram(record).savefig(options.plot)
    print(_extremes(record))


def _write_variant(options: argparse.Namespace, given: dict[str, float]) -> None:
    mesh = [int(whole(given)[name]) for name in ELEMENTS]
    added = configure(given, options.out, waves=True, **FILE.given(options))
    print(f"{options.out}: {added} more outputs, along {mesh[0]} and {mesh[1]} elements")


def _extremes(record: Waves) -> str:
    lines = [f"impact at {record.notes['impact']:.6f} s"]
    for name, bar in (("piston", record.piston), ("bit", record.bit)):
        low, high = bar.stress.min() * 1e-6, bar.stress.max() * 1e-6
        lines.append(f"{name}: {low:.0f} to {high:.0f} MPa")
    return "\n".join(lines)
