"""`dth-hammer rock`: prints what is known of a rock, and its parameters under a bit."""

from __future__ import annotations

import argparse

from ..rocks import ROCKS, rock

#: The unit in which a number of an SI unit is printed, and how many of the SI unit it is.
FIELD = {"1": (1.0, ""), "Pa": (1e9, " GPa"), "J/m3": (1e6, " MJ/m3")}
HELP = "list rocks, with sources and scatter, or print the parameters of one under a bit"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    names = " or ".join(ROCKS)
    parser.add_argument("name", nargs="?", help=f"rock to print: {names}; all if not given")
    parser.add_argument("--hole", help='diameter of the hole, for instance "115 mm"')
    parser.add_argument("--inserts", type=int, help="number of inserts; by the hole if not given")
    parser.add_argument("--insert-radius", help='radius of the tip of an insert, as "7 mm"')
    parser.add_argument("--rebound", help="share of an insert's work that the rock gives back")
    parser.add_argument("--specific-energy", help="specific energy in J/m3, instead of the table's")


def run(options: argparse.Namespace) -> None:
    """Prints all rocks, or one with the parameters to set."""
    named = options.name.strip().lower() if options.name else ""
    matching = [name for name in ROCKS if named in (name, *name.split())] or [*ROCKS]
    for name in matching if named else ROCKS:
        print(name)
        for of, figure in ROCKS[name].items():
            known = "" if figure.measured else "assumed: "
            size, unit = FIELD[figure.unit]
            value, low, high = (x / size for x in (figure.value, figure.low, figure.high))
            print(f"  {of.replace('_', ' ')}: {value:.4g}{unit} ({low:.4g} to {high:.4g})")
            print(f"    {known}{figure.source}")
    bit = {"hole": options.hole, "inserts": options.inserts, "insert_radius": options.insert_radius}
    if not named or not any(value is not None for value in bit.values()):
        print("give a name and --hole, or --inserts and --insert-radius, for its parameters")
        return
    found = rock(
        options.name, **bit, rebound=options.rebound, specific_energy=options.specific_energy
    )
    for name, number in found.items():
        print(f"--set {name}={number:.6g}")
    print("assumed:", *found.assumed, sep="\n  ")
