"""Rocks beside any hammer: by name, class, strength, or from a file. The engine has them.

A file of a rock is JSON, ``{"hardness": "1.6 GPa", "unloading_ratio": 3, ...}``; what it leaves out
is the reference's.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from .. import _native, outputs
from ..contract import typed
from ..errors import DomainError, UnknownNameError
from . import quantities
from .quantities import Value


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


#: By name of the rock and of the number: ``hardness``, ``unloading_ratio``, ``specific_energy``.
ROCKS: Mapping[str, Mapping[str, Figure]] = {
    name: {row[0]: Figure(*row[1:]) for row in rows} for name, rows in _native.rocks()
}


#: What a file of a rock may have, with SI units.
UNITS: Mapping[str, str] = dict(_native.GROUND)
#: The word that may stand beside a hammer's parameters.
ROCK = "rock"


class Rock(dict[str, float]):
    """The parameters of a rock under a bit, for `simulate`, `sweep` and so on."""

    #: What is assumed in them, a sentence each.
    assumed: tuple[str, ...] = ()


def described(name: str) -> tuple[dict[str, float], list[str]]:
    """What a rock is to any bit, and what is assumed in it."""
    path = Path(name)
    if path.suffix == ".json":
        content = outputs.read_object(path, UNITS, "number of a rock")
        return {n: quantities.read(x, UNITS[n], n) for n, x in content.items()}, []
    if name.strip()[:1].isdigit():
        name = f"{quantities.read(name, 'Pa', ROCK) / 1e6!r} MPa"
    try:
        pairs, assumed = _native.ground(name)
    except DomainError as refused:
        unknown = UnknownNameError("rock", name, ROCKS)
        unknown.args = refused.args  # It has those that there are.
        raise unknown from None
    return dict(pairs), assumed


def beside(chosen: dict[str, Value], over: Mapping[str, Value]) -> dict[str, Value]:
    """A hammer's parameters with others laid over them; ``rock`` among these is under its bit."""
    text = over.get(ROCK)
    if text is None:
        return {**chosen, **over}
    own = {name: value for name, value in over.items() if name != ROCK}
    hole = own.get("hole.diameter", chosen.get("hole.diameter", _native.REFERENCE_HOLE))
    return {**chosen, **rock(str(text), hole=hole), **own}


def write(path: Path, parameters: Mapping[str, float]) -> None:
    """Writes the rock of a hammer to a file."""
    outputs.check(path, (".json",))
    path.write_text(json.dumps(dict(_native.ground_of(parameters)), indent=2) + "\n", "utf-8")


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
    """Returns the parameters of a rock under a bit with spherical inserts.

    ``KR = 2 pi R H n`` of ``n`` inserts of radius ``R`` in rock of hardness ``H``. `ROCKS` has each
    number with its source and scatter; what is assumed is in ``.assumed``.

    Args:
        name: a key of `ROCKS` or a word that only one has (``"granite"``), a class (``"R5"``,
            ``"very strong"``), a strength (``"180 MPa"``), or a file of a rock.
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
    numbers, assumed = described(name)
    count, radius, bit = _bit(hole, inserts, insert_radius)
    if specific_energy is not None:
        numbers["specific_energy"] = quantities.read(specific_energy, "J/m3", "specific_energy")
    if rebound is not None:
        share = quantities.read(rebound, "1", "rebound")
        if not 0.0 < share < 1.0:
            raise DomainError(f"rebound = {share:g} is not a share of the work, between 0 and 1")
        numbers["unloading_ratio"] = 1.0 / share
    values = dict(_native.ground_under(numbers, count, radius))
    if hole is not None:
        values["hole.diameter"] = quantities.read(hole, "m", "hole")
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
