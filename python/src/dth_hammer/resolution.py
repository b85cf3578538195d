"""Which mesh a hammer needs for a stated error: the engine's own rule, see the guide."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from . import bodies
from .errors import DomainError
from .package import Package, load
from .variables import Value

#: Below this error degree 7 is the cheaper one, above it degree 5.
FINE = 1e-4


@dataclass(frozen=True)
class Mesh:
    """A mesh, and what it is for."""

    #: Relative error of the forces at an impact that was asked for.
    error: float
    #: Width of the sharpest front, m.
    front: float
    #: Longest span that resolves it, m.
    span: float
    #: Degree and spans by parameter.
    parameters: Mapping[str, int]


def mesh(
    error: float,
    parameters: Mapping[str, Value] | None = None,
    *,
    preset: str | None = None,
    fmu: str | Path | Package | None = None,
) -> Mesh:
    """The mesh on which forces at an impact err by no more than ``error``, relative.

    The contact makes a front ``w = c Z/KC`` wide, ``1/Z = 1/Zp + 1/Zb`` where the bodies meet;
    spans ``h`` leave ``exp(-6 beta c w (pi/h)^2) / (1 + (pi w/h)^2)`` of it wrong.

    Raises `DomainError` for an error outside 0 to 1, or one that takes more spans than a body
    may have.
    """
    if not 0.0 < error < 1.0:
        raise DomainError(f"error = {error:g} is not within 0 and 1")
    package = load(fmu)
    numbers = {v.name: v.start or 0.0 for v in package.variables.of("parameter")}
    numbers |= package.values(preset, parameters)
    speed = math.sqrt(numbers["material.youngs_modulus"] / numbers["material.density"])
    front = _front(numbers, speed)
    damping = 6.0 * numbers["material.damping_time"] * speed * front

    def left(span: float) -> float:
        k = math.pi / span
        return math.exp(-damping * k * k) / (1.0 + (k * front) ** 2)

    both = (bodies.PISTON, bodies.BIT)
    most = {b: int(package.variables[f"{b}.elements"].maximum or 1) for b in both}
    fine = min(bodies.length(numbers, b) / most[b] for b in both)
    coarse = sum(bodies.length(numbers, b) for b in both)
    shortest = fine
    if left(fine) <= error:
        for _ in range(60):
            middle = 0.5 * (fine + coarse)
            fine, coarse = (fine, middle) if left(middle) > error else (middle, coarse)
    spans = {b: sum(math.ceil(s.length / fine) for s in bodies.sections(numbers, b)) for b in both}
    if left(shortest) > error or any(spans[b] > most[b] for b in both):
        raise DomainError(
            f"an error of {error:g} takes more spans than a body may have: fronts are "
            f"{front * 1e3:.2g} mm wide; soften contact.stiffness or damp more"
        )
    chosen = {"mesh.degree": 7 if error < FINE else 5}
    chosen |= {f"{b}.elements": spans[b] for b in both}
    return Mesh(error, front, fine, chosen)


def _front(numbers: Mapping[str, float], speed: float) -> float:
    above, below = bodies.sections(numbers, "piston"), bodies.sections(numbers, "bit")
    unit = math.sqrt(numbers["material.youngs_modulus"] * numbers["material.density"])
    a, b, tip = (unit * s.area for s in (above[-1], below[0], below[-1]))
    contact = a * b / (a + b) / numbers["contact.stiffness"]
    rock = tip / (numbers["rock.unloading_ratio"] * numbers["rock.stiffness"])
    return speed * min(contact, rock)
