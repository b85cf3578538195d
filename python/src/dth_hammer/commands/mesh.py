"""`dth-hammer mesh`: says which degree and how many spans a stated error needs."""

from __future__ import annotations

import argparse

from ..mesh import mesh_for
from . import common

HELP = "print the mesh that a stated error needs"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_scene(parser)
    parser.add_argument(
        "--of", default="rate", help="what is read: rate (and energies), force or stress"
    )
    parser.add_argument(
        "--error", type=float, help="relative error of it; 0.01 of a rate, 0.05 of the others"
    )


def run(options: argparse.Namespace) -> None:
    """Prints the mesh as parameters, ready to be set."""
    chosen = common.assignments(options.set)
    mesh = mesh_for(options.error, chosen, preset=options.preset, of=options.of)
    print(f"front {mesh.front * 1e3:.3g} mm, spans of {mesh.span * 1e3:.3g} mm at most:")
    print(" ".join(f"--set {name}={value}" for name, value in mesh.parameters.items()))
