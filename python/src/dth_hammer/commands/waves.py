"""`dth-hammer waves`: computes the stresses along piston and bit."""

import argparse
from dataclasses import replace

from .. import outputs
from ..errors import DomainError
from ..scene.mesh import ELEMENTS
from ..simulation.diagram import waves
from .options import Call, Written, figure, table

CALL = Call(waves, {"times": "instants about an impact that is not known before"})


ALSO = (
    Written(
        "--elements",
        type=int,
        nargs=2,
        metavar=("PISTON", "BIT"),
        help="number of elements of each body",
    ),
    table("table of the stresses after the last impact"),
    figure("figure to write: wave diagram of the last impact"),
)


def run(options: argparse.Namespace) -> None:
    """Writes the requested files and prints the largest stresses."""
    given = CALL.given(options)
    if options.elements:
        mesh = dict(zip(ELEMENTS, options.elements, strict=True))
        scene = given["hammer"]
        given["hammer"] = replace(scene, parameters=scene.parameters | mesh)
    if options.out is None and options.plot is None:
        raise DomainError("nothing to write: give --plot, -o, or both")
    record = waves(**given)
    if options.out:
        outputs.write(record.to_frame(), options.out)
    if options.plot:
        record.plot().savefig(options.plot)
    print(*record.in_words(), sep="\n")
