"""Measurements, free parameters, and the hammers that were simulated to fit them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from .. import _native, tables
from ..errors import DomainError, RefusedError, warn
from ..frames import np
from ..scene.quantities import alike, read
from ..scene.variables import VARIABLES, Array, Value, whole
from ..simulation.gradients import differentiable
from ..simulation.records import Record, simulated
from .longrun import MEANS, Wanted, named, responses, unit
from .trends import sobol, table_of

#: A value with its standard error, or repeated measurements; None and NaN are missing.
Measured = tuple[Value, Value] | Collection[Value | None]
#: Free parameters: their names, or bounds by name (None for default bounds).
Free = Sequence[str] | Mapping[str, tuple[Value, Value] | None]

#: Default bounds of a parameter, as a factor both ways.
FACTOR = 3.0
#: Means that are not variables of the engine, and are positive if there are blows.
RATES_OF_BLOWS = ("blow_frequency", "period")
#: Means that datasheets also have, with the names there; a datasheet's range applies to them.
SHEETS = {"rop": "rop", "blow_energy": "blow_energy", "blow_frequency": "frequency"}
SHEETS |= {"blow_speed": "impact_speed"}
RANGES = {row[0]: row[4] for row in _native.datasheet_numbers()}
DISPLAY_UNITS = {row[0]: row[2] for row in _native.datasheet_numbers()}
#: Standard errors from the middle of a normal distribution to the ends of its 80 % range.
EIGHTY = 1.2816
#: A hammer meets the measurements within this many errors; modes this close in logarithms are one.
CONFIRMED, SAME = 4.0, 0.01
LEAST = 3
GIVE = "give (value, standard error), or three or more values"


@dataclass
class Problem:
    """Measurements, free parameters, and the hammers simulated so far."""

    names: list[str]
    #: Logarithms of the start, and of the bounds.
    start: Array
    low: Array
    high: Array
    given: Mapping[str, float]
    means: list[str]
    records: Sequence[Record]
    values: Array
    errors: Array
    wanted: Wanted
    progress: bool = False
    #: Logarithms of the simulated points, and their responses.
    logs: list[Array] = field(default_factory=list)
    found: list[Array] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)

    def holds(self, logs: Array) -> bool:
        """Returns whether a point is within the bounds."""
        return bool((logs >= self.low - 1e-12).all() and (logs <= self.high + 1e-12).all())

    def numbers(self, logs: Array) -> dict[str, float]:
        """Returns the parameters of the hammer at a point."""
        return {**self.given, **dict(zip(self.names, map(float, np.exp(logs)), strict=True))}

    def at(self, points: Array) -> Array:
        """Returns responses of hammers, one row per point; NaN if there is none."""
        values = np.full((len(points), len(self.values)), np.nan)
        scenes = [self.numbers(logs) for logs in points]
        if self.means:
            found = responses(scenes, self.wanted, progress=self.progress)
            self.refused += [answer for answer in found if isinstance(answer, str)]
            values[:, : len(self.means)] = table_of(found, self.means)[0]
        for k, scene in enumerate(scenes) if self.records else ():
            try:
                samples = [simulated(record, scene) for record in self.records]
                values[k, len(self.means) :] = np.concatenate(samples)
            except (DomainError, RefusedError) as error:
                self.refused.append(str(error))
        return values

    def add_design(self, count: int, seed: int) -> None:
        """Simulates points that are spread over the whole range."""
        box = sobol(len(self.names), count, seed)[:count]
        self.add(0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * box)

    def add(self, points: Array) -> None:
        """Simulates points and stores their responses."""
        self.logs += [*points]
        self.found += [*self.at(points)]

    def confirmed(
        self, peaks: list[tuple[Array, float]], members: Array
    ) -> tuple[list[tuple[Array, float]], Array]:
        """Returns the modes whose hammers, when simulated, meet the measurements, and their
        members.

        If there is no such mode, the first mode and all members are returned.
        """
        off = np.abs(self.at(np.array([peak for peak, _ in peaks])) - self.values) / self.errors
        places: list[Array] = []
        own = np.full(len(peaks), -1)
        for k in np.flatnonzero((off <= CONFIRMED).all(axis=1)):
            near = [i for i, p in enumerate(places) if np.abs(p - peaks[k][0]).max() < SAME]
            own[k] = near[0] if near else len(places)
            places += [] if near else [peaks[k][0]]
        if not places:
            return peaks[:1], members
        wide = np.ptp(members, axis=0) + 1e-12
        apart = [np.sum(((members - peak) / wide) ** 2, axis=1) for peak, _ in peaks]
        of = own[np.argmin(apart, axis=0)]
        shares = np.bincount(of[of >= 0], minlength=len(places)) / np.sum(of >= 0)
        modes = sorted(zip(places, map(float, shares), strict=True), key=lambda mode: -mode[1])
        return modes, members[of >= 0]


def problem_of(
    measured: Mapping[str, Measured] | tables.Source,
    free: Free,
    given: Mapping[str, float],
    records: Sequence[Record],
    wanted: Wanted,
) -> Problem:
    """Checks the arguments."""
    listed = measured if isinstance(measured, Mapping) else _columns(measured)
    rows = {name: _measured(name, numbers) for name, numbers in listed.items()}
    means = {name: row for name, row in rows.items() if row is not None}
    names = differentiable(free)
    if not (means or records) or not names:
        raise DomainError("give what was measured, and which parameters are free")
    table = np.array([*means.values()], dtype=float).reshape(len(means), 2)
    values = np.concatenate([table[:, 0], *(r.values for r in records)])
    errors = np.concatenate([table[:, 1], *(r.errors for r in records)])
    known = whole(given)
    if "rop" in means and "rock.specific_energy" not in names:
        # The rate is only as certain as the rock's specific energy, unless that is a free
        # parameter.
        own = values[[*means].index("rop")] * np.log(known["rock.specific_energy_factor"]) / EIGHTY
        errors[[*means].index("rop")] = np.hypot(errors[[*means].index("rop")], own)
    start, low, high = (np.empty(len(names)) for _ in range(3))
    for k, name in enumerate(names):
        start[k] = known[name]
        bounds = free[name] if isinstance(free, Mapping) else None
        if bounds is not None:
            low[k], high[k] = map(VARIABLES[name].number, alike(bounds, name))
        else:
            low[k], high[k] = start[k] / FACTOR, start[k] * FACTOR
        if not 0.0 < low[k] < high[k]:
            raise DomainError(f"the bounds of {name}, {low[k]:g} to {high[k]:g}, must be above 0")
    start, low, high = np.log([np.clip(start, low, high), low, high])
    return Problem(names, start, low, high, given, [*means], records, values, errors, wanted)


def _columns(source: tables.Source) -> dict[str, list[float]]:
    """Returns the means that a table has, one list each."""
    fields = [tables.Field("depth", "m", tables.SYNONYMS["depth"], display="m")]
    for name in (*SHEETS, *(mean for mean in MEANS if mean not in SHEETS)):
        own = SHEETS.get(name, "")
        words = f"{own.replace('_', '')} {tables.SYNONYMS.get(own, '')}"
        si = "" if unit(name) == "1" else unit(name)
        limits = RANGES.get(own, (-np.inf, np.inf))
        fields.append(tables.Field(name, si, words, limits, DISPLAY_UNITS.get(own, si)))
    numbers, _, grid = tables.columns_of(source, fields)
    for text in (*tables.sentences(grid.problems), "; ".join(grid.notes)):
        warn(text)
    return {str(name): numbers[name].tolist() for name in numbers if name != "depth"}


def _measured(name: str, given: Measured) -> tuple[float, float] | None:
    """Returns value and standard error; None if every value is missing."""
    of = unit(named(name))
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise DomainError(f"{name} = {given!r}: {GIVE}")
    numbers = [np.nan if x is None else read(x, of, name) for x in alike(given, name)]
    values = np.array(numbers, dtype=float)
    is_positive = name in RATES_OF_BLOWS or (name in VARIABLES and VARIABLES[name].minimum == 0.0)
    if is_positive and not isinstance(given, tuple):
        # Rigs log zeros while idle, and null values.
        idle = int(np.sum(values <= 0.0))
        values = np.where(values <= 0.0, np.nan, values)
        if idle:
            warn(f"{idle} of {len(numbers)} values of {name} are not above 0 and are left out")
    if len(values) == 2 and isinstance(given, tuple):
        value, sigma = map(float, values)
        if np.isnan(value):
            return None
        _possible(name, of, np.array([value]))
    else:
        if is_positive and np.isfinite(values).sum() >= LEAST:
            values = _without_outliers(name, of, values, [*given])
        values = values[np.isfinite(values)]
        if not len(values):
            return None
        if len(values) < LEAST:
            raise DomainError(f"{name}: {len(values)} values are left: {GIVE}")
        value, sigma = float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values)))
    if not (np.isfinite(value) and sigma > 0.0 and np.isfinite(sigma)):
        raise DomainError(f"{name} = {value:g} with error {sigma:g}: an error must be above 0")
    if value <= 0.0 and is_positive:
        raise DomainError(f"{name} = {value:g} {of} is not above 0: is the unit right?")
    return value, sigma


def _possible(name: str, of: str, values: Array) -> Array:
    """Returns which values are possible; raises an error if half of them or more are not."""
    low, high = RANGES[SHEETS[name]] if name in SHEETS else (-np.inf, np.inf)
    inside = (values >= low) & (values <= high)
    known = np.isfinite(values)
    if known.any() and 2 * inside.sum() <= known.sum():
        value = float(np.nanmedian(values[known & ~inside]))
        raise DomainError(
            f"{name} = {value:g} {of} is not within {low:g} to {high:g} {of}, as of real hammers: "
            "is the unit right?"
        )
    return np.asarray(inside)


def _without_outliers(name: str, of: str, values: Array, given: Sequence[Value | None]) -> Array:
    """Returns the values without impossible ones and outliers, and warns of these."""
    inside = _possible(name, of, values)
    slips = tables.far(np.where(inside, values, np.nan))
    few = slips.sum() <= max(1.0, tables.SLIPS * len(values))
    problems: dict[str, list[str]] = {}
    for k in map(int, np.flatnonzero((~inside & ~np.isnan(values)) | slips)):
        text = given[k] if isinstance(given[k], str) else f"{values[k]:g} {of}"
        kind = f"far from all other {name}" + (
            " and left out" if few else "; is it another motion?"
        )
        kind = kind if inside[k] else f"left out, for no hammer has this {name}"
        problems.setdefault(kind, []).append(f"value {k + 1} of {len(values)} = {text}")
    for text in tables.sentences(problems):
        warn(text)
    return np.asarray(values[inside & ~(slips & few)])
