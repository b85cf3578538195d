"""`dth-hammer compare`: ratios of two hammers, or of two pressures, in one rock."""

import argparse
from dataclasses import replace
from typing import Any

from ..scene.band import interval
from ..scene.datasheet import Datasheet
from ..study.comparison import compare
from .options import A_HAMMER, ROCK, Call, Written, assignments, hammer_of, listed

MADE = "made of the words that are given"
CALL = Call(compare, {"a": MADE, "b": MADE})


ALSO = (
    Written("sheet", help=A_HAMMER),
    Written(
        "other",
        help="the hammer compared with it: what is other in it, as at=30bar, or a preset or a file",
    ),
    ROCK,
)


def run(options: argparse.Namespace) -> Any:
    """Prints the ratio of each number of the other hammer to that of the first, with its range."""
    first = hammer_of(options.sheet, options.rock)
    changes = assignments(listed(options.other)) if "=" in options.other else {}
    if not changes:
        other = hammer_of(options.other, options.rock)
    elif isinstance(first, Datasheet):
        other = first.but(**changes)
    else:
        other = replace(first, parameters={**first.parameters, **changes})
    table = compare(other, first)
    for name, row in table.iterrows():
        print(f"{name}: {row['ratio']:.3g} times ({interval(row['low'], row['high'], 3)})")
    return table
