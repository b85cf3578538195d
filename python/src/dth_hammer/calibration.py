"""From what was measured of a running hammer to its parameters, with honest error bars."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from .cycle import Cycle, Cycles, found
from .errors import DomainError, RefusedError, UnknownNameError
from .extras import need
from .records import Record, check, simulated
from .variables import Array, Value
from .variables import numbers as checked

#: What can be measured of a cycle: value, and derivatives from those of the cycle's numbers.
Measure = tuple[Callable[[Cycle], float], Callable[[Cycle], pd.Series]]
#: A value with its standard error, or repeated measurements.
Measured = tuple[float, float] | Sequence[float] | Array

#: Part of a parameter over which its trend is told, and how far a fit may go, in logarithms.
TREND, FURTHEST = 0.05, 3.0
#: A residual where there is no cycle.
NOWHERE = 1e6
#: Parameters whose estimates correlate beyond this are not told apart.
CORRELATED = 0.95


def _output(name: str) -> Measure:
    return (lambda c: c.number(name)), (lambda c: _row(c, name))


def _row(cycle: Cycle, name: str) -> pd.Series:
    return pd.Series(cycle.gradient.loc[name], dtype=float)


def _ratio(cycle: Cycle) -> pd.Series:
    speed, rebound = _row(cycle, "blow_speed"), _row(cycle, "rebound_speed")
    return (rebound - cycle.rebound_ratio * speed) / cycle.blow_speed


MEASURES: Mapping[str, Measure] = {
    **{
        name: _output(name)
        for name in (
            "period",
            "advance",
            "rop",
            "blow_speed",
            "blow_energy",
            "rebound_speed",
            "contact_force_peak",
            "rock_force_peak",
        )
    },
    "blow_frequency": (
        lambda c: c.frequency,
        lambda c: -_row(c, "period") / c.period**2,
    ),
    "rebound_ratio": (lambda c: c.rebound_ratio, _ratio),
}


@dataclass(frozen=True)
class Calibration:
    """Parameters found, and how well."""

    #: Best values.
    parameters: pd.Series
    #: Standard errors (of a parameter, as the measurements' errors have it).
    errors: pd.Series
    covariance: pd.DataFrame
    correlation: pd.DataFrame
    #: What these measurements cannot tell, a sentence each.
    cannot_tell: tuple[str, ...]
    #: Measured and found values, and their difference over its error.
    residuals: pd.DataFrame
    #: The same of each record, over its time.
    records: tuple[pd.DataFrame, ...]
    #: Sum of the squared residuals, and measurements less parameters.
    chi_square: float
    degrees_of_freedom: int
    #: The cycle there, if there is one.
    cycle: Cycle | None
    #: Hammers tried.
    evaluations: int


@dataclass(frozen=True)
class _Sight:
    """What a hammer shows of what was measured, and its derivatives by the free parameters."""

    values: Array
    slopes: Array
    cycle: Cycle | None


def calibrate(
    measured: Mapping[str, Measured],
    free: Sequence[str],
    parameters: Mapping[str, Value] | None = None,
    *,
    records: Sequence[Record] = (),
    preset: str | None = None,
) -> Calibration:
    """Fits parameters to what was measured of the stationary cycle, and to records over time.

    Least squares of the residuals over their errors (`scipy.optimize.least_squares`), in the
    logarithms of the parameters. Along a parameter the order of events changes often, and the
    slope with it: an exact derivative tells of changes within `Cycle.reach` only. So the fit
    first follows the trend, differences over a twentieth of a parameter, and then the exact
    Jacobian from there. The errors are those of the trend over the width of the error itself
    where that is beyond the reach, of the exact Jacobian where it is not.

    Args:
        measured: by name (``rop``, ``blow_frequency``, ``period``, ``advance``,
            ``blow_speed``, ``blow_energy``, ``rebound_speed``, ``rebound_ratio``,
            ``contact_force_peak``, ``rock_force_peak``), in SI units: a value with its standard
            error, or three or more repeated measurements.
        free: positive parameters and inputs to find.
        parameters: the others, and where to begin.
        records: samples of a force or a motion over time, see `Record`.
        preset: parameter set to start from.
    """
    least_squares = need("scipy.optimize", "fit").least_squares

    table = pd.DataFrame(
        {name: _measured(name, m) for name, m in measured.items()}, index=[0, 1], dtype=float
    ).T
    if not (len(table) or records) or not free:
        raise DomainError("give what was measured, and which parameters are free")
    values = np.concatenate([table[0].to_numpy(float), *(r.values for r in records)])
    sigmas = np.concatenate([table[1].to_numpy(float), *(r.errors for r in records)])
    picks = [MEASURES[name] for name in table.index]
    names = [*dict.fromkeys(free)]
    check(records)
    cycles, given = Cycles(parameters, preset=preset), checked(preset, parameters)
    start = np.array([cycles.value(name) for name in names])
    if (start <= 0.0).any():
        worst = names[int(np.argmin(start))]
        raise DomainError(f"{worst} = {start.min():g} must begin above 0 to be fitted")
    answers: dict[bytes, _Sight] = {}

    look = _looking(cycles, picks, records, given, names)

    def at(logs: Array) -> _Sight:
        key = logs.tobytes()
        if key not in answers:
            at_start = not answers
            point = dict(zip(names, (float(x) for x in start * np.exp(logs)), strict=True))
            try:
                answers[key] = look(point)
            except (DomainError, RefusedError) as error:
                where = ", ".join(f"{n} = {x:.4g}" for n, x in point.items())
                when = "at the start" if at_start else "on the way"
                raise RefusedError(f"no cycle {when}, at {where}: {error}") from None
        return answers[key]

    def residuals(logs: Array) -> Array:
        try:
            sight = at(logs)
        except RefusedError:
            if not answers:
                raise
            # A step to where no cycle is found is one to take back.
            return np.full(len(values), NOWHERE)
        return np.asarray((sight.values - values) / sigmas)

    def jacobian(logs: Array) -> Array:
        slopes = at(logs).slopes
        return np.asarray(slopes * (start * np.exp(logs)) / sigmas[:, None])

    # Beyond the exact slopes: steps from which small edges do not show.
    trend = least_squares(
        residuals, np.zeros(len(names)), jac=lambda logs: _trend(residuals, logs),
        bounds=(-FURTHEST, FURTHEST), xtol=1e-3, ftol=1e-6, max_nfev=20,
    )  # fmt: skip
    exact = least_squares(
        residuals,
        _nearby(residuals, trend.x) if picks else trend.x,
        jac=jacobian,
        x_scale="jac",
        xtol=1e-10,
        ftol=1e-10,
        max_nfev=20,
    )
    fit = min(exact, trend, key=lambda f: float(f.cost))
    sight, point = at(fit.x), dict(zip(names, start * np.exp(fit.x), strict=True))
    fit.jac = _slopes(residuals, jacobian, fit.x, sight.cycle, names=names, count=len(picks))
    cycle = sight.cycle or found(cycles, point)
    best = pd.Series(start * np.exp(fit.x), index=pd.Index(names), name="value")
    tables = _residuals(table, records, sight.values)
    return _calibration(fit, best, tables, cycle=cycle, evaluations=len(answers))


def _looking(
    cycles: Cycles,
    picks: list[Measure],
    records: Sequence[Record],
    given: Mapping[str, float],
    names: list[str],
) -> Callable[[dict[str, float]], _Sight]:
    """What was measured, as a hammer with some parameters shows it."""

    def look(point: dict[str, float]) -> _Sight:
        cycle = cycles.find(point, names) if picks else None
        parameters = {**given, **point}
        sights = [simulated(record, parameters, names) for record in records]
        if cycle is not None:
            rows = [rows_of(cycle)[names].to_numpy(float) for _, rows_of in picks]
            sights.insert(0, (np.array([value(cycle) for value, _ in picks]), np.array(rows)))
        values, slopes = (np.concatenate(part) for part in zip(*sights, strict=True))
        return _Sight(values, slopes, cycle)

    return look


def _trend(residuals: Callable[[Array], Array], logs: Array) -> Array:
    """Slopes over a width in which the small edges of the map do not show."""
    columns, here = [], residuals(logs)
    for unit in np.eye(len(logs)):
        sides = [(way, residuals(logs + way * TREND * unit)) for way in (1.0, -1.0)]
        known = [(way, side) for way, side in sides if (side < NOWHERE).all()]
        low = known[1] if len(known) == 2 else (0.0, here)
        if known:
            columns.append((known[0][1] - low[1]) / ((known[0][0] - low[0]) * TREND))
        else:
            columns.append(np.zeros(len(here)))
    return np.array(columns).T


def _nearby(residuals: Callable[[Array], Array], best: Array) -> Array:
    """The best of some points around: small edges make small valleys."""
    points = [best]
    for unit in np.eye(len(best)):
        points += [best + TREND * part * unit for part in (-1.0, -0.5, -0.25, 0.25, 0.5, 1.0)]
    costs = [float(np.sum(residuals(point) ** 2)) for point in points]
    return points[int(np.argmin(costs))]


def _slopes(
    residuals: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    best: Array,
    cycle: Cycle | None,
    *,
    names: list[str],
    count: int,
) -> Array:
    """The Jacobian that errors are made of.

    Of the cycle's `count` numbers exact within its reach, else the trend's; of samples exact:
    events that swap elsewhere hardly show in them.
    """
    slopes, trend = jacobian(best), None
    if cycle is None:
        return slopes
    for k, name in enumerate(names):
        width = 1.0 / max(float(np.linalg.norm(slopes[:, k])), 1e-9)
        width = float(np.clip(width, 1e-3, TREND))
        if float(cycle.reach[name]) / cycle.values[name] < width:
            trend = _trend(residuals, best) if trend is None else trend
            slopes[:count, k] = trend[:count, k]
    return slopes


def _measured(name: str, given: Measured) -> list[float]:
    if name not in MEASURES:
        raise UnknownNameError("measurement", name, MEASURES)
    numbers = np.asarray(given, dtype=float).ravel()
    if len(numbers) == 2 and isinstance(given, tuple):
        value, sigma = (float(x) for x in numbers)
    elif len(numbers) >= 3:
        value, sigma = float(numbers.mean()), float(numbers.std(ddof=1) / np.sqrt(len(numbers)))
    else:
        raise DomainError(f"{name}: give (value, standard error), or three or more values")
    if not (np.isfinite(value) and sigma > 0.0 and np.isfinite(sigma)):
        raise DomainError(f"{name} = {value:g} with error {sigma:g}: an error must be above 0")
    return [value, sigma]


def _residuals(table: pd.DataFrame, records: Sequence[Record], found: Array) -> list[pd.DataFrame]:
    """Measured and found, of the cycle's numbers and of each record."""
    parts = [(table.index, table[0].to_numpy(float), table[1].to_numpy(float))]
    parts += [(pd.Index(r.times, name="time"), r.values, r.errors) for r in records]
    ends = np.cumsum([len(index) for index, _, _ in parts])
    return [
        pd.DataFrame({"measured": m, "error": e, "found": f, "residual": (f - m) / e}, index=index)
        for (index, m, e), f in zip(parts, np.split(found, ends[:-1]), strict=True)
    ]


def _calibration(
    fit: Any,
    estimate: pd.Series,
    residuals: list[pd.DataFrame],
    *,
    cycle: Cycle | None,
    evaluations: int,
) -> Calibration:
    names, best = [str(n) for n in estimate.index], estimate.to_numpy(float)
    _, singular, right = np.linalg.svd(fit.jac, full_matrices=True)
    sizes = np.zeros(len(names))
    sizes[: len(singular)] = singular
    blind = sizes <= 1e-9 * sizes.max() if sizes.max() > 0.0 else np.ones(len(names), bool)
    inverse = np.where(blind, np.inf, 1.0 / np.where(blind, 1.0, sizes**2))
    visible = np.where(blind, 0.0, inverse)
    logs = right.T @ np.diag(visible) @ right
    lost = (np.abs(right[blind]) > 0.1).any(axis=0) if blind.any() else np.zeros(len(names), bool)
    relative = np.where(lost, np.inf, np.sqrt(np.diag(logs)))
    scale = np.sqrt(np.where(np.diag(logs) > 0.0, np.diag(logs), 1.0))
    correlation = logs / np.outer(scale, scale)
    index = pd.Index(names)
    return Calibration(
        parameters=estimate,
        errors=pd.Series(best * relative, index=index, name="error"),
        covariance=pd.DataFrame(logs * np.outer(best, best), index=index, columns=index),
        correlation=pd.DataFrame(correlation, index=index, columns=index),
        cannot_tell=_blind_spots(names, relative, correlation, right[blind]),
        residuals=residuals[0],
        records=tuple(residuals[1:]),
        chi_square=float(2.0 * fit.cost),
        degrees_of_freedom=sum(map(len, residuals)) - len(names),
        cycle=cycle,
        evaluations=evaluations,
    )


def _blind_spots(
    names: list[str], relative: Array, correlation: Array, blind: Array
) -> tuple[str, ...]:
    notes = []
    for direction in blind:
        parts = [
            f"{names[k]}^{direction[k]:.2g}"
            for k in np.argsort(-np.abs(direction))
            if abs(direction[k]) > 0.1
        ]
        notes.append(f"these measurements say nothing of {' '.join(parts)}")
    for i, first in enumerate(names):
        for k, second in enumerate(names[:i]):
            tied = np.isfinite(relative[[i, k]]).all() and abs(correlation[i, k]) > CORRELATED
            if tied:
                notes.append(
                    f"{second} and {first} are hardly told apart (correlation "
                    f"{correlation[i, k]:.3f}): another kind of measurement would"
                )
    for name, part in zip(names, relative, strict=True):
        if np.isfinite(part) and part > 0.5:
            notes.append(f"{name} is known to {100 * part:.0f} % only")
    return tuple(notes)


@dataclass(frozen=True)
class Optimum:
    """The best design found."""

    parameters: pd.Series
    #: The goal's value.
    value: float
    cycle: Cycle
    #: Bounds that hold it back.
    at_bounds: tuple[str, ...]
    evaluations: int


def optimise(
    goal: str,
    free: Mapping[str, tuple[float, float]],
    parameters: Mapping[str, Value] | None = None,
    *,
    least: bool = False,
    limits: Mapping[str, tuple[float | None, float | None]] | None = None,
    preset: str | None = None,
) -> Optimum:
    """The parameters, within bounds, for which a number of the cycle is largest.

    Sequential quadratic programming (`scipy.optimize.minimize`, SLSQP) with exact gradients;
    the optimum is a local one, from where ``parameters`` begin.

    Args:
        goal: a measure, see `calibrate`.
        free: bounds by name, in SI units, above 0.
        parameters: the others, and where to begin.
        least: looks for the smallest value instead.
        limits: bounds on other measures, None where there is none.
        preset: parameter set to start from.
    """
    minimize = need("scipy.optimize", "fit").minimize

    for name in [goal, *(limits or {})]:
        if name not in MEASURES:
            raise UnknownNameError("measure", name, MEASURES)
    names = [*free]
    bounds = np.array([free[name] for name in names], dtype=float)
    if not names or not (bounds[:, 0] > 0.0).all() or not (bounds[:, 1] > bounds[:, 0]).all():
        raise DomainError("give each free parameter a lower and a higher bound above 0")
    sign = 1.0 if least else -1.0
    cycles = Cycles(parameters, preset=preset)
    begun = np.clip([cycles.value(name) for name in names], bounds[:, 0], bounds[:, 1])
    answers: dict[bytes, Cycle] = {}

    def at(logs: Array) -> Cycle:
        key = np.asarray(logs).tobytes()
        if key not in answers:
            point = dict(zip(names, (float(x) for x in begun * np.exp(logs)), strict=True))
            answers[key] = cycles.find(point, names)
        return answers[key]

    def part(name: str, scale: float) -> tuple[Any, Any]:
        value, slopes = MEASURES[name]
        return (
            lambda logs: scale * value(at(logs)),
            lambda logs: scale * slopes(at(logs))[names].to_numpy(float) * begun * np.exp(logs),
        )

    unit = sign / max(abs(MEASURES[goal][0](at(np.zeros(len(names))))), 1e-300)
    value, slope = part(goal, unit)
    held = []
    for name, (low, high) in (limits or {}).items():
        for bound, way in ((low, 1.0), (high, -1.0)):
            if bound is None:
                continue
            size = way / (abs(bound) or 1.0)
            f, g = part(name, size)
            held.append({"type": "ineq", "fun": lambda x, f=f, b=bound * size: f(x) - b, "jac": g})
    best = minimize(
        value,
        np.zeros(len(names)),
        jac=slope,
        method="SLSQP",
        bounds=np.log(bounds / begun[:, None]),
        constraints=held,
        options={"ftol": 1e-9, "maxiter": 200},
    )
    cycle = at(best.x)
    found = begun * np.exp(best.x)
    near = np.abs(np.log(bounds / found[:, None])) < 1e-6
    return Optimum(
        parameters=pd.Series(found, index=pd.Index(names), name="value"),
        value=MEASURES[goal][0](cycle),
        cycle=cycle,
        at_bounds=tuple(name for name, at_it in zip(names, near.any(axis=1), strict=True) if at_it),
        evaluations=len(answers),
    )
