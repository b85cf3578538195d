"""`dth-hammer calibrate`: estimates parameters, with errors, from measured means."""

import argparse
from collections.abc import Sequence
from typing import Any

from .. import outputs
from ..scene.variables import VARIABLES
from ..study.calibration import calibrate
from . import common
from .options import FREE, UNITS, WRITE_ROCK, Call, Written, assignments, bounds, table

NEEDS = ("scipy",)


def measured(texts: Sequence[str]) -> Any:
    """Reads a value and its error, or several values, by name; a file is passed on."""
    if len(texts) == 1 and "=" not in texts[0]:
        return texts[0]
    return {
        name: tuple(text.split(":")) if ":" in text else text.split(",")
        for name, text in assignments(texts).items()
    }


def free(texts: Sequence[str]) -> dict[str, Any]:
    """Reads bounds by name, None for a name without bounds."""
    alone = dict.fromkeys(text.strip() for text in texts if "=" not in text)
    return alone | bounds([text for text in texts if "=" in text])


CALL = Call(
    calibrate,
    {"records": "samples over time: a script reads and aligns them"},
    measured=Written(
        "",
        measured,
        help='a mean and its standard error, "rop=18 m/h:0.5 m/h", or three or more values with '
        "commas; repeatable; or a file with a column each",
        action="append",
        metavar="NAME=VALUE:ERROR",
    ),
    free=Written(
        "--free",
        free,
        help=f"{FREE}, or a name alone for a factor of three either way",
        action="append",
        metavar="NAME=LOW:HIGH",
    ),
)


ALSO = (table("table to write"), UNITS, WRITE_ROCK)


def run(options: argparse.Namespace) -> Any:
    """Fits, writes the parameters, and prints them with measured and fitted values."""
    given = CALL.given(options)
    units = {name: VARIABLES.settable(name).unit for name in given["free"]}
    common.check_units(options.units, units)
    found = calibrate(**given)
    common.write_rock(options, found.hammer)
    fitted = common.by_name(found.to_frame(), units, options.units)
    if options.out:
        outputs.write(fitted, options.out)
    print(common.readable(fitted))
    print(common.readable(found.residuals))
    print(*found.in_words(), sep="\n")
    return {"parameters": found.to_frame(), "residuals": found.residuals}
