"""A drilling log to the rock's specific energy over depth: `specific_energy`.

After Izquierdo and Chiang (*specific rock energy index using corrected down-the-hole drill
monitoring data*): rate, air pressure, pull-down, and the blows' frequency where it was heard, go
through the simulated hammer to the work that breaks a volume of rock.
"""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from .. import _native, outputs
from ..contract import typed
from ..errors import DomainError, warn
from ..scene.datasheet import Datasheet
from ..scene.quantities import NUMBER, UNIT, read
from ..scene.variables import VARIABLES, Array
from .longrun import FEWEST, Wanted, responses
from .trends import table_of

#: What a log may have: SI unit, unit of the field, and what its column may be called.
COLUMNS: Mapping[str, tuple[str, str, str]] = {
    "depth": ("m", "m", "dept md holedepth"),
    "rop": ("m/s", "m/h", "rate penetrationrate rateofpenetration"),
    "pressure": ("Pa", "bar", "airpressure"),
    "feed": ("N", "kN", "feedforce pulldown wob"),
    "frequency": ("Hz", "1/min", "blowfrequency blows"),
}
#: Null values of logs.
NULLS = (-999.25, -9999.0, "", "nan", "null", "none", "n/a")
#: Nodes over pressure and feed between which hammers are interpolated, in logarithms.
NODES = 5
#: Standard error of a frequency that is heard; so many beyond which it is of no hammer.
HEARD, STRANGE = 0.02, 3.0
#: A rate that the sheet's hammers are measured with, m/s: each row's is put in its place.
RATE = 1e-2


@typed()
def specific_energy(sheet: Datasheet, log: pd.DataFrame | str | Path) -> pd.DataFrame:
    """Returns the rock's specific energy over the depth of a hole, with the range of 80 %.

    Each row's rate is that of the sheet's hammers at its pressure, feed and heard frequency, each
    of them simulated. Rows with a null (0, -999.25, -9999, empty) and idle ones, whose rate,
    pressure or feed is not above 0, are left out, and told.

    Args:
        sheet: of the hammer.
        log: a table or a .csv or .parquet file with ``depth``, ``rop``, ``pressure`` (of the air),
            and ``feed`` and ``frequency`` if they are known. Units stand in the heading
            (``rop [m/h]``), in the row below it, or with each value; SI otherwise.

    Example:
        >>> import pandas as pd
        >>> from dth_hammer import from_datasheet, specific_energy
        >>> sheet = from_datasheet(od="124 mm", pressure="24 bar", power="31.7 kW", hole="140 mm")
        >>> hole = {"depth [m]": [10, 11], "rop [m/h]": [25, 18], "pressure [bar]": [22, 24]}
        >>> found = specific_energy(sheet, pd.DataFrame(hole))["specific_energy"]
        >>> print(f"{found[1] / found[0]:.2f} times as hard to drill a metre below")
        1.56 times as hard to drill a metre below
    """
    rows = _rows(log if isinstance(log, pd.DataFrame) else outputs.read(Path(log)))
    base = sheet.but(rop=RATE, at=None)
    nodes, at = _nodes(rows["pressure"]), np.log(rows["pressure"])
    there = [base.but(at=float(np.exp(node))) for node in nodes]
    # A row each, a member a column: the power to the rock over the share that the sheet's own blows
    # give it, if all rows had the sheet's feed.
    power, pace = (
        _between(at, nodes, np.log([node.members[name] for node in there]))
        for name in ("power to the rock", "frequency")
    )
    power -= np.log(base.members["work to the rock over blow energy"].to_numpy())
    if "frequency" in rows:
        power += _heard(power, pace, np.log(rows["frequency"].to_numpy()))
    if "feed" in rows:
        feeds = _nodes(rows["feed"])
        shares = _between(at, nodes, _fed(there, np.exp(feeds)))
        pairs = zip(np.log(rows["feed"]), shares, strict=True)
        power += np.array([[np.interp(feed, feeds, row)] for feed, row in pairs])
    own = (base.members["specific energy"] / base.members["power of the blows"]).to_numpy()
    energy = np.exp(power) * own * (RATE / rows["rop"].to_numpy())[:, None]
    weights = base.members["weight"].to_numpy()
    names = [f"specific_energy{side}" for side in ("", "_low", "_high")]
    rows = rows.join(pd.DataFrame([_native.spread(row, weights) for row in energy], columns=names))
    for kind, unit, which in (("units", "J/m3", 0), ("display_units", "MJ/m3", 1)):
        rows.attrs[kind] = {n: of[which] for n, of in COLUMNS.items()} | dict.fromkeys(names, unit)
    return rows


def _rows(table: pd.DataFrame) -> pd.DataFrame:
    """The numbers of a log, SI: a row each that was drilled."""
    found: dict[str, Array] = {}
    for heading in table:
        word, unit = re.fullmatch(r"(.*?)\s*(?:[\[(](.*)[\])])?\s*", str(heading)).groups()  # type: ignore[union-attr]
        word = re.sub(r"[\W_]", "", word).lower()
        for name, (si, _, others) in COLUMNS.items():
            if word == name or word in others.split():
                found[name] = _numbers(table[heading], name, si, unit)
    if missing := [name for name in ("depth", "rop", "pressure") if name not in found]:
        raise DomainError(f"there is no {' nor '.join(missing)}, but {', '.join(map(str, table))}")
    rows = pd.DataFrame(found, index=table.index)
    rest = rows.drop(columns=["depth", "frequency"], errors="ignore")
    drilled = rows["depth"].notna() & (rest > 0.0).all(axis=1)
    if idle := int((~drilled & rows.notna().any(axis=1)).sum()):
        warn(f"{idle} of {len(rows)} rows of the log are null or idle and are left out")
    if not drilled.any():
        raise DomainError("no row of the log has a rate and a pressure above 0")
    rows = rows[drilled].reset_index(drop=True)
    return rows.where((rows > 0.0) | (rows.columns == "depth"))


def _numbers(cells: pd.Series, name: str, si: str, unit: str | None) -> Array:
    """A column's numbers, SI; NaN of a null, and of the row of units."""
    first = str(cells.iloc[0]).strip() if len(cells) else ""
    if UNIT.fullmatch(first) and first.lower() not in NULLS:
        unit = unit or first

    def one(cell: object) -> float:
        text = str(cell).strip()
        number = NUMBER.fullmatch(text)
        if number is None or number[2].startswith("/") or float(number[1]) in NULLS:
            return np.nan
        return read(text if number[2] or not unit else f"{text} {unit}", si, name)

    return np.array([one(cell) for cell in cells])


def _nodes(values: pd.Series) -> Array:
    """Logarithms from that of the least value to that of the largest."""
    low, high = np.log([values.min(), values.max()])
    return np.linspace(low, high, NODES if high > 0.01 + low else 1)


def _between(places: pd.Series, nodes: Array, table: Array) -> Array:
    """Rows of a table, of which there is one a node, at places between these."""
    return np.array([np.interp(places, nodes, column) for column in table.T]).T


def _heard(power: Array, pace: Array, heard: Array) -> Array:
    """How far each member's power moves if its frequency does to what was heard, in logarithms."""
    off = heard[:, None] - pace
    wide = np.hypot(pace.std(axis=1), HEARD)
    strange = np.abs(off.mean(axis=1)) > STRANGE * wide
    if strange.any():
        warn(f"{strange.sum()} frequencies of the log are of no hammer of this sheet")
    about = (pace - pace.mean(axis=1)[:, None], power - power.mean(axis=1)[:, None])
    gain = np.mean(about[0] * about[1], axis=1) / wide**2
    noise = HEARD * np.random.default_rng(1).standard_normal(pace.shape[1])
    return np.asarray(np.nan_to_num(gain[:, None] * (off + noise)))


def _fed(there: list[Datasheet], feeds: Array) -> Array:
    """Logarithm of the power to the rock over that under the sheet's own feed, a row for each
    sheet: of simulated rigid hammers.
    """
    rigid = {"fidelity": VARIABLES["fidelity"].number("Rigid")}
    plain = [{**node.parameters, **rigid} for node in there]
    scenes = [scene | feed for scene in plain for feed in ({}, *({"feed_force": f} for f in feeds))]
    found = responses(scenes, Wanted(error={"rop": 0.02}, blows=FEWEST))
    table = np.log(table_of(found, ["rop"])[0]).reshape(len(plain), -1)
    return np.asarray(table[:, 1:] - table[:, :1])
