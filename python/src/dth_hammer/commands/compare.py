"""`dth-hammer compare`: what one hammer, or pressure, gives over another in one rock."""

import argparse
from typing import Any

from ..scene.band import interval
from ..scene.datasheet import from_datasheet
from ..study.comparison import compare
from .options import ROCK, Call, Written, assignments, listed

MADE = "made of the words that are given"
CALL = Call(compare, {"a": MADE, "b": MADE})


ALSO = (
    Written("sheet", help="a datasheet: od=124mm,pressure=24bar,power=31.7kW,hole=140mm"),
    Written("other", help="what is other in the hammer compared with it: at=30bar"),
    ROCK,
)


def run(options: argparse.Namespace) -> Any:
    """Prints each number of the other hammer over that of the first, with its range."""
    given = assignments(listed(options.sheet)) | ({"rock": options.rock} if options.rock else {})
    first = from_datasheet(**given)
    other = first.but(**assignments(listed(options.other)))
    table = compare(other, first)
    for name, row in table.iterrows():
        print(f"{name}: {row['ratio']:.3g} times ({interval(row['low'], row['high'], 3)})")
    return table
