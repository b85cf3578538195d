"""`dth-hammer optimise`: finds the best design within bounds and limits."""

from __future__ import annotations

import argparse
from typing import Any

from .. import outputs
from ..frames import pd
from ..scene.variables import VARIABLES
from ..study.measures import named, unit
from ..study.optimisation import optimise
from . import common
from .options import FREE, UNITS, Call, Written, bounds, table

NEEDS = ("scipy",)
BOUNDS: dict[str, Any] = {"action": "append", "metavar": "NAME=LOW:HIGH"}
CALL = Call(
    optimise,
    {"design": "a function"},
    goal=Written(help="mean to maximise (default: rop)", required=False, default="rop"),
    free=Written("--free", bounds, help=FREE, **BOUNDS),
    limits=Written(
        "--limit",
        bounds,
        help='limits of a mean, of which one may be left out: "blow_energy=:240 J"; repeatable',
        **BOUNDS,
    ),
)
ALSO = (table("table of all designs that were tried"), UNITS)


def run(options: argparse.Namespace) -> Any:
    """Optimises, writes every design that was tried and prints the best."""
    given = CALL.given(options)
    goal = {options.goal: unit(named(options.goal))}
    units = {name: VARIABLES.settable(name).unit for name in given["free"]} | goal
    common.check_units(options.units, units)
    optimum = optimise(**given)
    if options.out:
        outputs.write(optimum.history, options.out, index=False)
    best = pd.DataFrame({"value": {**optimum.parameters, options.goal: optimum.value}})
    print(common.readable(common.by_name(best, units, options.units)))
    print(optimum.steady.rate)
    print(f"{optimum.status}: {optimum.message}")
    return {"parameters": optimum.parameters, options.goal: optimum.value, "status": optimum.status}
