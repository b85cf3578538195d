"""The range of a rate of penetration: that of the rock's specific energy.

The work that breaks a volume of rock is the least known number of a rate.
`rock.specific_energy_factor` says up to which factor it is known, so a rate `r` lies between
`r / factor` and `r * factor`. How single blows differ from each other (the spread) is another
number.
"""

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd

from .variables import Value, numbers, whole

#: Metres an hour in a metre a second.
PER_HOUR = 3600.0
#: Outputs that are rates of penetration.
RATES = ("rop", "rop_mean")
#: Endings of the columns that have the range of a rate.
SIDES = ("_low", "_high")
#: Least ratio of the ends of a range that two digits show.
VISIBLE = 1.05
#: Digits of the ends of a range.
DIGITS = 2


def factor(parameters: Mapping[str, Value]) -> float:
    """Up to which factor the rates of a hammer with these parameters are known."""
    return whole(numbers(None, parameters))["rock.specific_energy_factor"]


def band(rate: float, parameters: Mapping[str, Value]) -> tuple[float, float]:
    """The least and the largest rate that the range of the specific energy allows."""
    wide = factor(parameters)
    return rate / wide, rate * wide


def with_band(rate: float, parameters: Mapping[str, Value]) -> str:
    """A rate (m/s) with its range in words: ``10.9 m/h (7.0 to 17)``."""
    low, high = (PER_HOUR * side for side in band(rate, parameters))
    return f"{PER_HOUR * rate:.3g} m/h ({interval(low, high)})"


def beside(table: pd.DataFrame, column: str, wide: float, rate: str = "rop") -> pd.DataFrame:
    """A table with columns ``low`` and ``high`` behind one: the range of the rate among its rows.

    It is NaN for every other row.
    """
    known, at = table[column].where(table.index == rate), [*table].index(column) + 1
    table.insert(at, "low", known / wide)
    table.insert(at + 1, "high", known * wide)
    return table


def with_sides(names: Iterable[str]) -> list[str]:
    """Names of columns, with those of its range behind each rate: ``rop_low``, ``rop_high``."""
    return [
        column
        for name in names
        for column in (name, *(name + side for side in SIDES if name in RATES))
    ]


def sides(row: Mapping[str, float], parameters: Mapping[str, Value]) -> dict[str, float]:
    """The range of each rate in a row of outputs, as ``rop_low`` and ``rop_high``."""
    return {
        name + side: value
        for name in RATES
        if name in row
        for side, value in zip(SIDES, band(row[name], parameters), strict=True)
    }


def in_words(rate: float, parameters: Mapping[str, Value]) -> str:
    """A rate (m/s) with its range, and why it has one; nothing where there is no rate."""
    if not np.isfinite(rate):
        return ""
    return f"rate of penetration {with_band(rate, parameters)}: {reason(parameters)}"


def reason(parameters: Mapping[str, Value]) -> str:
    """Why a rate has a range, and which."""
    energy = whole(numbers(None, parameters))["rock.specific_energy"]
    low, high = (1e-6 * side for side in band(energy, parameters))
    return (
        f"a rate of penetration is known up to a factor of {factor(parameters):.3g}: the specific "
        f"energy is {1e-6 * energy:.3g} MJ/m3 ({interval(low, high)})"
    )


def sentence(parameters: Mapping[str, Value]) -> str:
    """The same as a sentence."""
    text = reason(parameters)
    return f"{text[0].upper()}{text[1:]}."


def interval(low: float, high: float, digits: int = DIGITS) -> str:
    """Two numbers to two digits, ``130 to 310``, or more."""
    two = f"{_two_digits(low)} to {_two_digits(high)}"
    return f"{low:.{digits}g} to {high:.{digits}g}" if digits > DIGITS else two


def ranged(low: float, high: float) -> str:
    """The interval of a range that two digits can show, else nothing."""
    return interval(low, high) if low * VISIBLE < high else ""


def to_digits(number: float, low: float, high: float) -> str:
    """A number to the digits that its range leaves: two where it is wide, four without one."""
    if low * VISIBLE >= high:
        return f"{number:.4g}"
    return _two_digits(number) if low * 1.3 < high else f"{float(f'{number:.3g}'):.6g}"


def _two_digits(number: float) -> str:
    short = f"{number:#.2g}"
    return f"{float(short):.0f}" if abs(number) >= 9.95 else short
