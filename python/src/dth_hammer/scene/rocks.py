"""Rocks by name, class or strength, which the engine provides, or from a file.

A rock file is JSON, ``{"hardness": "1.6 GPa", "unloading_ratio": 3, ...}``. Numbers that it leaves
out are those of the reference rock.
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
    #: Lowest and highest value according to the source.
    low: float
    high: float
    unit: str
    #: The publication or the reasoning from which the value comes.
    source: str
    #: Whether the value was measured; False for an assumption.
    measured: bool


#: Properties by the name of the rock, then by the name of the property: ``hardness``,
#: ``unloading_ratio``, ``specific_energy``.
ROCKS: Mapping[str, Mapping[str, Figure]] = {
    name: {row[0]: Figure(*row[1:]) for row in rows} for name, rows in _native.rocks()
}


#: Numbers that a rock file may contain, with their SI units.
UNITS: Mapping[str, str] = dict(_native.GROUND)
#: Key by which a rock may be named among a hammer's parameters.
ROCK = "rock"


class Rock(dict[str, float]):
    """The parameters of a rock under a bit, for `simulate`, `sweep` and so on."""

    #: The assumptions behind the numbers, one sentence each.
    assumed: tuple[str, ...] = ()


def described(name: str) -> tuple[dict[str, float], list[str]]:
    """Returns the properties of a rock, which hold for any bit, and the assumptions in them."""
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
        unknown.args = refused.args  # The engine's message lists the rocks that exist.
        raise unknown from None
    return dict(pairs), assumed


def beside(chosen: dict[str, Value], over: Mapping[str, Value]) -> dict[str, Value]:
    """Returns the parameters ``chosen``, overridden by those of ``over``.

    If ``over`` has the key ``rock``, the parameters of that rock under the hammer's bit are added;
    rock parameters that ``over`` gives itself take precedence.
    """
    text = over.get(ROCK)
    if text is None:
        return {**chosen, **over}
    explicit = {name: value for name, value in over.items() if name != ROCK}
    hole = explicit.get("hole.diameter", chosen.get("hole.diameter", _native.REFERENCE_HOLE))
    return {**chosen, **rock(str(text), hole=hole), **explicit}


def write(path: Path, parameters: Mapping[str, float]) -> None:
    """Writes the rock of a hammer to a rock file."""
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

    The stiffness of ``n`` inserts with the tip radius ``R`` in rock of hardness ``H`` is
    ``KR = 2 pi R H n``. `ROCKS` lists each number with its source and scatter; the attribute
    ``assumed`` of the result lists the assumptions.

    Args:
        name: a key of `ROCKS` or a word that only one key has (``"granite"``), a class (``"R5"``,
            ``"very strong"``), a strength (``"180 MPa"``), or the path of a rock file.
        hole: diameter of the hole, m or text with a unit; it determines the number and the radius
            of the inserts where they are not given.
        inserts: number of inserts.
        insert_radius: radius of the tip of an insert, m or text with a unit.
        rebound: share of an insert's work that the rock gives back, instead of the table's value.
        specific_energy: work per volume of drilled rock, J/m3, instead of the table's value.

    Raises:
        DomainError: there is no such rock or bit; the message lists those that exist.

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
    parameters = Rock(values)
    if specific_energy is not None:
        assumed = [text for text in assumed if "pecific energy" not in text]
    parameters.assumed = (*bit, *assumed)
    return parameters


def _bit(
    hole: Value | None, inserts: int | None, insert_radius: Value | None
) -> tuple[int, float, list[str]]:
    """Returns the number of inserts, the radius of their tips (m) and the assumptions made."""
    radius = None
    if insert_radius is not None:
        radius = quantities.read(insert_radius, "m", "insert_radius")
    if inserts is not None and radius is not None:
        return int(inserts), radius, []
    if hole is None:
        raise DomainError("the bit is not known: give hole, or inserts and insert_radius")
    usual_count, usual_radius = _native.inserts(quantities.read(hole, "m", "hole"))
    count = usual_count if inserts is None else int(inserts)
    radius = usual_radius if radius is None else radius
    return count, radius, [f"The bit has {count} inserts of {1e3 * radius:.3g} mm at their tips."]
