"""`dth-hammer optimise`: finds the best design within bounds and limits."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from .. import outputs
from ..variables import VARIABLES
from . import common

HELP = "find the parameters, within bounds and limits, for which a mean is largest"
NEEDS = ("scipy",)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    parser.add_argument("--goal", default="rop", help="mean to maximise")
    parser.add_argument("--least", action="store_true", help="minimise it instead")
    common.add_free(parser)
    parser.add_argument(
        "--limit",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH",
        help='limits of a mean, of which one may be left out: "blow_energy=:240 J"; repeatable',
    )
    parser.add_argument("--starts", type=int, help="number of starts at most")
    parser.add_argument(
        "--tolerance", type=float, help="of each free number: the goal is a mean over it; 0: none"
    )
    parser.add_argument(
        "-o", "--out", type=Path, help="table to write: all designs that were tried"
    )
    common.add_units(parser)


def run(options: argparse.Namespace) -> None:
    """Optimises, writes every design that was tried and prints the best."""
    common.check_outputs(options.out)

    from ..measures import named, unit  # noqa: PLC0415
    from ..optimisation import optimise  # noqa: PLC0415

    free = common.bounds(options.free)
    limits: Mapping[Any, Any] = common.bounds(options.limit)
    goal = {options.goal: unit(named(options.goal))}
    units = {name: VARIABLES.settable(name).unit for name in free} | goal
    common.by_name(pd.DataFrame(index=pd.Index([*units])), units, options.units)
    found = optimise(
        options.goal,
        free,
        common.assignments(options.set),
        least=options.least,
        limits=limits,
        preset=options.preset,
        **common.given(options, "starts", "tolerance"),
    )
    if options.out:
        outputs.write(found.history, options.out, index=False)
    best = pd.DataFrame({"value": {**found.parameters, options.goal: found.value}})
    print(common.readable(common.by_name(best, units, options.units)))
    print(found.steady.rate)
    print(f"{found.status}: {found.message}")
