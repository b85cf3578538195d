"""`dth-hammer mesh`: prints the degree and the number of spans for a given error."""

import argparse
from typing import Any

from ..scene.mesh import READINGS, mesh_for
from .options import Call, Written

DEFAULT_ERRORS = ", ".join(f"{error:g} of a {of}" for of, error in sorted(READINGS.items()))
CALL = Call(mesh_for, error=Written(more=f"; if not given, {DEFAULT_ERRORS}"))


def run(options: argparse.Namespace) -> Any:
    """Prints the mesh as parameters that can be set."""
    mesh = mesh_for(**CALL.given(options))
    print(f"front {mesh.front * 1e3:.3g} mm, spans of {mesh.span * 1e3:.3g} mm at most:")
    print(" ".join(f"--set {name}={value}" for name, value in mesh.parameters.items()))
    return mesh.parameters
