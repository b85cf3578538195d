"""`dth-hammer calibrate`: estimates parameters, with errors, from measured means."""

from __future__ import annotations

import argparse
from typing import Any

import pandas as pd

from .. import outputs
from ..variables import VARIABLES
from . import common

HELP = "estimate parameters from measured means, with errors"
NEEDS = ("scipy",)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    parser.add_argument(
        "--measured",
        action="append",
        required=True,
        metavar="NAME=VALUE:ERROR",
        help='a mean and its standard error, "rop=18 m/h:0.5 m/h", or three or more values with '
        "commas; repeatable",
    )
    common.add_free(parser, ", or a name alone, for a factor of three either way")
    parser.add_argument("--loss", help="linear (if not given), soft_l1, huber, cauchy or arctan")
    common.add_table(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Fits, writes the parameters, and prints them beside what was measured."""
    common.check_outputs(options.out)

    from ..calibration import calibrate  # noqa: PLC0415

    free = common.bounds(options.free, alone=True)
    units = {name: VARIABLES.settable(name).unit for name in free}
    common.by_name(pd.DataFrame(index=pd.Index([*free])), units, options.units)
    found = calibrate(
        {name: _measured(text) for name, text in common.assignments(options.measured).items()},
        free,
        common.assignments(options.set),
        preset=options.preset,
        **common.given(options, "loss"),
        progress=not options.quiet,
    )
    values = pd.DataFrame({"value": found.parameters, "error": found.errors})
    values = values.join(found.interval())
    table = common.by_name(values, units, options.units)
    if options.out:
        outputs.write(table, options.out)
    print(common.readable(table))
    print(common.readable(found.residuals))
    if found.steady is not None:
        print(found.steady.rate)
    print(f"chi-square {found.chi_square:.3g} of {found.degrees_of_freedom} degrees of freedom")
    for text in (*found.cannot_tell, *(f"{name} is at its bound" for name in found.at_bounds)):
        print(text)


def _measured(text: str) -> Any:
    """A value and its error, or several values."""
    return tuple(text.split(":")) if ":" in text else [part.strip() for part in text.split(",")]
