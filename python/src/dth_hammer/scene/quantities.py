"""Quantities with units: reads what a user writes, and converts results for display.

Factors are exact, so that ``"60 mm"`` is the same number as 0.06. A unit is a product of symbols
with powers, as the engine declares them (``N.s/m``, ``m2``) or as Python and pint write them
(``N*s/m``, ``m**2``).
"""

from __future__ import annotations

import contextlib
import datetime
import math
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ..errors import DomainError, UnknownNameError
from ..frames import pd

if TYPE_CHECKING:
    import numpy as np

    # NumPy's numbers also count when the program runs.
    Value = float | int | bool | str | np.integer[Any] | np.floating[Any]
else:
    #: A number in the declared unit, a label of an enumeration, text such as ``"60 mm"``, or a pint
    #: quantity.
    Value = float | int | bool | str

#: Whole and fraction of an inch, as drill bits are sold: ``5 1/2 in``, ``5-1/2"``.
INCHES = re.compile(r"(?:(\d+)[ -]+)?(\d+)/(\d+)\s*(?:in\.?|inch|inches|\"|″|”|'')", re.IGNORECASE)
NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", re.DOTALL)
#: The start of a unit, and its largest length.
UNIT = re.compile(r"(?:1?/)?[^\W\d_].{0,39}|[%\"″”]|''|°.{1,10}")
#: A space between groups of three digits, as ISO 80000 writes them.
GROUPS = re.compile(r"(?<=\d)[ \u00a0\u202f](?=\d{3}(?!\d))")
#: A symbol with its power, in a unit as `_parsed` has rewritten it.
SYMBOL = re.compile(r"([^\W\d_]+)(-?\d)?")
#: For each symbol, its size and the powers of metre, kilogram and second. These symbols take
#: prefixes.
METRIC: Mapping[str, tuple[Any, int, int, int]] = {
    "m": (1, 1, 0, 0),
    "g": ("0.001", 0, 1, 0),
    "s": (1, 0, 0, 1),
    "N": (1, 1, 1, -2),
    "J": (1, 2, 1, -2),
    "W": (1, 2, 1, -3),
    "Pa": (1, -1, 1, -2),
    "bar": (100_000, -1, 1, -2),
    "Hz": (1, 0, 0, -1),
    "l": ("0.001", 3, 0, 0),
    "L": ("0.001", 3, 0, 0),
}
PREFIXES: Mapping[str, Any] = {
    "n": "1e-9", "u": "1e-6", "µ": "1e-6", "μ": "1e-6", "m": "1e-3", "c": "1e-2", "d": "0.1",
    "h": 100, "k": 1000, "M": 10**6, "G": 10**9,
}  # fmt: skip
#: Units without prefixes. The inch, the pound and standard gravity are exact by definition.
POUND, GRAVITY = Fraction("0.45359237"), Fraction("9.80665")
PSI, CFM = POUND * GRAVITY / Fraction("0.0254") ** 2, Fraction("0.3048") ** 3 / 60
#: Standard air (60 degF, 14.7 psi) as a share of the engine's free air (0 degC, 1.01325 bar).
STANDARD = (Fraction("14.7") * PSI / 101_325) * Fraction("273.15") / Fraction("519.67") * 9 / 5
OTHERS: Mapping[str, tuple[Any, int, int, int]] = {
    "min": (60, 0, 0, 1),
    "h": (3600, 0, 0, 1),
    "t": (1000, 0, 1, 0),
    "tf": (1000 * GRAVITY, 1, 1, -2),
    "in": ("0.0254", 1, 0, 0),
    "ft": ("0.3048", 1, 0, 0),
    "lb": (POUND, 0, 1, 0),
    "lbf": (POUND * GRAVITY, 1, 1, -2),
    "klb": (1000 * POUND, 0, 1, 0),
    "klbf": (1000 * POUND * GRAVITY, 1, 1, -2),
    "kgf": (GRAVITY, 1, 1, -2),
    "daN": (10, 1, 1, -2),
    "psi": (PSI, -1, 1, -2),
    "ksi": (1000 * PSI, -1, 1, -2),
    "atm": (101_325, -1, 1, -2),
    "at": (GRAVITY * 10_000, -1, 1, -2),
    "blows": (1, 0, 0, 0),
    "bpm": (Fraction(1, 60), 0, 0, -1),
    "cfm": (CFM, 3, 0, -1),
    "scfm": (STANDARD * CFM, 3, 0, -1),
    "hp": (550 * Fraction("0.3048") * POUND * GRAVITY, 2, 1, -3),
    "rpm": (Fraction(1, 60), 0, 0, -1),
    "r": (1, 0, 0, 0),
}
#: Words of the trade in lower case, and their units as `_parsed` reads them.
TRADE: Mapping[str, str] = {
    word: unit
    for unit, words in {
        **{"m": "metre metres meter meters", "ft": "feet foot", "in": "inch inches \" ″ ” ''"},
        **{"s": "sec secs second seconds", "min": "mins minute minutes", "h": "hr hrs hour hours"},
        **{"kg": "kgs", "lb": "lbs pound pounds", "t": "tonne tonnes", "N": "newton newtons"},
        **{"kgf": "kp", "tf": "tonnef", "klbf": "kip kips", "klb": "klbs", "J": "joule joules"},
        **{"Pa": "pascal", "MPa": "mpa", "W": "watt watts", "hp": "bhp", "Hz": "hertz cps"},
        **{"l": "lit ltr litre litres liter liters", "l/min": "lpm", "l/s": "lps"},
        **{"blows": "blow b strokes stroke impacts impact", "bpm": "spm", "1/min": "/min min-1"},
        **{"r": "rev revs revolution revolutions turn turns", "%": "% percent"},
        **{"N.m": "nm", "kN.m": "knm", "daN.m": "danm", "kgf.m": "kgm kgfm kpm"},
        **{"ft.lbf": "ftlb ftlbs ftlbf", "ft/h": "fph", "ft/min": "fpm"},
    }.items()
    for word in words.split()
}
#: Words that may mean several units, and what to write instead.
AMBIGUOUS: Mapping[str, str] = {
    "mph": "m/h or ft/h (miles are no rate of drilling)",
    **dict.fromkeys(("ps", "cv", "ch"), "hp or kW"),
    **dict.fromkeys(("ton", "tons", "tonf"), "t or 2000 lb"),
    **dict.fromkeys(("gal", "gals", "gallon", "gallons"), "l (gallons are American or British)"),
    "gpm": "l/min (gallons are American or British)",
    **dict.fromkeys(("acfm", "icfm"), "scfm, or Nm3/min (their inlets differ)"),
    "ipm": "in/min or bpm",
}
GAUGE = re.compile(r"(k?pa|mpa|m?bar|psi|atm|at)[ .]?[([]?(g|ga|gauge|a|abs|absolute)[)\]]?", re.I)
#: Cubic metres of air over the engine's free air, which is normal air: normal (0 degC), standard
#: (15 degC), and a compressor's inlet air by ISO 1217 (20 degC, 1 bar).
FREE = re.compile(r"([NS])[ .]?m3(?=/|$)|[ .]?[([]?(FAD)[)\]]?$", re.I)
NORMAL: Mapping[str, Fraction] = {
    "n": Fraction(1),
    "s": Fraction("273.15") / Fraction("288.15"),
    "f": Fraction("273.15") / Fraction("293.15") / Fraction("1.01325"),
}
#: Size of a degree in kelvins, and the temperature 0 K in degrees.
DEGREES: Mapping[str, tuple[Fraction, Fraction]] = {
    **dict.fromkeys(
        ("degc", "deg c", "°c", "° c", "c", "celsius"), (Fraction(1), Fraction("273.15"))
    ),
    **dict.fromkeys(
        ("degf", "deg f", "°f", "° f", "f", "fahrenheit"), (Fraction(5, 9), Fraction("459.67"))
    ),
}
#: Inputs that are absolute pressures; all other pressures are gauge.
ABSOLUTE = ("supply_pressure", "exhaust_pressure")
#: Units of turns and of blows, and the word that names of rotations contain.
TURNS, BLOWS, ROTATION = ("rpm", "r"), ("bpm", "blows"), "rotation"
#: Rates of drilling, which may also be written as time per length.
DRILLED = ("rop", "rop_mean", "tip_rate")
UNITS = {
    prefix + symbol: (Fraction(many) * Fraction(of[0]), *of[1:])
    for prefix, many in PREFIXES.items()
    for symbol, of in METRIC.items()
    # Nobody writes these; they look like the millimetre and others in capitals.
    if not (prefix in "MG" and symbol in "mgslL")
} | {**METRIC, **OTHERS}
#: Lower-case forms that belong to one unit only.
SMALL = {
    name.lower(): name
    for name, size in UNITS.items()
    if all(UNITS[other] == size for other in UNITS if other.lower() == name.lower())
}
#: Field units, by the units of the engine's table: metric ones, then those of the oil field.
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
    "J": ("kJ", "N.m", "ft.lbf"),
    "kg": ("g", "lb"),
    "kg/m3": ("g/cm3", "lb/ft3"),
    "Hz": ("1/min", "bpm", "blows/min"),
    "m3/s": ("m3/min", "l/min", "cfm"),
}
#: Oil-field units, by the display units of the engine's table.
OIL_FIELD: Mapping[str, str] = {
    "mm": "in",
    "m": "in",
    "mm2": "in2",
    "m/s": "ft/s",
    "m/h": "ft/h",
    "mm/s": "ft/h",
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
    "m3/min": "cfm",
}
#: The display unit of a number, by its unit in the table or by its name.
DISPLAY_UNITS: Mapping[str, str] = {
    **{"s": "ms", "m": "mm", "N": "kN", "W": "kW", "Pa": "MPa", "J/m3": "MJ/m3", "m3/s": "m3/min"},
    **{"rate of penetration": "m/h", "tip's gain per time": "mm/s"},
}
SYSTEMS = ("si", "metric", "us")
Units = str | Mapping[str, str]
#: Suffixes of the columns with the range and the error of another column.
BESIDE = ("_low", "_high", "_error")


class Fixed(dict[str, str]):
    """Units in a table's ``attrs``. Copies share them, because pandas copies at every operation."""

    def __deepcopy__(self, _memo: dict[int, Any]) -> Fixed:
        return self


def read(value: object, unit: str, name: str) -> float:
    """Returns the value as a number in a unit; text may have another unit of the same dimension.

    Args:
        value: a number, text such as ``"60 mm"``, or a quantity of pint's.
        unit: the unit of the result, as in the engine's table; ``"1"`` or "" for a pure number.
        name: name of the value, for error messages.
    """
    if isinstance(value, str):
        return _read_text(value.strip(), unit, name)
    if hasattr(value, "to") and hasattr(value, "magnitude"):
        quantity: Any = value
        return _read_text(f"{float(quantity.magnitude)!r} {quantity.units:~C}", unit, name)
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise DomainError(f"{name} = {value!r} is not a number") from None


def alike(values: Iterable[Any], name: str) -> list[Any]:
    """Returns values that all have units. If only the last one has a unit, it is that of all.

    Zero needs no unit.

    Raises:
        DomainError: some have a unit and some have none.
    """
    values = [*values]
    if not any(isinstance(value, str) or hasattr(value, "magnitude") for value in values):
        return values
    units = [_unit_of(value) for value in values]
    if None in units or len({bool(unit) for unit in units}) < 2:
        return values
    bare = [k for k, unit in enumerate(units) if not unit]
    if all(str(values[k]).strip("+-0. ") == "" for k in bare):
        return values
    if len(bare) < len(values) - 1 or not units[-1] or not isinstance(values[-1], str):
        listed = ", ".join(map(str, values))
        raise DomainError(
            f"{name}: {listed}: some have a unit and some have none (a decimal is written 1.5)"
        )
    return [f"{value} {units[-1]}" if k in bare else value for k, value in enumerate(values)]


def _unit_of(value: object) -> str | None:
    """Returns the unit that is written with a number; None if the value is no number."""
    if hasattr(value, "magnitude"):
        return "its own"
    match = NUMBER.fullmatch(str(value).strip())
    return match[2].strip() if match else None


def seconds(value: object, name: str) -> float:
    """Returns a duration or an instant (number, text with a unit, timedelta) in seconds."""
    if isinstance(value, datetime.timedelta):
        value = value.total_seconds()
    number = read(value, "s", name)
    if not math.isfinite(number):
        raise DomainError(f"{name} must be finite, not {number}")
    return number


def duration(value: object, name: str) -> float:
    """Returns a duration in seconds; raises an error unless it is above 0."""
    number = seconds(value, name)
    if not number > 0.0:
        raise DomainError(f"{name} = {number:g} s is not above 0")
    return number


def convert(
    frame: pd.DataFrame, units: Units | Sequence[Units], *, skip_missing: bool = False
) -> pd.DataFrame:
    """Converts a table of this package to other units, listed in ``attrs["units"]``.

    Args:
        frame: the frame of a run, its blows, or a sweep.
        units: a system, or units by column, also for the column's range and error; in a list, later
            entries override earlier ones.
        skip_missing: ignores units of columns that the table does not have.
    """
    if not isinstance(units, str | Mapping):
        for each in units:
            frame = convert(frame, each, skip_missing=skip_missing)
        return frame
    own = dict(frame.attrs.get("units", {}))
    displays = frame.attrs.get("display_units", {})
    base = frame.attrs.get("si_units", own)
    if isinstance(units, str):
        if units not in SYSTEMS:
            raise UnknownNameError("system of units", units, SYSTEMS)
        chosen = {n: displays.get(n) or u for n, u in base.items() if n in frame}
        if units == "si":
            chosen = {n: base[n] for n in chosen}
        elif units == "us":
            chosen = {n: OIL_FIELD.get(u, u) for n, u in chosen.items()}
    else:
        beside = {n + side: u for n, u in units.items() for side in BESIDE if n + side in frame}
        chosen = {n: u for n, u in units.items() if n in frame or not skip_missing} | beside
    result = frame.copy()
    for name, unit in chosen.items():
        if name not in frame:
            raise UnknownNameError("column", name, map(str, frame))
        if name not in own:
            raise DomainError(f"{name} has no unit")
        factor = float(1 / _factor(unit, own[name], name))
        if factor != 1.0:
            result[name] = result[name] * factor
    result.attrs = frame.attrs | {"units": Fixed(own | chosen), "si_units": Fixed(base)}
    return result


def with_units(table: pd.DataFrame) -> pd.DataFrame:
    """Returns a table for display, with the unit of each column in its heading: ``rop [m/s]``."""
    units = {"time": "s", **table.attrs.get("units", {})}

    def heading(name: str) -> str:
        unit = units.get(name, "1")
        return name if unit in ("", "1") else f"{name} [{unit}]"

    headed = table.set_axis([heading(str(name)) for name in table], axis=1)
    index = table.index.name
    return headed if index is None else headed.rename_axis(index=heading(str(index)))


def displayed(name: str, unit: str) -> tuple[float, str]:
    """Returns factor and unit for the display of a number with this name and declared unit."""
    own = DISPLAY_UNITS.get(name) or DISPLAY_UNITS.get(unit, unit)
    return float(1 / _factor(own, unit, name)), own


def known(unit: str) -> str:
    """Returns the usual units of a declared unit's dimension, for messages."""
    names = (unit, *FIELD.get(unit, ())) if unit not in ("", "1") else ()
    return ", ".join(names) or "no unit"


def _read_text(text: str, unit: str, name: str) -> float:
    with contextlib.suppress(ValueError):
        return float(text)
    text = re.sub("[¼½¾⅛⅜⅝⅞]", lambda part: " " + unicodedata.normalize("NFKC", part[0]), text)
    text = GROUPS.sub("", text.replace("\N{FRACTION SLASH}", "/").strip())
    if inches := INCHES.fullmatch(text):
        whole, part, of = (int(group or 0) for group in inches.groups())
        if of:
            return float((whole + Fraction(part, of)) * _factor("in", unit, name))
    match = NUMBER.fullmatch(text)
    if match is None or not UNIT.fullmatch(match[2]):
        hint = ""
        if comma := re.search(r"\d+,(\d+)", text):
            hint = f" (a decimal is written {comma[0].replace(',', '.')}"
            hint += f", thousands {comma[0].replace(',', '')})" if len(comma[1]) == 3 else ")"
        raise DomainError(f"{name} = {text!r} is not a number, nor one with a unit{hint}")
    number = float(match[1])
    if unit == "K" and (degrees := DEGREES.get(match[2].lower())):
        return float((Fraction(match[1]) + degrees[1]) * degrees[0])
    if unit == "m/s" and name in DRILLED and _parsed(_plain(match[2]))[1] == (-1, 0, 1):
        return 1.0 / (number * float(_parsed(_plain(match[2]))[0])) if number else math.inf
    factor = _factor(match[2], unit, name)
    if number == 0.0 or not math.isfinite(number):
        return number
    try:
        return float(Fraction(match[1]) * factor)
    except OverflowError:
        return math.inf


@lru_cache(maxsize=1024)
def _factor(given: str, wanted: str, name: str) -> Fraction:
    """Returns the factor from the given unit to SI."""
    if given == wanted:
        return Fraction(1)
    text, free = _plain(given), Fraction(1)
    words = re.findall(r"[^\W\d_]+", text.lower())
    if ambiguous := [AMBIGUOUS[word] for word in words if word in AMBIGUOUS]:
        raise DomainError(f"{name}: {given!r} may be several units: give {ambiguous[0]}")
    if wanted in ("", "1") and TRADE.get(text.lower()) == "%":
        return Fraction(1, 100)
    if gauge := GAUGE.fullmatch(text):
        text = gauge[1]
        over = gauge[2].lower().startswith("g")
        if wanted == "Pa" and over == (name in ABSOLUTE):
            kind = "absolute, not over the air's" if over else "over the air's, not absolute"
            how = "add" if over else "subtract"
            raise DomainError(f"{name} is {kind} as {given!r} says: {how} 1.013 bar")
    if air := FREE.search(text):
        text, free = FREE.sub("m3" if air[1] else "", text), NORMAL[(air[1] or air[2])[0].lower()]
    if (air or "scfm" in words) and "flow" in name and "air" not in name:
        raise DomainError(f"{name} is not of air as {given!r} says: give {known(wanted)}")
    (factor, powers), (one, wanted_powers) = _parsed(text), _parsed(wanted)
    weight = powers == (wanted_powers[0] - 1, 1, wanted_powers[2] + 2)
    if weight and wanted in ("Pa", "J", "N", "N/m"):
        # Kilograms and pounds are forces here, as in kg/cm2 and ft-lb.
        factor, powers = factor * GRAVITY, wanted_powers
    if not factor or powers != wanted_powers or wanted in ("", "1"):
        raise DomainError(f"{name} is given in {known(wanted)}, not in {given!r}")
    words = [TRADE.get(word, word) for word in words] if wanted == "Hz" else []
    if ROTATION not in name and {*words} & {*TURNS}:
        raise DomainError(f"{name} is of blows, not of turns as {given!r} says: give bpm or Hz")
    if ROTATION in name and {*words} & {*BLOWS}:
        raise DomainError(f"{name} is of turns, not of blows as {given!r} says: give rpm")
    return free * factor / one


def is_unit(text: str) -> bool:
    """Returns whether a text is a unit of any kind, or a word for several units."""
    plain, words = _plain(text), re.findall(r"[^\W\d_]+", text.lower())
    known = plain.lower() in DEGREES or TRADE.get(plain.lower()) == "%" or {*words} & {*AMBIGUOUS}
    plain = FREE.sub("m3", gauge[1] if (gauge := GAUGE.fullmatch(plain)) else plain)
    return bool(plain) and bool(known or _parsed(plain)[0] > 0)


def _plain(unit: str) -> str:
    """Returns a unit with digits as powers and a slash for ``per``."""
    text = re.sub(r"\*\*|\^", "", unit.strip()).replace("″", '"').replace("⁻", "-")
    text = unicodedata.normalize("NFKC", text)
    return re.sub(r"(?<=\w)\.$", "", re.sub(r"\s+per\s+|\s*/\s*", "/", text, flags=re.I))


def _parsed(unit: str) -> tuple[Fraction, tuple[int, int, int]]:
    """Parses a unit: factor to SI (0 if unknown), powers of metre, kilogram and second."""
    text = unit if unit in UNITS else TRADE.get(unit.lower(), unit)
    text = re.sub(r"(?<=[a-zA-Z])-(?=[a-zA-Z])", ".", text)
    first, *rest = re.split(r"\s*([.*·⋅/ ])\s*", text)
    total, powers = Fraction(1), [0, 0, 0]
    for operator, part in zip(["*", *rest[::2]], [first, *rest[1::2]], strict=True):
        if part == "1":
            continue
        match = SYMBOL.fullmatch(part)
        symbol = match[1] if match else ""
        if symbol not in UNITS:
            symbol = TRADE.get(symbol.lower(), SMALL.get(symbol.lower(), ""))
        if match is None or symbol not in UNITS:
            return Fraction(0), (0, 0, 0)
        factor, *of = UNITS[symbol]
        power = int(match[2] or 1) * (-1 if operator == "/" else 1)
        total *= Fraction(factor) ** power
        powers = [a + power * b for a, b in zip(powers, of, strict=True)]
    return total, (powers[0], powers[1], powers[2])
