"""`dth-hammer atlas`: follows a stationary cycle along a parameter."""

from __future__ import annotations

import argparse

from .. import outputs
from ..atlas import atlas, figure
from ..variables import VARIABLES
from . import common
from .options import Call, Written, assignments

CALL = Call(
    atlas,
    {"name": "named by --over", "values": "given by --over"},
    simulated=Written("--no-simulation", help="follow the cycle only, without simulations"),
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds what is no argument of the function."""
    parser.add_argument(
        "--over",
        required=True,
        metavar="NAME=VALUES",
        help="first:last:number, as rock.stiffness=6e7:2.4e8:200",
    )
    common.add_files(parser, table="table to write", figure="figure to write")


def run(options: argparse.Namespace) -> None:
    """Follows the cycle, writes the requested files and prints what was found."""
    (name, text), *_ = assignments([options.over]).items()
    values = [float(v) for v in common.values(VARIABLES.settable(name), text)]
    common.check_outputs(options.out, options.plot)
    table = atlas(name, values, **CALL.given(options))
    if options.out:
        outputs.write(table, options.out, index=False)
    if options.plot:
        figure(table).savefig(options.plot)
    cycles = table[table["kind"] == "cycle"]
    unstable = int((~cycles["stable"].astype(bool)).sum()) if len(cycles) else 0
    counts = [
        f"{len(cycles)} cycles over {name} on {cycles['branch'].nunique()} branches",
        f"{unstable} of them unstable",
        f"{int(cycles['folds'].sum())} folds",
        f"events change their order {int(cycles['other_order'].sum())} times",
        f"{int(cycles['unresolved'].sum())} jumps stepped over",
    ]
    print(", ".join(counts) if len(cycles) else f"no cycle over {name}")
