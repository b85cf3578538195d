"""`dth-hammer rock`: prints the parameters of a named rock under a bit with inserts."""

from __future__ import annotations

import argparse

from ..rocks import ROCKS, rock

HELP = "list rocks, with sources and scatter, or print the parameters of one under a bit"


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it takes."""
    parser.add_argument("name", nargs="?", help="; ".join(ROCKS))
    parser.add_argument("--inserts", type=int, help="number of inserts")
    parser.add_argument(
        "--insert-radius", help='radius of the tip of an insert, for instance "7 mm"'
    )
    parser.add_argument("--bit-diameter", help='diameter of the hole, for instance "115 mm"')
    parser.add_argument("--specific-energy", help="specific energy in J/m3, instead of the table's")


def run(options: argparse.Namespace) -> None:
    """Prints the table, or what to set."""
    if options.name is None or options.inserts is None or options.insert_radius is None:
        for name, figures in ROCKS.items():
            print(name)
            for of, figure in figures.items():
                known = "" if figure.measured else "assumed: "
                print(
                    f"  {of} = {figure.value:.4g} ({figure.low:.4g} to {figure.high:.4g})"
                    f" {figure.unit}".rstrip(" 1")
                )
                print(f"    {known}{figure.source}")
        print("give a name, --inserts and --insert-radius for its parameters under a bit")
        return
    found = rock(
        options.name,
        inserts=options.inserts,
        insert_radius=options.insert_radius,
        bit_diameter=options.bit_diameter,
        specific_energy=options.specific_energy,
    )
    for name, number in found.items():
        print(f"--set {name}={number:.6g}")
    print("assumed:", *found.assumed, sep="\n  ")
