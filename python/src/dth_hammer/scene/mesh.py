"""The mesh that a result with a given error needs, by the engine's rule."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from .. import _native
from ..contract import typed
from ..errors import DomainError
from .hammers import Hammerlike, Rocklike, numbers_of
from .variables import VARIABLES, whole

BODIES = ("piston", "bit")
ELEMENTS = ("piston.elements", "bit.elements")
FIDELITY, ELASTIC = "fidelity", "Elastic"
#: What a mesh may be for, and the error of it that is asked for where none is given.
READINGS = dict(_native.READINGS)


@dataclass(frozen=True)
class Mesh:
    """A mesh, and the error for which it was chosen."""

    #: What it is for: rate, force or stress.
    of: str
    #: Relative error of it that was asked for.
    error: float
    #: Width of the sharpest front, m.
    front: float
    #: Longest span, m.
    span: float
    #: Degree and spans by parameter.
    parameters: Mapping[str, int]


#: Outputs that an impact's front makes.
FORCES = tuple(f"{tie}_force{of}" for tie in ("contact", "rock", "chuck") for of in ("", "_peak"))


def coarse_for(names: Iterable[str], waves: bool, given: Mapping[str, float]) -> tuple[str, ...]:
    """Warns that forces (of these outputs) or stresses are asked for on a mesh made for a rate."""
    asked = [name for name in FORCES if name in names] + ["stresses"] * waves
    if not asked or whole(given)[FIDELITY] != VARIABLES[FIDELITY].number(ELASTIC):
        return ()
    reading = "stress" if waves else "force"
    error, usual = float(_native.force_error(dict(given))), READINGS[reading]
    if error <= usual:
        return ()
    return (
        f"{', '.join(asked)}: this mesh is fine enough for a rate; the force of an impact errs by "
        f"up to {error:.0%} on it. mesh_for(of={reading!r}) has a mesh for {usual:.0%}",
    )


@typed()
def mesh_for(
    hammer: Hammerlike = None,
    error: float | None = None,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    of: str = "rate",
) -> Mesh:
    """Returns a mesh on which a result has at most the relative error ``error``.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        error: largest relative error, between 0 and 1. If None, the engine's choice for the result.
        preset: parameter set that a mapping is laid over.
        rock: beside it: a name, a class or a strength, or a file, as `dth_hammer.rock` takes them.
        of: the result: a ``rate`` (also period, energy and power of blows), a ``force`` (the
            largest of contact or rock), or a ``stress`` along the bodies.

    Raises:
        DomainError: the error is not between 0 and 1, the result is none of these, or the error
            needs more spans than a body may have.

    Example:
        >>> from dth_hammer import mesh_for
        >>> mesh = mesh_for(error=0.05, of="force")
        >>> print(mesh.parameters)
        {'mesh.degree': 5, 'piston.elements': 45, 'bit.elements': 45}
    """
    if of not in READINGS:
        raise DomainError(f"of = {of!r} must be one of {', '.join(sorted(READINGS))}")
    error = READINGS[of] if error is None else error
    if not 0.0 < error < 1.0:
        raise DomainError(f"error = {error:g} must be between 0 and 1")
    given = numbers_of(hammer, preset, rock)
    front, advice = _native.mesh(given, of, error)
    if advice is None:
        raise DomainError(
            f"an error of {error:g} takes more spans than a body may have: fronts are "
            f"{front * 1e3:.2g} mm wide; soften contact.stiffness (in a casing, chuck.stiffness) "
            "or damp more"
        )
    degree, *spans = advice
    # In the order of the engine, a casing last.
    elements = dict(zip((*ELEMENTS, "casing.elements"), spans, strict=False))
    chosen = {"mesh.degree": degree, **elements}
    bodies = [*_native.bodies({**given, **chosen}).values()][: len(spans)]
    span = max(float(np.diff(body["nodes"]).max()) for body in bodies)
    return Mesh(of, error, front, span, chosen)
