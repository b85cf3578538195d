"""The mesh that a result needs for a given error, by the engine's rule."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

from .. import _native
from ..contract import typed
from ..errors import DomainError
from .hammers import Hammerlike, Rocklike, numbers_of
from .variables import VARIABLES, whole

BODIES = ("piston", "bit")
ELEMENTS = ("piston.elements", "bit.elements")
FIDELITY, ELASTIC = "fidelity", "Elastic"
#: Results that a mesh can be chosen for, each with its default relative error.
READINGS = dict(_native.READINGS)


@dataclass(frozen=True)
class Mesh:
    """A mesh, and the error for which it was chosen."""

    #: The result for which it was chosen: rate, force or stress.
    of: str
    #: Relative error of that result for which it was chosen.
    error: float
    #: Width of the sharpest wave front, m.
    front: float
    #: Longest span of the mesh, m.
    span: float
    #: Degree and number of spans, by the names of the parameters that set them.
    parameters: Mapping[str, int]


#: Outputs that depend on the wave front of an impact, and so need a finer mesh than a rate.
FORCES = tuple(f"{tie}_force{of}" for tie in ("contact", "rock", "chuck") for of in ("", "_peak"))


def coarse_for(names: Iterable[str], waves: bool, given: Mapping[str, float]) -> tuple[str, ...]:
    """Returns a warning if forces or stresses are requested on a mesh that suits only a rate.

    Args:
        names: requested outputs; those in `FORCES` need the finer mesh.
        waves: whether stresses along the bodies are requested.
        given: numbers of the hammer.
    """
    asked = [name for name in FORCES if name in names] + ["stresses"] * waves
    if not asked or not _elastic(given):
        return ()
    reading = "stress" if waves else "force"
    error, default_error = _native.mesh_errors(dict(given))[1], READINGS[reading]
    if error <= default_error:
        return ()
    return (
        f"{', '.join(asked)}: this mesh is fine enough for a rate; the force of an impact errs by "
        f"up to {error:.0%} on it. mesh_for(of={reading!r}) has a mesh for {default_error:.0%}",
    )


def _elastic(given: Mapping[str, float]) -> bool:
    return whole(given)[FIDELITY] == VARIABLES[FIDELITY].number(ELASTIC)


def errors_in_words(given: Mapping[str, float]) -> list[str]:
    """Returns a sentence with the error due to the mesh; none for rigid bodies."""
    if not _elastic(given):
        return []
    rate, force = _native.mesh_errors(dict(given))
    known = "not known (linear elements)" if rate is None else f"up to {100 * rate:.2g} %"
    return [
        f"error of the mesh: of `rop` {known}, of the largest forces up to {100 * force:.2g} % "
        "(a finer one: mesh_for, dth-hammer mesh)"
    ]


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
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        of: the result: a ``rate`` (also for period, energy and power of blows), a ``force`` (the
            largest force of the contact or the rock), or a ``stress`` along the bodies.

    Raises:
        DomainError: the error is not between 0 and 1, ``of`` is none of these results, or the error
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
    # The engine lists the bodies in this order; a casing without sections has no entry.
    elements = dict(zip((*ELEMENTS, "casing.elements"), spans, strict=False))
    chosen = {"mesh.degree": degree, **elements}
    bodies = [*_native.bodies({**given, **chosen}).values()][: len(spans)]
    span = max(b - a for body in bodies for a, b in pairwise(body["nodes"]))
    return Mesh(of, error, front, span, chosen)
