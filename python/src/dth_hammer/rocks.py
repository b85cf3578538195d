"""Rocks by name, described in a driller's terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from . import _native, quantities
from .contract import typed
from .errors import DomainError
from .variables import VARIABLES, Value


@dataclass(frozen=True)
class Figure:
    """A property of a rock: value, range and source."""

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


@typed()
def rock(
    name: str,
    *,
    hole: Value | None = None,
    inserts: int | None = None,
    insert_radius: Value | None = None,
    rebound: Value | None = None,
    specific_energy: Value | None = None,
) -> Rock:
    """Returns the rock parameters for a rock of the table under a bit with spherical inserts.

    ``KR = 2 pi R H n`` of ``n`` inserts of radius ``R`` in rock of hardness ``H``. `ROCKS` has each
    number with its source and scatter; what is assumed is in ``.assumed``.

    Args:
        name: a key of `ROCKS`, or a word that only one has (``"granite"``).
        hole: diameter of the hole, m or text with a unit; it decides the inserts if none are given.
        inserts: number of inserts.
        insert_radius: radius of the tip of an insert, m or text with a unit.
        rebound: share of an insert's work that the rock gives back, in place of the table's.
        specific_energy: work per volume that drilling takes, J/m3, in place of the table's.

    Raises:
        DomainError: there is no such rock or bit; the message has those that there are.

    Example:
        >>> from dth_hammer import rock
        >>> granite = rock("granite", hole="90 mm")
        >>> print(f"{granite['rock.stiffness']:.2e} N/m")
        5.52e+08 N/m
    """
    if inserts is not None and (inserts != int(inserts) or inserts < 0):
        raise DomainError(f"inserts = {inserts} is not a whole number of inserts")
    count, radius, bit = _bit(hole, inserts, insert_radius)
    pairs, assumed = _native.rock(name, count, radius)
    values = dict(pairs)
    given = {"hole.diameter": hole, "rock.specific_energy": specific_energy}
    for parameter, value in given.items():
        if value is not None:
            values[parameter] = VARIABLES[parameter].number(value)
    if rebound is not None:
        share = quantities.read(rebound, "1", "rebound")
        if not 0.0 < share < 1.0:
            raise DomainError(f"rebound = {share:g} is not a share of the work, between 0 and 1")
        values["rock.unloading_ratio"] = 1.0 / share
    found = Rock(values)
    if specific_energy is not None:
        assumed = [text for text in assumed if "pecific energy" not in text]
    found.assumed = (*bit, *assumed)
    return found


def _bit(
    hole: Value | None, inserts: int | None, insert_radius: Value | None
) -> tuple[int, float, list[str]]:
    """Inserts of a bit, the radius of each one's tip (m), and what is assumed of them."""
    radius = None
    if insert_radius is not None:
        radius = quantities.read(insert_radius, "m", "insert_radius")
    if inserts is not None and radius is not None:
        return int(inserts), radius, []
    if hole is None:
        raise DomainError("the bit is not known: give hole, or inserts and insert_radius")
    usual, own = _native.inserts(quantities.read(hole, "m", "hole"))
    count, tip = usual if inserts is None else int(inserts), own if radius is None else radius
    return count, tip, [f"The bit has {count} inserts of {1e3 * tip:.3g} mm at their tips."]
