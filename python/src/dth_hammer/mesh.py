"""Which mesh a hammer needs for a stated error: the engine's own rule, see the guide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from . import _native
from .contract import told
from .errors import DomainError
from .variables import Value, numbers

BODIES = ("piston", "bit")
ELEMENTS = ("piston.elements", "bit.elements")
FIDELITY, ELASTIC = "fidelity", "Elastic"


@dataclass(frozen=True)
class Mesh:
    """A mesh, and what it is for."""

    #: Relative error of the forces at an impact that was asked for.
    error: float
    #: Width of the sharpest front, m.
    front: float
    #: Longest span, m.
    span: float
    #: Degree and spans by parameter.
    parameters: Mapping[str, int]


@told()
def mesh_for(
    error: float, parameters: Mapping[str, Value] | None = None, *, preset: str | None = None
) -> Mesh:
    """The mesh on which forces at an impact err by no more than ``error``, relative.

    The contact makes a front ``w = c Z/KC`` wide, ``1/Z = 1/Zp + 1/Zb`` where the bodies meet;
    spans ``h`` leave ``exp(-6 beta c w (pi/h)^2) / (1 + (pi w/h)^2)`` of it wrong. In an elastic
    casing the chuck makes the front, with ``ks`` and the sections of bit and casing.

    Raises `DomainError` for an error outside 0 to 1, or one that takes more spans than a body
    may have.
    """
    if not 0.0 < error < 1.0:
        raise DomainError(f"error = {error:g} is not within 0 and 1")
    given = numbers(preset, parameters)
    front, advice = _native.mesh(given, error)
    if advice is None:
        raise DomainError(
            f"an error of {error:g} takes more spans than a body may have: fronts are "
            f"{front * 1e3:.2g} mm wide; soften contact.stiffness (in a casing, chuck.stiffness) "
            "or damp more"
        )
    degree, *spans = advice
    bodies = (*BODIES, "casing")[: len(spans)]
    elements = {f"{body}.elements": count for body, count in zip(bodies, spans, strict=True)}
    chosen = {"mesh.degree": degree, **elements}
    nodes = [_native.nodes({**given, **chosen}, body) for body in bodies]
    span = max(float((n[1:] - n[:-1]).max()) for n in nodes)
    return Mesh(error, front, span, chosen)
