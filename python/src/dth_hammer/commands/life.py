"""`dth-hammer life`: computes the hours until piston and bit break by fatigue."""

import argparse
from typing import Any

from .. import outputs
from ..study.fatigue import life
from .options import Call, figure, table

CALL = Call(life)
ALSO = (
    table("table of all places"),
    figure("figure to write: wave diagram with the worst place"),
)


def run(options: argparse.Namespace) -> Any:
    """Counts stress cycles, prints the worst place of each section and writes the files."""
    given = CALL.given(options)
    result = life(**given)
    print(result)
    if options.out:
        outputs.write(result.places, options.out)
    if options.plot:
        from ..figures import wave_diagram  # noqa: PLC0415
        from ..simulation.diagram import waves  # noqa: PLC0415

        wave_diagram(waves(given["hammer"]), result).savefig(options.plot)
    return result.places
