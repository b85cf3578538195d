"""The numbers of a hammer that an engineer reports, in field units."""

from __future__ import annotations

from collections.abc import Mapping

from .. import _native
from ..errors import TooFewBlowsError
from ..frames import pd
from ..scene.band import band
from ..scene.datasheet import Datasheet
from ..scene.quantities import Fixed, displayed
from ..simulation.diagram import Waves
from ..simulation.run import Run
from ..study.fatigue import Life

#: Name of the row with the bit's rotation speed.
TURNS = "rotation for 10 to 19 mm of advance per turn"
#: Rows of a run's summary to report; a datasheet has ranges for numbers of the same names.
SUMMARISED = (
    *("rate of penetration", "frequency", "blow energy", "impact speed", "power of the blows"),
    *("work to the rock over blow energy", "power to the rock", "free air"),
)
#: Display units of numbers that differ from the default display unit.
DISPLAY_UNITS: Mapping[str, str] = {
    **{"frequency": "1/min", TURNS: "1/min", "oil or water taken": "l/min"},
    "life of what breaks first": "h",
}
#: Numbers that only a datasheet provides, not a run.
SHEET_ONLY = (
    *("piston mass", "feed", "bore", "height where the piston turns"),
    *(TURNS, "advance per turn"),
    "up-hole velocity of the air",
)
FLOWS = {"air_flow": "free air", "flow": "oil or water taken"}
FORCES = {"contact_force_peak": "largest contact force", "rock_force_peak": "largest rock force"}
Row = tuple[float, float, float, str]


def headline(
    run: Run, sheet: Datasheet | None, waves: Waves | None, life: Life | None
) -> pd.DataFrame:
    """Returns the numbers of a hammer, one per column.

    The rows are ``value``, ``least`` and ``largest``; the last two are the ends of the range that
    remains because some numbers are not known. Forces are the largest of the second half of the
    run, stresses those of the last blow.
    """
    blow_rows = _blows(run, sheet)
    # If the engine simulates the air, its consumption in the run replaces the datasheet's.
    rows = {**blow_rows, **(_drive(sheet) | blow_rows), **_loads(run, waves, sheet)}
    if life is not None:
        seconds, factor = 3600.0 * float(life.worst["hours"]), 1.0 + life.life_error
        rows["life of what breaks first"] = seconds, seconds / factor, seconds * factor, "s"
    table = pd.DataFrame(
        {name: row[:3] for name, row in rows.items()}, index=["value", "least", "largest"]
    )
    units = {name: row[3] for name, row in rows.items()}
    display = {
        name: DISPLAY_UNITS.get(name) or displayed(name, unit)[1] for name, unit in units.items()
    }
    table.attrs = {"units": Fixed(units), "display_units": Fixed(display)}
    return table


def _plain(number: float, unit: str) -> Row:
    return number, number, number, unit


def _blows(run: Run, sheet: Datasheet | None) -> dict[str, Row]:
    """Returns the numbers of a run's summary, with the ranges of a datasheet if there is one."""
    try:
        summary = run.summary()
    except TooFewBlowsError:
        return {}
    means, units = summary["mean"].to_dict(), summary["unit"].to_dict()
    rows: dict[str, Row] = {}
    for name in SUMMARISED:
        if name not in means:
            continue
        mean, unit = float(means[name]), str(units[name])
        rows[name] = _plain(mean, unit)
        if sheet is not None and name in sheet.ranges:
            # Use the datasheet's own value, because the run is that of its median hammer.
            sheet_value = next(value for found, value, _ in sheet.found if found == name)
            rows[name] = sheet_value, *sheet.ranges[name], unit
        elif name == "rate of penetration":
            low, high = band(mean, run.parameters)
            rows[name], turn = (mean, low, high, unit), _native.TURN
            rows[TURNS] = mean / turn, low / turn, high / turn, "Hz"
    return rows


def _drive(sheet: Datasheet | None) -> dict[str, Row]:
    """Returns the drive's numbers that a datasheet determines, and its use of air or liquid."""
    if sheet is None:
        return {}
    rows: dict[str, Row] = {
        FLOWS[name]: _plain(own, unit) for name, _, own, unit, _ in sheet.compared if name in FLOWS
    }
    for name, value, unit in sheet.found:
        if name in SHEET_ONLY:
            rows[name] = value, *sheet.ranges[name], unit or "1"
    return rows


def _loads(run: Run, waves: Waves | None, sheet: Datasheet | None) -> dict[str, Row]:
    """Returns the largest forces and stresses, with the ranges that a datasheet implies."""
    converted = run.convert("si")
    blows = converted.blows
    late = blows[blows["blow_time"] >= converted.frame.index[-1] / 2]
    rows = {
        label: _plain(float(late[name].max()), "N")
        for name, label in FORCES.items()
        if name in late and late[name].notna().any()
    }
    for body in ("piston", "bit") if waves is not None else ():
        stress = getattr(waves, body).stress
        rows[f"largest tension in the {body}"] = _plain(float(stress.max()), "Pa")
        rows[f"largest compression in the {body}"] = _plain(float(-stress.min()), "Pa")
    if sheet is None:
        return rows
    # Forces and stresses are proportional to the impact speed, so they have its relative range
    # where the datasheet has no range of their own.
    own_values = {name: value for name, value, _ in sheet.found}
    for name, (value, _, _, unit) in rows.items():
        scaling_name = name if name in own_values else "impact speed"
        low, high = (value * side / own_values[scaling_name] for side in sheet.ranges[scaling_name])
        rows[name] = value, low, high, unit
    return rows
