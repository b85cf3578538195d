"""`dth-hammer mesh`: says which degree and how many spans a stated error needs."""

from __future__ import annotations

import argparse

from ..mesh import mesh_for
from . import common

HELP = "print the mesh that a stated error needs"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    common.add_hammer(parser)
    parser.add_argument(
        "--of",
        help="result that the mesh is for: rate (and energies, if not given), force or stress",
    )
    parser.add_argument(
        "--error",
        type=float,
        help="largest relative error; 0.01 for a rate and 0.05 for the others if not given",
    )


def run(options: argparse.Namespace) -> None:
    """Prints the mesh as parameters, ready to be set."""
    chosen = common.assignments(options.set)
    mesh = mesh_for(
        parameters=chosen, preset=options.preset, **common.given(options, "error", "of")
    )
    print(f"front {mesh.front * 1e3:.3g} mm, spans of {mesh.span * 1e3:.3g} mm at most:")
    print(" ".join(f"--set {name}={value}" for name, value in mesh.parameters.items()))
