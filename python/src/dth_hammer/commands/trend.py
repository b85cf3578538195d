"""`dth-hammer trend`: computes what the long-run means depend on, over stated widths."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import outputs
from ..quantities import read
from . import common

HELP = "compute what the long-run response depends on, with errors and roughness"
NEEDS = ("scipy",)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    parser.add_argument(
        "--over",
        action="append",
        required=True,
        metavar="NAME=WIDTH",
        help="a parameter and the relative width around its value: rock.stiffness=0.05",
    )
    parser.add_argument("--outputs", help="means, separated by commas: rop,blow_energy")
    parser.add_argument("--points", type=int, help="number of hammers")
    parser.add_argument("-o", "--out", type=Path, help=f"table to write: {outputs.either()}")
    parser.add_argument("--plot", type=Path, help="figure to write: tornado chart")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(options: argparse.Namespace) -> None:
    """Computes the trends, writes and prints them."""
    common.check_outputs(options.out, options.plot)

    from ..trends import OUTPUTS, trend  # noqa: PLC0415

    widths = {
        n: read(w, "1", f"the width of {n}") for n, w in common.assignments(options.over).items()
    }
    found = trend(
        common.assignments(options.set),
        widths,
        [o.strip() for o in options.outputs.split(",")] if options.outputs else OUTPUTS,
        preset=options.preset,
        points=options.points,
        progress=not options.quiet,
    )
    if options.out:
        outputs.write(found.table.reset_index(), options.out, index=False)
    if options.plot:
        found.plot().savefig(options.plot)
    print(found.summary())
    displayed = found.table.map("{:.4f}".format)
    texts = displayed["elasticity"] + " +- " + displayed["error"]
    wide = texts.unstack("by").loc[[*found.roughness.index], [*found.widths.index]]
    wide["roughness"] = found.roughness.map("{:.2%}".format)
    wide.columns.name = None
    print(wide.to_string())
