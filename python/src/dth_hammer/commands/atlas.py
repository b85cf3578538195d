"""`dth-hammer atlas`: follows a stationary cycle along a parameter."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs
from ..errors import DomainError
from ..variables import VARIABLES
from . import common

HELP = "follow stationary cycles along a parameter, stable or not"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    parser.add_argument(
        "--over",
        required=True,
        metavar="NAME=VALUES",
        help="first:last:number, as rock.stiffness=6e7:2.4e8:200",
    )
    parser.add_argument(
        "--returns",
        type=int,
        help="longest cycle to follow, in returns of the drive (usually blows)",
    )
    parser.add_argument(
        "--no-simulation", action="store_true", help="follow the cycle only, without simulations"
    )
    parser.add_argument("-o", "--out", type=Path, help=f"table to write: {outputs.either()}")
    parser.add_argument("--plot", type=Path, help="figure to write")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Follows the cycle, writes the requested files and prints what was found."""
    axes = common.assignments([options.over])
    (name, text), *_ = axes.items()
    values = [float(v) for v in common.values(VARIABLES.settable(name), text)]
    if len(values) < 2:
        raise DomainError(f"{name}: a cycle is followed over at least two values")
    common.check_outputs(options.out, options.plot)

    from ..atlas import atlas, figure  # noqa: PLC0415

    table = atlas(
        name,
        values,
        common.assignments(options.set),
        **common.given(options, "returns"),
        preset=options.preset,
        simulated=not options.no_simulation,
        progress=not options.quiet,
    )
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
