"""Quantities with units: one reader of what a user writes, one converter of what is shown.

The units are pint's, with its exact factors, so that ``"60 mm"`` is the same number as 0.06.
Units may be written as the table of quantities has them (``N.s/m``, ``m2``) or as pint does.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from .errors import DomainError, UnitError, UnknownNameError
from .extras import need
from .fixed import Fixed

if TYPE_CHECKING:
    import pandas as pd
    import pint

NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", re.DOTALL)
#: What a unit may be made of: nothing that computes for long.
UNIT = re.compile(r"(?:1/)?[^\W\d_][\w ./*^%²³·°]{0,39}")
#: A turn is 2 pi to pint, and a blow to nobody.
ANGLE = re.compile(r"\b(rpm|rps|rev\w*|turns?|rad\w*|deg\w*)\b")
#: Units of the field by those of the table: metric, then those of the oil field.
FIELD: Mapping[str, tuple[str, ...]] = {
    "m": ("mm", "cm", "in", "ft"),
    "m2": ("mm2", "cm2", "in2"),
    "m/s": ("mm/s", "m/min", "m/h", "ft/h", "ft/s"),
    "m/s2": ("ft/s2",),
    "s": ("ms", "us", "min", "h"),
    "N": ("kN", "lbf", "kgf"),
    "N/m": ("kN/mm", "MN/m", "lbf/in"),
    "N.s": ("kN.s", "lbf.s"),
    "N.s/m": ("kN.s/m", "lbf.s/in"),
    "Pa": ("bar", "MPa", "GPa", "psi"),
    "J": ("kJ", "ft.lbf"),
    "kg": ("g", "lb"),
    "kg/m3": ("g/cm3", "lb/ft3"),
    "Hz": ("1/min",),
}
#: Units of the oil field by those that the table proposes to show.
OIL_FIELD: Mapping[str, str] = {
    "mm": "in",
    "m": "in",
    "mm2": "in2",
    "m/s": "ft/s",
    "m/min": "ft/h",
    "m/s2": "ft/s2",
    "kN": "lbf",
    "kN/mm": "lbf/in",
    "N.s": "lbf.s",
    "N.s/m": "lbf.s/in",
    "bar": "psi",
    "MPa": "psi",
    "GPa": "psi",
    "J": "ft.lbf",
    "kg/m3": "lb/ft3",
}
SYSTEMS = ("si", "metric", "us")


def read(value: object, unit: str, name: str) -> float:
    """The value as a number in a unit; text may carry another unit of the same dimension.

    Args:
        value: a number, text such as ``"60 mm"``, or a quantity of pint's.
        unit: the unit wanted, as the table of quantities has it; ``"1"`` or nothing for a pure number.
        name: what the value is of, for the message of an error.
    """
    if isinstance(value, str):
        return _read_text(value.strip(), unit, name)
    if hasattr(value, "to") and hasattr(value, "magnitude"):
        quantity: Any = value
        return _read_text(f"{float(quantity.magnitude)!r} {quantity.units:C}", unit, name)
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise DomainError(f"{name} = {value!r} is not a number") from None


def seconds(value: object, name: str) -> float:
    """A duration or an instant in seconds; text may carry a unit, a timedelta is one."""
    if isinstance(value, datetime.timedelta):
        value = value.total_seconds()
    number = read(value, "s", name)
    if not math.isfinite(number):
        raise DomainError(f"{name} must be finite, not {number}")
    return number


def duration(value: object, name: str) -> float:
    """A duration in seconds, above 0."""
    number = seconds(value, name)
    if not number > 0.0:
        raise DomainError(f"{name} = {number:g} s is not above 0")
    return number


def convert(frame: Any, units: str | Mapping[str, str]) -> Any:
    """A run or a table of this package in other units; ``attrs["units"]`` says which.

    Args:
        frame: a run, or a table: its frame, its blows, a sweep.
        units: ``"si"``, ``"metric"`` (what people use), ``"us"`` (in, ft, lbf,
            psi), or a unit by column, for instance ``{"rop": "m/h"}``.
    """
    if hasattr(frame, "frame"):
        return frame.convert(units)
    own = dict(frame.attrs.get("units", {}))
    shown = frame.attrs.get("display_units", {})
    base = frame.attrs.get("si_units", own)
    if isinstance(units, str):
        if units not in SYSTEMS:
            raise UnknownNameError("system of units", units, SYSTEMS)
        proposed = {n: shown.get(n) or u for n, u in base.items() if n in frame}
        if units == "si":
            proposed = {n: base[n] for n in proposed}
        elif units == "us":
            proposed = {n: OIL_FIELD.get(u, u) for n, u in proposed.items()}
        units = proposed
    result = frame.copy()
    for name, unit in units.items():
        if name not in frame:
            raise UnknownNameError("column", name, map(str, frame))
        if name not in own:
            raise UnitError(f"{name} has no unit")
        factor = float(1 / _factor(unit, own[name], name))
        if factor != 1.0:
            result[name] = result[name] * factor
    result.attrs = frame.attrs | {"units": Fixed(own | dict(units)), "si_units": Fixed(base)}
    return result


def known(unit: str) -> str:
    """The units that one thinks of where a unit is declared, for messages."""
    names = (unit, *FIELD.get(unit, ())) if unit not in ("", "1") else ()
    return ", ".join(names) or "no unit"


def _read_text(text: str, unit: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        pass
    match = NUMBER.fullmatch(text)
    if match is None or not UNIT.fullmatch(match[2]):
        raise DomainError(f"{name} = {text!r} is not a number, nor one with a unit")
    factor, number = _factor(match[2], unit, name), float(match[1])
    if number == 0.0 or not math.isfinite(number):
        return number
    try:
        return float(Fraction(match[1]) * factor)
    except OverflowError:
        return math.inf


@lru_cache(maxsize=1024)
def _factor(given: str, wanted: str, name: str) -> Fraction:
    """What a number in the given unit is to be multiplied by."""
    if given == wanted:
        return Fraction(1)
    refusal = UnitError(f"{name} is given in {known(wanted)}, not in {given!r}")
    if wanted in ("", "1") or not UNIT.fullmatch(given) or ANGLE.search(given):
        raise refusal
    registry = _registry()
    try:
        one = registry.Quantity(Fraction(1), registry.parse_units(_spelled(given)))
        return Fraction(one.to(registry.parse_units(_spelled(wanted))).magnitude)
    except Exception:
        # Pint raises what its tokenizer does, too.
        raise refusal from None


def _spelled(unit: str) -> str:
    """A unit as pint writes it: N.s/m2 is N*s/m**2."""
    text = unit.replace("·", "*").replace("^", "**")
    text = re.sub(r"(?<=[^\W\d_])\.(?=[^\W\d_])", "*", text)
    return re.sub(r"(?<=[^\W\d_])(\d)", r"**\1", text)


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    # Loaded by who writes a unit: it takes a second.
    registry: pint.UnitRegistry[Any] = need("pint", "units").UnitRegistry(non_int_type=Fraction)
    return registry
