"""`dth-hammer rock`: prints the properties of a rock, and its parameters under a bit."""

import argparse
from typing import Any

from ..scene.rocks import ROCKS, rock
from .options import Call, Written

#: For each SI unit, the size and the name of the unit in which a number is printed.
FIELD = {"1": (1.0, ""), "Pa": (1e9, " GPa"), "J/m3": (1e6, " MJ/m3")}


CALL = Call(
    rock,
    name=Written("name", help=f"rock: {' or '.join(ROCKS)}; all if not given", nargs="?"),
)


def run(options: argparse.Namespace) -> Any:
    """Prints all rocks, or one rock with the parameters to set."""
    named = options.name.strip().lower() if options.name else ""
    listed = [name for name in ROCKS if named in (name, *name.split())] or [*ROCKS]
    for name in listed:
        print(name)
        for quantity, figure in ROCKS[name].items():
            known = "" if figure.measured else "assumed: "
            size, unit = FIELD[figure.unit]
            value, low, high = (x / size for x in (figure.value, figure.low, figure.high))
            print(f"  {quantity.replace('_', ' ')}: {value:.4g}{unit} ({low:.4g} to {high:.4g})")
            print(f"    {known}{figure.source}")
    if not named or all(v is None for v in (options.hole, options.inserts, options.insert_radius)):
        print("give a name and --hole, or --inserts and --insert-radius, for its parameters")
        return {name: {n: vars(figure) for n, figure in ROCKS[name].items()} for name in listed}
    parameters = rock(**CALL.given(options))
    for name, number in parameters.items():
        print(f"--set {name}={number:.6g}")
    print("assumed:", *parameters.assumed, sep="\n  ")
    return parameters
