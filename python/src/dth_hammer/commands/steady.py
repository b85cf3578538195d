"""`dth-hammer steady`: computes the long-run means of a hammer, or of many, with errors."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .. import outputs
from ..frames import pd
from ..scene.hammers import numbers_of
from ..scene.variables import VARIABLES
from ..study.longrun import MEANS, unit
from ..study.response import steady
from . import common
from .options import MANY, UNITS, WRITE_ROCK, Call, Written

CALL = Call(
    steady,
    {
        "inputs": "functions of time",
        "control": "a function",
        "partner": "a function",
        "step": "of inputs over time, control or a partner only",
    },
    out=Written(
        "-o --out",
        type=Path,
        stream=".csv",
        help=f"table to write: {outputs.either()}; of many hammers {outputs.either(outputs.STORED)}"
        ": the same command seeks only what is missing",
    ),
)


ALSO = (*MANY, UNITS, WRITE_ROCK)


def run(options: argparse.Namespace) -> Any:
    """Computes the long-run responses, then writes and prints means and errors."""
    grid, asked = common.many(options), CALL.given(options)
    if options.out:
        outputs.check(options.out, outputs.STORED if len(grid) else outputs.TABLES)
    units = {name: unit(name) for name in MEANS}
    if len(grid):
        common.check_units(options.units, units | {n: VARIABLES.settable(n).unit for n in grid})
        base = asked.pop("hammer")
        shared = {name: value for name, value in numbers_of(base).items() if name not in grid}
        rows = grid.assign(**shared) if isinstance(grid, pd.DataFrame) else grid | shared
        table = steady(rows, **asked)
        columns = ["rop", "rop_error", "blow_frequency", "blow_energy"]
        common.print_many(options, table, [*grid, "kind", "blows", *columns], base)
        return table
    common.check_units(options.units, units)
    asked.pop("out", None)
    response = steady(**asked)
    common.write_rock(options, response.parameters)
    table = common.by_name(response.outputs.drop(columns="unit"), units, options.units)
    if options.out:
        outputs.write(table, options.out)
    print(*response.in_words(), sep="\n")
    if response.blows:
        common.print_air(response.parameters)
        print(common.readable(table))
    if response.motions is not None:
        print(common.readable(response.motions))
    return {"kind": response.kind, "blows": response.blows, "means": response.outputs}
