"""Summary of a run: means over blows, the range of the rate, the spread of the blows."""

from __future__ import annotations

import math

from ..errors import DomainError, TooFewBlowsError
from ..frames import np, pd
from ..scene import quantities
from ..scene.band import beside, interval
from ..scene.variables import Array


def summary(table: pd.DataFrame, begin: float, factor: float) -> pd.DataFrame:
    """Returns the table of `Run.summary`, from blows in SI units after an instant."""
    if begin < 0.0:
        raise DomainError(f"since = {begin:g} s is before the start")
    # A row contains the work since the previous blow, so it belongs to that blow's energy.
    times, energies = (table[name].to_numpy() for name in ("blow_time", "blow_energy"))
    counted = (
        np.flatnonzero((times[:-1] >= begin) & (table["blow_period"].to_numpy()[1:] > 0.0)) + 1
    )
    if len(counted) < 2:
        raise TooFewBlowsError(
            f"{len(counted)} complete blow periods from {begin:g} s on: 2 are needed"
        )
    names = ("blow_period", "blow_penetration", "blow_length", "rock_work", "free_air")
    period, gain, length, work, air = (table[name].to_numpy()[counted] for name in names)
    energy, speed = energies[counted - 1], table["blow_speed"].to_numpy()[counted - 1]
    total = period.sum()
    rows = [
        ("rate of penetration", length.sum() / total, _spread(length / period), "m/s"),
        ("frequency", len(counted) / total, math.nan, "Hz"),
        ("blow period", *_moments(period), "s"),
        ("impact speed", *_moments(speed), "m/s"),
        ("blow energy", *_moments(energy), "J"),
        ("work to the rock per blow", *_moments(work), "J"),
        (
            "work to the rock over blow energy",
            work.sum() / energy.sum(),
            _spread(work / energy),
            "1",
        ),
        ("power of the blows", energy.sum() / total, math.nan, "W"),
        ("power to the rock", work.sum() / total, math.nan, "W"),
        ("tip's gain per blow", *_moments(gain), "m"),
        ("tip's gain per time", gain.sum() / total, _spread(gain / period), "m/s"),
        *([("free air", air.sum() / total, _spread(air / period), "m3/s")] if air.any() else []),
    ]
    found = pd.DataFrame(
        [row[1:] for row in rows],
        index=[name for name, *_ in rows],
        columns=["mean", "spread", "unit"],
    )
    return beside(found, "mean", factor, "rate of penetration")


HEADS = ("", "mean", "range", "from blow to blow", "unit")


def displayed(table: pd.DataFrame) -> list[tuple[str, str, str, str, str]]:
    """Returns the rows of a summary as text in field units: name, mean, range, spread, unit."""
    rows: list[tuple[str, str, str, str, str]] = []
    for name, (mean, low, high, spread, si) in table.iterrows():
        for factor, named in (quantities.displayed(str(name), si), *MORE.get(str(name), ())):
            sides = "" if math.isnan(low) else interval(factor * low, factor * high)
            value, wide = _digits(factor * mean, factor * spread)
            rows.append((str(name), value, sides, wide, "" if named == "1" else named))
    return rows


def _digits(mean: float, spread: float) -> tuple[str, str]:
    """Returns a mean with four digits and its spread with two, no finer than the coarser one."""
    ends = [(abs(mean), 3), (spread, 1)]
    place = min([p - math.floor(math.log10(x)) for x, p in ends if 0.0 < x < math.inf], default=3)
    number, wide, least = (
        f"{round(x, place):.{max(place, 0)}f}" for x in (mean, spread, 10.0**-place)
    )
    if math.isnan(spread):
        return number, ""
    return number, f"± {wide}" if float(wide) else f"< {least}"


#: Further units in which a quantity is displayed, with their factors.
MORE = {"rate of penetration": ((60.0, "m/min"),)}


def readable(table: pd.DataFrame) -> str:
    """Returns a summary as text."""
    return "\n".join(
        f"  {name:34}{mean:>8}  {sides:14}{spread:19}{unit}".rstrip()
        for name, mean, sides, spread, unit in (HEADS, *displayed(table))
    )


def _moments(values: Array) -> tuple[float, float]:
    return float(values.mean()), _spread(values)


def _spread(values: Array) -> float:
    """Standard deviation of one value, estimated from several."""
    return float(values.std(ddof=1))
