"""Rocks by name: parameters in a driller's words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from . import _native, quantities
from .errors import DomainError
from .variables import VARIABLES, Value


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
