"""Computes the rock's specific energy over depth from a drilling log: `specific_energy`.

After Izquierdo and Chiang (*specific rock energy index using corrected down-the-hole drill
monitoring data*): the simulated hammer converts rate, air pressure, pull-down and (if it was
recorded) the blows' frequency to the work that breaks a volume of rock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .. import _native, tables
from ..contract import typed
from ..errors import DomainError, warn
from ..frames import np, pd
from ..scene.datasheet import Datasheet
from ..scene.hammers import Hammerlike, numbers_of
from ..scene.variables import VARIABLES, Array, whole
from .comparison import OF_SCENES, WANTED
from .longrun import FEWEST, Wanted, responses
from .measurements import RANGES
from .trends import table_of

#: Columns of a log, with units for messages. Impossible values count as missing.
FIELDS = [tables.Field("depth", "m", tables.SYNONYMS["depth"], (-500.0, 15e3), "m")] + [
    tables.Field(name, si, tables.SYNONYMS[name], RANGES[name], display)
    for name, si, display in (
        *(("rop", "m/s", "m/h"), ("pressure", "Pa", "bar"), ("feed", "N", "kN")),
        ("frequency", "Hz", "1/min"),
    )
]
NEEDED = ("depth", "rop", "pressure")
#: Most nodes over pressure and feed, between which hammers are interpolated in logarithms, and the
#: distance of nodes if there are fewer.
NODES, APART = 5, 0.15
#: Relative standard error of a recorded frequency; number of errors beyond which it is implausible.
FREQUENCY_ERROR, IMPLAUSIBLE = 0.02, 3.0
#: Number of random members for a scene, and the standard error of a measured rate.
MEMBERS = 240
SCATTER = {row[0]: row[5] for row in _native.datasheet_numbers()}["rop"]
#: Rate at which the sheet's hammers are solved, m/s; each row's rate then replaces it.
RATE = 1e-2
#: Plausible specific energies, J/m3: about 1 to 1.4 times strengths of 8 to 400 MPa, within a
#: factor of 1.6.
ROCKS = (5e6, 900e6)
#: The number of the drive's source for hammers under air.
AIR = VARIABLES["drive.source"].number("Air")
#: If pressure or feed differ from the sheet's by this factor, their unit may be wrong.
BEYOND = 4.0


@typed()
def specific_energy(
    sheet: Hammerlike,
    log: pd.DataFrame | str | Path,
    *,
    unit: Mapping[str, str] | None = None,
    column: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Returns the rock's specific energy over the depth of a hole, with 80 % ranges.

    The sheet's hammers are simulated at each row's pressure, feed and frequency, and the row's rate
    gives the specific energy. A hammer without datasheet is taken as known to 5 %. Rows are left
    out if rate, pressure or depth is missing (empty, a null value of LAS files and rigs, a word),
    impossible, or 0 (idle). A value far from all others is used. Warnings list these rows and
    values with their depth. ``attrs["said"]`` of the result has a sentence for each column, also
    about its effect on the range. The result also has the columns that are not used.

    Args:
        sheet: the hammer's datasheet, or anything else that `simulate` takes if air drives it; the
            log's pressure replaces its own.
        log: a table, or a file (.csv, .tsv, .txt, .parquet, .xlsx, .las), with the depth, the rate,
            the pressure of the air, and the feed and the blows' frequency if they are known. Units
            are in the heading (``ROP [m/h]``), in the row below it or with each value; a rate may
            also be in min/m.
        unit: units of columns without unit: ``{"rop": "m/h"}``.
        column: headings by name, if they are ambiguous or unknown: ``{"rop": "ROP_1"}``; ``"none"``
            for a column that is not to be read.

    Raises:
        DomainError: a column has no unit, two columns have one meaning, or no row has a rate.

    Example:
        >>> import pandas as pd
        >>> from dth_hammer import from_datasheet, specific_energy
        >>> sheet = from_datasheet(od="124 mm", pressure="24 bar", power="31.7 kW", hole="140 mm")
        >>> hole = {"depth [m]": [10, 11], "rop [m/h]": [25, 18], "pressure [bar]": [22, 24]}
        >>> found = specific_energy(sheet, pd.DataFrame(hole))["specific_energy"]
        >>> print(f"{found[1] / found[0]:.2f} times as hard to drill a metre below")
        1.55 times as hard to drill a metre below
    """
    rows, others, grid = tables.columns_of(log, FIELDS, unit, column)
    if missing := [name for name in NEEDED if name not in rows]:
        heads = ", ".join(grid.heads)
        raise DomainError(f"there is no {' nor '.join(missing)}, but {heads}; column= names one")
    drilled = rows["depth"].notna() & (rows[["rop", "pressure"]] > 0.0).all(axis=1)
    if idle := int((~drilled).sum()):
        warn(f"{idle} of {len(rows)} rows of the log are null, idle or told below and are left out")
    for text in tables.sentences(grid.problems):
        warn(text)
    if not drilled.any():
        raise DomainError("no row of the log has a depth, and a rate and a pressure above 0")
    rows = rows[drilled]
    nodes = _nodes(rows["pressure"])
    hammers = _of_sheet(sheet, nodes) if isinstance(sheet, Datasheet) else _of_scene(sheet, nodes)
    power, used = _powers(hammers, nodes, rows)
    energy = np.exp(power) * hammers.energy_rate / rows["rop"].to_numpy()[:, None]
    names = [f"specific_energy{side}" for side in ("", "_low", "_high")]
    answer = pd.DataFrame(
        [_native.spread(row, hammers.weights) for row in energy], columns=names, index=rows.index
    )
    answer = pd.concat([rows, answer], axis=1)
    for text in tables.sentences(suspicions(hammers.scene, answer)):
        warn(text)
    others = others[drilled].rename(columns={n: f"{n} (of the log)" for n in names})
    answer = pd.concat([answer, others], axis=1)
    for kind, size, which in (("units", "J/m3", "unit"), ("display_units", "MJ/m3", "display")):
        known = {of.name: getattr(of, which) for of in FIELDS if of.name in rows}
        answer.attrs[kind] = known | dict.fromkeys(names, size)
    answer.attrs["said"] = [*grid.notes, *used]
    return answer


@dataclass(frozen=True)
class _Hammers:
    """The hammers of a log: a scene, and members at nodes of the pressure (one row each)."""

    scene: Mapping[str, float]
    scenes: Sequence[Mapping[str, float]]
    #: Logarithms of the power to the rock (W), of the frequency, and of the feed if none is known.
    power: Array
    frequency: Array
    feed: Array
    #: Specific energy times rate, over that power; and the statistical weight of a member.
    energy_rate: Array
    weights: Array


def _of_sheet(sheet: Datasheet, nodes: Array) -> _Hammers:
    """Returns the sheet's hammers, with the specific energies for a known rate."""
    base = sheet.but(rop=RATE, at=None)
    there = [base.but(at=float(pressure)) for pressure in np.exp(nodes)]
    power, frequency = (
        np.log([node.members[name] for node in there])
        for name in ("power to the rock", "frequency")
    )
    own = RATE * base.members["specific energy"] / base.members["power of the blows"]
    own /= base.members["work to the rock over blow energy"]
    feed, weights = np.log(base.members["feed"].to_numpy()), base.members["weight"].to_numpy()
    scenes = [node.parameters for node in there]
    return _Hammers(sheet.parameters, scenes, power, frequency, feed, own.to_numpy(), weights)


def _of_scene(hammer: Hammerlike, nodes: Array) -> _Hammers:
    """Returns a known hammer; members differ by errors of energy, frequency and measured rate."""
    scene = numbers_of(hammer)
    full = whole(scene)
    if full["drive.source"] != AIR:
        raise DomainError("a log has the pressure of the air, which does not drive this hammer")
    there = [{**scene, "supply_pressure": p + full["exhaust_pressure"]} for p in np.exp(nodes)]
    found = responses(there, Wanted(error={"rop": WANTED}, second=True))
    if refused := [text for text in found if isinstance(text, str)]:
        raise DomainError(f"this hammer has no long-run response: {refused[0]}")
    works = ["energy_rock_dissipated", "energy_viscous", "blow_frequency"]
    *work, frequencies = table_of(found, works)[0].T
    normal = np.random.default_rng(2).standard_normal((3, MEMBERS))
    frequency, energy = OF_SCENES / np.sqrt(2.0) * normal[:2]
    power = np.log(sum(work) * frequencies)[:, None] + energy + frequency
    own = np.exp(SCATTER * normal[2]) / (0.25 * np.pi * full["hole.diameter"] ** 2)
    feed = np.full(MEMBERS, np.log(max(full["feed_force"], 1.0)))
    frequency = np.log(frequencies)[:, None] + frequency
    return _Hammers(scene, there, power, frequency, feed, own, np.ones(MEMBERS))


def _powers(hammers: _Hammers, nodes: Array, rows: pd.DataFrame) -> tuple[Array, list[str]]:
    """Returns the logarithm of the power (a row per row, a column per member), and sentences."""
    at = np.log(rows["pressure"])
    power, frequency = (
        _interpolated(at, nodes, table) for table in (hammers.power, hammers.frequency)
    )
    ends = np.exp([power.mean(axis=1).min(), power.mean(axis=1).max()]) / 1e3
    used = [
        "the pressure is used: by it the power to the rock is {:.3g} to {:.3g} kW".format(*ends)
    ]

    known = {
        name: (rows[name] > 0.0).to_numpy() if name in rows else np.zeros(len(rows), dtype=bool)
        for name in ("feed", "frequency")
    }
    has_feed, has_frequency = known["feed"], known["frequency"]
    # In a row without feed each member has its own.
    power += (own := _own_feed_effect(hammers))
    if not has_feed.any():
        used.append(f"no feed is known: it is that of the hammer, {_wider(power, power - own)}")
    else:
        before, feeds = power[has_feed].copy(), _nodes(rows["feed"][has_feed])
        shares = _interpolated(at[has_feed], nodes, _feed_effect(hammers.scenes, np.exp(feeds)))
        values = np.log(rows["feed"].to_numpy()[has_feed])
        moved = [np.interp(feed, feeds, row) for feed, row in zip(values, shares, strict=True)]
        power[has_feed] += np.array(moved)[:, None] - own
        low, high = np.exp([min(moved), max(moved)])
        used.append(
            f"the feed is used in {has_feed.sum()} of {len(rows)} rows: by it the power is "
            f"{low:.2f} to {high:.2f} of that at the hammer's own, "
            f"{_wider(power[has_feed], before)}"
        )
    if not has_frequency.any():
        used.append("no frequency is known: it is that of the hammer")
    else:
        before = power[has_frequency].copy()
        values = np.log(rows["frequency"].to_numpy()[has_frequency])
        power[has_frequency] += _frequency_effect(before, frequency[has_frequency], values)
        used.append(
            f"the frequency is used in {has_frequency.sum()} of {len(rows)} rows, "
            f"{_wider(power[has_frequency], before)}"
        )
    return power, used


def _wider(now: Array, before: Array) -> str:
    share = now.std(axis=1).mean() / before.std(axis=1).mean()
    return f"which makes the range of the power {share:.2f} times as wide"


def _own_feed_effect(hammers: _Hammers) -> Array:
    """Returns the logarithm of each member's power at its own feed over that at the scene's."""
    _, low, high = np.log(_native.spread(np.exp(hammers.feed), hammers.weights))
    if high - low < 1e-6:
        return np.zeros(len(hammers.feed))
    feeds, middle = np.linspace(low, high, NODES), len(hammers.scenes) // 2
    shares = _feed_effect(hammers.scenes[middle : middle + 1], np.exp(feeds))[0]
    return np.asarray(np.interp(hammers.feed, feeds, shares))


def suspicions(scene: Mapping[str, float], rows: pd.DataFrame) -> dict[str, list[str]]:
    """Returns, by kind, pressures and feeds unlike the sheet's, and implausible energies."""
    known, problems = whole(scene), dict[str, list[str]]()
    usual = {"pressure": known["supply_pressure"] - known["exhaust_pressure"]}
    usual = usual if known["drive.source"] == AIR else {}
    usual["feed"] = known["feed_force"]
    limits = {name: (own / BEYOND, own * BEYOND) for name, own in usual.items() if own > 0.0}
    limits["specific_energy"] = ROCKS
    for of in (*FIELDS, tables.Field("specific_energy", "J/m3", display="MJ/m3")):
        low, high = limits.get(of.name, (-np.inf, np.inf))
        for label, depth, value in zip(
            rows.index, rows["depth"], rows.get(of.name, ()), strict=False
        ):
            if value < low or value > high:
                sides = f"{of.text(low)} to {of.text(high)}"
                kind = f"{of.name} beyond {sides} of this hammer or of rocks; is the unit right?"
                case = f"row {label}, depth {depth:.6g} m: {of.text(value)}"
                problems.setdefault(kind, []).append(case)
    return problems


def _nodes(values: pd.Series) -> Array:
    """Returns logarithms that are evenly spaced from the least value to the largest."""
    low, high = np.log([values.min(), values.max()])
    return np.linspace(low, high, min(NODES, 1 + int(np.ceil((high - low - 0.01) / APART))))


def _interpolated(places: pd.Series, nodes: Array, table: Array) -> Array:
    """Interpolates the rows of a table, which has one row per node."""
    return np.array([np.interp(places, nodes, column) for column in table.T]).T


def _frequency_effect(power: Array, frequency: Array, recorded: Array) -> Array:
    """Returns by how much each member's power changes, in logarithms, with a recorded frequency."""
    off = recorded[:, None] - frequency
    wide = np.hypot(frequency.std(axis=1), FREQUENCY_ERROR)
    is_implausible = np.abs(off.mean(axis=1)) > IMPLAUSIBLE * wide
    if is_implausible.any():
        warn(f"{is_implausible.sum()} frequencies of the log are of no hammer of this sheet")
    about = (frequency - frequency.mean(axis=1)[:, None], power - power.mean(axis=1)[:, None])
    gain = np.mean(about[0] * about[1], axis=1) / wide**2
    noise = FREQUENCY_ERROR * np.random.default_rng(1).standard_normal(frequency.shape[1])
    return np.asarray(np.nan_to_num(gain[:, None] * (off + noise)))


def _feed_effect(there: Sequence[Mapping[str, float]], feeds: Array) -> Array:
    """Returns the power to the rock at each feed, relative to that at a scene's own, as logarithms.

    There is one row per scene and one column per feed. The hammers are simulated as rigid bodies.
    """
    rigid = {"fidelity": VARIABLES["fidelity"].number("Rigid")}
    plain = [{**scene, **rigid} for scene in there]
    scenes = [scene | feed for scene in plain for feed in ({}, *({"feed_force": f} for f in feeds))]
    found = responses(scenes, Wanted(error={"rop": 0.02}, blows=FEWEST))
    table = np.log(table_of(found, ["rop"])[0]).reshape(len(plain), -1)
    return np.asarray(table[:, 1:] - table[:, :1])
