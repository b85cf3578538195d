"""`dth-hammer life`: computes the hours until piston and bit break by fatigue."""

from __future__ import annotations

import argparse
from functools import partial

from .. import outputs
from ..study.fatigue import life
from . import common
from .options import Call

CALL = Call(life)


arguments = partial(
    common.add_files,
    table="table of all places",
    figure="figure to write: wave diagram with the worst place",
)


def run(options: argparse.Namespace) -> None:
    """Counts stress cycles, prints each section's worst place and writes the requested files."""
    common.check_outputs(options.out, options.plot)
    given = CALL.given(options)
    found = life(**given)
    print(found)
    if options.out:
        outputs.write(found.places, options.out)
    if options.plot:
        from ..figures import wave_diagram  # noqa: PLC0415
        from ..run.diagram import waves  # noqa: PLC0415

        wave_diagram(waves(given["hammer"]), found).savefig(options.plot)
