"""`dth-hammer run`: simulates one hammer over time."""

import argparse
from contextlib import suppress
from pathlib import Path
from typing import Any

from .. import outputs
from ..errors import TooFewBlowsError
from ..scene.band import reason
from ..scene.mesh import errors_in_words
from ..scene.quantities import convert
from ..scene.signals import of_file
from ..scene.variables import VARIABLES
from ..simulation.run import simulate
from . import common
from .options import UNITS, WRITE_ROCK, Call, Written, figure, table

CALL = Call(
    simulate,
    {
        "outputs": "what is printed needs all",
        "control": "a function",
    },
    inputs=Written(
        "--inputs",
        lambda file: of_file(Path(file)),
        type=str,
        help="file (CSV, Parquet, Excel, LAS) with a column time and one for each input",
    ),
)


#: Columns that fit into a line of 80 characters.
PRINTED = ("blow_time", "blow_period", "blow_speed", "blow_energy", "rop")


ALSO = (table("table to write"), figure("figure to write"), UNITS, WRITE_ROCK)


def run(options: argparse.Namespace) -> Any:
    """Simulates, writes files, and prints one row per blow."""
    given = CALL.given(options)
    displayed = {v.name: v.unit for v in VARIABLES.of("output", "local")}
    common.check_units(options.units, displayed)
    made = simulate(**given)
    common.write_rock(options, made.parameters)
    if options.out:
        written = convert(made.frame, options.units)
        written.attrs |= {"parameters": dict(made.parameters), "model": made.model}
        outputs.write(written, options.out)
    if options.plot:
        made.plot().savefig(options.plot)
    if len(made.blows):
        printed = made.blows[[*PRINTED]]
        printed.attrs = made.blows.attrs
        units = common.printed_units(options.units)
        print(common.readable(convert(printed, units, skip_missing=True)))
        with suppress(TooFewBlowsError):
            print(f"\nfrom {made.time[-1] / 2:g} s on:\n{made.readable()}")
        print(reason(made.parameters), *errors_in_words(made.parameters), sep="\n")
        common.print_air(made.parameters)
    else:
        print("no blow")
    if made["stalled"].any():
        print(f"stalled at {made.time[made['stalled']][0]:g} s")
    return {"blows": made.blows, "parameters": made.parameters, "warnings": made.warnings}
