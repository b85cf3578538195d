"""The uncertainty range of a rate of penetration.

The range comes from the rock's specific energy (work per volume of broken rock), which is the
least known number that a rate depends on. It is known up to the factor
`rock.specific_energy_factor`, so a rate `r` lies between `r / factor` and `r * factor`. The spread
from blow to blow is a different number and is not part of this range.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from ..frames import pd
from .variables import Value, numbers, whole

#: Number of metres per hour in one metre per second.
PER_HOUR = 3600.0
#: Outputs that are rates of penetration.
RATES = ("rop", "rop_mean")
#: Suffixes of the columns that hold the lower and upper end of a rate's range.
SIDES = ("_low", "_high")
#: A range is displayed if its upper end is more than this times its lower end.
VISIBLE = 1.05
#: Significant digits of the displayed ends of a range.
DIGITS = 2


def factor(parameters: Mapping[str, Value]) -> float:
    """Returns the factor up to which the rates of a hammer with these parameters are known."""
    return whole(numbers(None, parameters))["rock.specific_energy_factor"]


def band(rate: float, parameters: Mapping[str, Value]) -> tuple[float, float]:
    """Returns the lowest and the highest rate within the range of the specific energy."""
    known_factor = factor(parameters)
    return rate / known_factor, rate * known_factor


def unseen(known_factor: float) -> float:
    """Returns the largest relative standard error of a rate that does not show in its range.

    Twice that error and the logarithm of the factor, added as squares, widen each end by less than
    half a unit of its last digit: 0.005 of it or more.
    """
    half_unit = 0.5 / 10**DIGITS
    return 0.5 * math.sqrt(half_unit * (2.0 * math.log(known_factor) + half_unit))


def with_band(rate: float, parameters: Mapping[str, Value]) -> str:
    """Returns a rate (given in m/s) and its range as text: ``10.9 m/h (7.0 to 17)``."""
    low, high = (PER_HOUR * side for side in band(rate, parameters))
    return f"{PER_HOUR * rate:.3g} m/h ({interval(low, high)})"


def beside(
    table: pd.DataFrame, column: str, known_factor: float, rate: str = "rop"
) -> pd.DataFrame:
    """Inserts the columns ``low`` and ``high``, the range of a rate, after the given column.

    The row named ``rate`` gets the range; all other rows get NaN. ``known_factor`` is the factor up
    to which the rate is known. The table is changed in place and returned.
    """
    rates, position = table[column].where(table.index == rate), [*table].index(column) + 1
    table.insert(position, "low", rates / known_factor)
    table.insert(position + 1, "high", rates * known_factor)
    return table


def with_sides(names: Iterable[str]) -> list[str]:
    """Returns the column names, each rate followed by its range: ``rop_low``, ``rop_high``."""
    return [
        column
        for name in names
        for column in (name, *(name + side for side in SIDES if name in RATES))
    ]


def sides(row: Mapping[str, float], parameters: Mapping[str, Value]) -> dict[str, float]:
    """Returns the range of each rate in a row of outputs, such as ``rop_low`` and ``rop_high``."""
    return {
        name + side: value
        for name in RATES
        if name in row
        for side, value in zip(SIDES, band(row[name], parameters), strict=True)
    }


def in_words(rate: float, parameters: Mapping[str, Value]) -> str:
    """Returns a rate (m/s), its range and the reason for the range as text; "" for NaN."""
    if not math.isfinite(rate):
        return ""
    return f"rate of penetration {with_band(rate, parameters)}: {reason(parameters)}"


def reason(parameters: Mapping[str, Value]) -> str:
    """Returns the reason for the range of a rate, with the range of the specific energy."""
    energy = whole(numbers(None, parameters))["rock.specific_energy"]
    low, high = (1e-6 * side for side in band(energy, parameters))
    return (
        f"a rate of penetration is known up to a factor of {factor(parameters):.3g}: the specific "
        f"energy with this hammer is {1e-6 * energy:.3g} MJ/m3 ({interval(low, high)})"
    )


def sentence(parameters: Mapping[str, Value]) -> str:
    """Returns the text of `reason` as a sentence, with a capital letter and a full stop."""
    text = reason(parameters)
    return f"{text[0].upper()}{text[1:]}."


def interval(low: float, high: float, digits: int = DIGITS) -> str:
    """Returns an interval as text, ``130 to 310``, with two or more significant digits."""
    two = f"{_two_digits(low)} to {_two_digits(high)}"
    return f"{low:.{digits}g} to {high:.{digits}g}" if digits > DIGITS else two


def ranged(low: float, high: float) -> str:
    """Returns a range as text, or "" if it is too narrow for two digits to show it."""
    return interval(low, high) if low * VISIBLE < high else ""


def to_digits(number: float, low: float, high: float) -> str:
    """Returns a number with as many significant digits as its range justifies.

    That is two digits for a wide range and three for a narrow one. If the range is too narrow to be
    shown, the number has four digits.
    """
    if low * VISIBLE >= high:
        return f"{number:.4g}"
    return _two_digits(number) if low * 1.3 < high else f"{float(f'{number:.3g}'):.6g}"


def _two_digits(number: float) -> str:
    short = f"{number:#.2g}"
    return f"{float(short):.0f}" if abs(number) >= 9.95 else short
