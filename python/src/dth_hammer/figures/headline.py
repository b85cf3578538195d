"""The numbers of a hammer that an engineer reports, in field units."""

from collections.abc import Mapping

import pandas as pd

from .. import _native
from ..errors import TooFewBlowsError
from ..run.diagram import Waves
from ..run.run import Run
from ..scene.band import band
from ..scene.datasheet import Datasheet
from ..scene.quantities import Fixed, displayed
from ..study.fatigue import Life

#: What a bit turns.
TURNS = "rotation for 10 to 19 mm of advance per turn"
#: Rows of a summary that are told; a datasheet has ranges of numbers of the same names.
SUMMARISED = (
    *("rate of penetration", "frequency", "blow energy", "impact speed", "power of the blows"),
    *("work to the rock over blow energy", "power to the rock", "free air"),
)
#: Units in which a number is shown, where not as any is told.
SHOWN: Mapping[str, str] = {
    **{"frequency": "1/min", TURNS: "1/min", "oil or water taken": "l/min"},
    "life of what breaks first": "h",
}
#: What a datasheet finds that a run does not have.
FOUND = (
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
    """Numbers of a hammer, a column each; rows ``value``, ``least`` and ``largest``.

    ``least`` and ``largest`` are those of the range of what is not determined. Forces and stresses
    are the largest of the run's second half and of the last blow.
    """
    blows = _blows(run, sheet)
    # The air of a hammer with its air inside is that of its blows.
    rows = {**blows, **(_drive(sheet) | blows), **_loads(run, waves, sheet)}
    if life is not None:
        seconds, factor = 3600.0 * float(life.worst["hours"]), 1.0 + life.life_error
        rows["life of what breaks first"] = seconds, seconds / factor, seconds * factor, "s"
    table = pd.DataFrame(
        {name: row[:3] for name, row in rows.items()}, index=["value", "least", "largest"]
    )
    units = {name: row[3] for name, row in rows.items()}
    display = {name: SHOWN.get(name) or displayed(name, unit)[1] for name, unit in units.items()}
    table.attrs = {"units": Fixed(units), "display_units": Fixed(display)}
    return table


def _plain(number: float, unit: str) -> Row:
    return number, number, number, unit


def _blows(run: Run, sheet: Datasheet | None) -> dict[str, Row]:
    """Rate, blows, energy, power, share; with the ranges of a datasheet if there is one."""
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
            # As the sheet tells it: the run is of its middle hammer alone.
            own = next(value for found, value, _ in sheet.found if found == name)
            rows[name] = own, *sheet.ranges[name], unit
        elif name == "rate of penetration":
            low, high = band(mean, run.parameters)
            rows[name], turn = (mean, low, high, unit), _native.TURN
            rows[TURNS] = mean / turn, low / turn, high / turn, "Hz"
    return rows


def _drive(sheet: Datasheet | None) -> dict[str, Row]:
    """What a datasheet finds of the drive, and the air or the liquid that it takes."""
    if sheet is None:
        return {}
    rows: dict[str, Row] = {
        FLOWS[name]: _plain(own, unit) for name, _, own, unit, _ in sheet.compared if name in FLOWS
    }
    for name, value, unit in sheet.found:
        if name in FOUND:
            rows[name] = value, *sheet.ranges[name], unit or "1"
    return rows


def _loads(run: Run, waves: Waves | None, sheet: Datasheet | None) -> dict[str, Row]:
    """Largest forces and stresses."""
    half = run.convert("si").frame
    half = half[half.index >= half.index[-1] / 2]
    rows = {
        label: _plain(float(half[name].max()), "N")
        for name, label in FORCES.items()
        if name in half
    }
    for body in ("piston", "bit") if waves is not None else ():
        stress = getattr(waves, body).stress
        rows[f"largest tension in the {body}"] = _plain(float(stress.max()), "Pa")
        rows[f"largest compression in the {body}"] = _plain(float(-stress.min()), "Pa")
    if sheet is None:
        return rows
    # Waves grow with the speed of the impact.
    found = {name: value for name, value, _ in sheet.found}
    for name, (value, _, _, unit) in rows.items():
        of = name if name in found else "impact speed"
        low, high = (value * side / found[of] for side in sheet.ranges[of])
        rows[name] = value, low, high, unit
    return rows
