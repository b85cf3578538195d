"""Rocks by name, and damping by ratio: parameters in a driller's words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from . import _native, quantities
from .errors import DomainError, RefusedError
from .longrun import steady
from .variables import VARIABLES, Value, numbers, whole


@dataclass(frozen=True)
class Figure:
    """A number of a rock."""

    value: float
    #: The least and the largest that the source allows.
    low: float
    high: float
    unit: str
    #: Where it is from.
    source: str
    #: False of an assumption.
    measured: bool


#: By name of the rock and of the number: ``hardness``, ``unloading_ratio``, and ``specific_energy``
#: where there is one.
ROCKS: Mapping[str, Mapping[str, Figure]] = {
    name: {row[0]: Figure(*row[1:]) for row in rows} for name, rows in _native.rocks()
}


class Rock(dict[str, float]):
    """The parameters of a rock under a bit, for `simulate`, `sweep` and so on."""

    #: What is assumed in them, a sentence each.
    assumed: tuple[str, ...] = ()


def rock(
    name: str,
    *,
    inserts: int,
    insert_radius: Value,
    bit_diameter: Value | None = None,
    specific_energy: Value | None = None,
) -> Rock:
    """Parameters of the rock law for a rock of the table under a bit of spherical inserts.

    ``KR = 2 pi R H n`` of ``n`` inserts of radius ``R`` in rock of hardness ``H``. `ROCKS` has each
    number with its source and scatter; what is assumed is in ``.assumed``.

    Args:
        name: a key of `ROCKS`.
        inserts: how many.
        insert_radius: of each one's tip, m or text with a unit.
        bit_diameter: of the hole, m or text with a unit; needed for a rate of penetration.
        specific_energy: energy per volume that drilling takes, J/m3, in place of the table's.

    Raises:
        DomainError: there is no such rock or bit; the message has those that there are.
    """
    if inserts != int(inserts) or inserts < 0:
        raise DomainError(f"inserts = {inserts} is no number of inserts")
    radius = quantities.read(insert_radius, "m", "insert_radius")
    pairs, assumed = _native.rock(name, int(inserts), radius)
    values = dict(pairs)
    given = {"hole.diameter": bit_diameter, "rock.specific_energy": specific_energy}
    for parameter, value in given.items():
        if value is not None:
            values[parameter] = VARIABLES[parameter].number(value)
    found = Rock(values)
    if specific_energy is not None:
        assumed = [text for text in assumed if "pecific energy" not in text]
    found.assumed = tuple(assumed)
    return found


def damping_time(
    ratio: Value,
    parameters: Mapping[str, Value] | None = None,
    *,
    preset: str | None = None,
) -> float:
    """The ``material.damping_time`` that damps the piston's first elastic mode by a ratio, s.

    ``beta = 2 zeta / omega``. The reference's 2e-8 s is 0.1 % of critical damping; a hammer of
    stepped bodies then never repeats a blow. Half a per cent is what the named hammers have.

    Args:
        ratio: of critical damping, 0 to 0.5.
        parameters: of the hammer.
        preset: parameter set to start from.
    """
    number = quantities.read(ratio, "1", "ratio")
    return _native.damping(numbers(preset, parameters), number)[0]


def damping_ratio(
    parameters: Mapping[str, Value] | None = None, *, preset: str | None = None
) -> float:
    """Damping ratio ``beta omega / 2`` of the piston's first elastic mode."""
    return _native.damping(numbers(preset, parameters), 0.0)[1]


def specific_energy(
    rate: Value,
    parameters: Mapping[str, Value] | None = None,
    *,
    preset: str | None = None,
) -> float:
    """The rock's specific energy from one measured rate of penetration, J/m3.

    ``E_v = 4 P / (pi D^2 rate)`` with the mean power ``P`` that the long-run response gives the
    rock (`steady`: blows need not repeat), and the hole's diameter ``D`` (``hole.diameter``).

    Args:
        rate: of penetration, m/s or text with a unit (``"30 m/h"``).
        parameters: of the hammer, as for `simulate`.
        preset: parameter set to start from.

    Raises:
        DomainError: no rate above 0.
        RefusedError: the hammer comes to rest.
    """
    number = quantities.read(rate, "m/s", "rate")
    diameter = whole(numbers(preset, parameters))["hole.diameter"]
    if not (math.isfinite(number) and number > 0.0):
        raise DomainError(f"rate = {number:g} m/s is not finite and above 0")
    found = steady(parameters, preset=preset)
    if found.kind == "stalled":
        raise RefusedError("the hammer comes to rest: a rate says nothing of it")
    work = found.mean["energy_rock_dissipated"] + found.mean["energy_viscous"]
    return float(work / found.mean["period"] / (0.25 * math.pi * diameter**2 * number))
