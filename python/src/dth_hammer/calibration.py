"""Estimates a hammer's parameters, with reliable error bars, from measurements while it runs.

The response is only piecewise smooth, so it is not differentiated. In the logarithms of the
parameters, over a box around the present estimate, a smooth surface is fitted to the means at
points spread over the box; the residuals are the roughness. With measured values ``m`` of
covariance ``S``, the surface ``f`` and the covariance ``R`` of its residuals,

    minimise (m - f(x)) . (S + R)^-1 (m - f(x)),    covariance of x = (J . (S + R')^-1 J)^-1

within box and bounds, where ``R'`` is that of a new point: ``R (1 + leverage)``, larger for few
points. Then the box moves, or shrinks as long as the residuals shrink as those of a smooth function
do: a box within one piece of the response would take the slope of that piece for the trend.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from . import answers
from .band import beside
from .contract import typed
from .errors import DomainError, RefusedError, warn
from .extras import need
from .gradients import differentiable
from .longrun import Hammerlike, Steady, Wanted, named, numbers_of, responses, unit
from .quantities import read
from .records import Record, check, simulated
from .surfaces import Surface, basis, curved_size
from .trends import sobol, table_of
from .variables import VARIABLES, Array, Value, whole

#: A value with its standard error, or repeated measurements; None and NaN are missing.
Measured = tuple[Value, Value] | Sequence[Value | None] | Array
#: Parameters to find: their names, or bounds by name, None if there are none.
Free = Sequence[str] | Mapping[str, tuple[Value, Value] | None]

#: Bounds of a parameter, as a factor both ways, unless they are given.
FACTOR = 3.0
#: Points of the first design, for each parameter; starts that are followed; their distance, as a
#: part of the bounds.
FIRST, STARTS, APART = 16, 2, 0.15
#: Half of a first box over the bounds, and of the smallest one, in logarithms.
WIDE, NARROW = 0.25, 1e-3
#: Factor by which boxes shrink, and their least size in standard errors.
SHRINK, ENOUGH = 0.4, 2.0
#: Residuals are roughness if a smaller box leaves more than this part of them; of a smooth function
#: a plane would leave the square of `SHRINK`. Below a part of the measurement's error none matter.
SMOOTH, SMALL = 0.4, 0.1
#: Points in a box, for each coefficient of a surface of second degree; most boxes from one start.
DENSE, BOXES = 3, 12
#: A quadratic surface is used below this part of a plane's squared residuals; a misfit is reported
#: below this probability.
PAYS, CHANCE = 0.8, 1e-3
GIVE = "give (value, standard error), or three or more values"
#: Correlation beyond which two estimates can hardly be distinguished; error of a direction, over
#: the width of the bounds, beyond which the measurements do not determine it.
CORRELATED, BLIND = 0.95, 0.5


@dataclass(frozen=True)
class Calibration:
    """Estimated parameters and their uncertainty."""

    #: Best values.
    parameters: pd.Series
    #: Standard errors, of measurement and roughness; those of the bounds if undetermined.
    errors: pd.Series
    covariance: pd.DataFrame
    correlation: pd.DataFrame
    #: What these measurements do not determine, one sentence each.
    cannot_tell: tuple[str, ...]
    #: Parameters at their bounds.
    at_bounds: tuple[str, ...]
    #: Measured and fitted values (a rate with its range), errors of both, and their difference
    #: over these.
    residuals: pd.DataFrame
    #: The same of each record, over its time.
    records: tuple[pd.DataFrame, ...]
    #: Sum of the squared residuals over their errors; measurements less parameters.
    chi_square: float
    degrees_of_freedom: int
    #: Why the model does not describe the measurements; empty if it may.
    misfit: str
    #: The long-run response there; None if only records were fitted.
    steady: Steady | None
    #: Number of simulated hammers.
    evaluations: int
    _problem: _Problem = field(repr=False)
    _left: Array = field(repr=False)

    def log_likelihood(self, theta: Sequence[float] | Array) -> float:
        """Logarithm of the likelihood of parameters, without its constant.

        For samplers such as emcee. It is minus infinity outside the bounds, and where the engine
        refuses the hammer or the hammer stalls; it is never NaN.

        Args:
            theta: values in SI units, in the order of `parameters`.
        """
        point = np.asarray(theta, dtype=float)
        problem = self._problem
        if point.shape != (len(problem.names),) or not (point > 0.0).all():
            return -np.inf
        logs = np.log(point)
        if not problem.holds(logs):
            return -np.inf
        values = problem.at(logs[None])[0]
        if not np.isfinite(values).all():
            return -np.inf
        off = (values - problem.values) / problem.errors
        return float(-0.5 * off @ np.linalg.solve(np.eye(len(off)) + self._left, off))

    def _repr_html_(self) -> str:
        table = pd.DataFrame({"value": self.parameters, "error": self.errors})
        texts = [*self.cannot_tell, *(f"{n} is at its bound" for n in self.at_bounds)]
        texts += [self.misfit] if self.misfit else []
        texts += [self.steady.rate] if self.steady is not None else []
        html = self.residuals.to_html(na_rep="") + "".join(f"<p>{text}</p>" for text in texts)
        html = table.to_html(float_format="{:.4g}".format) + html
        return answers.with_figure(html, self.plot, "Fitted less measured, over the error")

    def plot(self) -> Any:
        """Plots the fitted hammer beside each measurement, or beside the first record."""
        return answers.residuals(self.residuals if len(self.residuals) else self.records[0])


@typed(measured=GIVE)
def calibrate(
    measured: Mapping[str, Measured],
    free: Free,
    scene: Hammerlike = None,
    *,
    records: Sequence[Record] = (),
    preset: str | None = None,
    loss: str = "linear",
    error: float = 0.005,
    seed: int = 1,
    progress: bool = False,
) -> Calibration:
    """Fits parameters to long-run measurements of a hammer, and to records over time.

    Args:
        measured: means of `Steady` by name: a value with its standard error, numbers in SI units or
            text (``("34 mm/s", "0.5 mm/s")``), or three or more repeated measurements.
        free: parameters and constant inputs to estimate, all above 0, optionally with bounds:
            ``{"rock.stiffness": ("50 MN/m", "500 MN/m")}``; otherwise a factor of three both ways.
        scene: all other parameters, and the first estimate: a `Scene`, or parameters by name.
        records: samples of a force or a motion over time, see `Record`.
        preset: parameter set to start from.
        loss: ``linear``, or a robust one of `scipy.optimize.least_squares`: ``soft_l1``,
            ``huber``, ``cauchy``, ``arctan``.
        error: relative error of the rate of penetration of each simulated hammer.
        seed: of the simulated points.
        progress: shows progress bars.

    Example:
        >>> from dth_hammer import calibrate, steady
        >>> rigid = {"fidelity": "Rigid"}
        >>> rate = steady(rigid | {"rock.stiffness": 1.5e8}).mean["tip_rate"]
        >>> found = calibrate({"tip_rate": (rate, 0.01 * rate)}, ["rock.stiffness"], rigid)
        >>> print(f"{found.parameters['rock.stiffness']:.2e} N/m")
        1.50e+08 N/m
    """
    losses = ("linear", "soft_l1", "huber", "cauchy", "arctan")
    if loss not in losses:
        raise DomainError(f"loss = {loss!r} must be one of {', '.join(losses)}")
    problem = _looked_at(measured, free, numbers_of(scene, preset), records, Wanted(error=error))
    problem.progress = progress
    return fitted(problem, loss, seed)


def fitted(problem: _Problem, loss: str = "linear", seed: int = 1) -> Calibration:
    """Returns the best fit from several starting points."""
    fits = [_follow(problem, start, loss, seed) for start in _starts(problem, loss, seed)]
    return _described(problem, min(fits, key=lambda fit: fit.cost))


@dataclass
class _Problem:
    """Measurements, free parameters, and the hammers simulated so far."""

    names: list[str]
    #: Logarithms: where to begin, and bounds.
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
    #: Points tried, and what they gave.
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
        """Responses of hammers, one row per point; NaN where there is none."""
        values = np.full((len(points), len(self.values)), np.nan)
        scenes = [self.numbers(logs) for logs in points]
        if self.means:
            for k, answer in responses(scenes, self.wanted, progress=self.progress):
                if isinstance(answer, str):
                    self.refused.append(answer)
                values[k, : len(self.means)] = table_of([answer], self.means)[0]
        for k, scene in enumerate(scenes) if self.records else ():
            try:
                samples = [simulated(record, scene)[0] for record in self.records]
                values[k, len(self.means) :] = np.concatenate(samples)
            except (DomainError, RefusedError) as error:
                self.refused.append(str(error))
        return values

    def spread(self, low: Array, high: Array, seed: int, count: int) -> None:
        """Simulates the points of a box that have not been simulated yet."""
        inside = sum(bool((x >= low).all() and (x <= high).all()) for x in self.logs)
        if inside >= count:
            return
        unit_box = sobol(len(self.names), count - inside, seed + len(self.logs))[: count - inside]
        self.note(0.5 * (low + high) + 0.5 * (high - low) * unit_box)

    def note(self, points: Array) -> None:
        """Simulates points and stores their responses."""
        self.logs += [*points]
        self.found += [*self.at(points)]

    def within(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Points of a box that have a response, and it over the measurement's error."""
        logs, found = np.array(self.logs), np.array(self.found)
        inside = ((logs >= low) & (logs <= high)).all(axis=1) & np.isfinite(found).all(axis=1)
        return logs[inside], (found[inside] - self.values) / self.errors


@dataclass(frozen=True)
class _Fit:
    logs: Array
    surface: Surface
    #: Of the logarithms.
    covariance: Array
    cost: float


def _surface(problem: _Problem, low: Array, high: Array) -> Surface | None:
    """Fits the surface over a box; None if too few hammers in it have a response."""
    logs, found = problem.within(low, high)
    count, centre = len(low), 0.5 * (low + high)
    plane, curved = count + 1, curved_size(count)

    def fit(size: int) -> tuple[Array, Array, float]:
        terms = basis(logs - centre, size)
        coefficients, *_ = np.linalg.lstsq(terms, found, rcond=None)
        rest = found - terms @ coefficients
        return coefficients, rest, float(np.sum(rest**2)) / (len(logs) - size)

    if len(logs) < plane + 3:
        return None
    best = fit(plane)
    if len(logs) >= curved + 3 and (other := fit(curved))[2] < PAYS * best[2]:
        best = other
    coefficients, rest, _ = best
    free, means = len(logs) - len(coefficients), len(problem.means)
    left = np.zeros((found.shape[1],) * 2)
    left[:means, :means] = rest[:, :means].T @ rest[:, :means] / free
    # Samples of a record share one roughness and are independent of each other.
    end = means
    for record in problem.records:
        part = slice(end, end := end + len(record.values))
        left[part, part] = (
            np.eye(len(record.values)) * np.mean(np.sum(rest[:, part] ** 2, 0)) / free
        )
    terms = basis(logs - centre, len(coefficients))
    return Surface(centre, coefficients, left, np.linalg.pinv(terms.T @ terms), free)


def _solve(problem: _Problem, surface: Surface, low: Array, high: Array, loss: str) -> _Fit:
    """Finds the best point of a surface within a box."""
    least_squares = need("scipy.optimize", "fit").least_squares
    root = np.linalg.cholesky(np.eye(len(surface.left)) + surface.left)

    def whitened(logs: Array) -> Array:
        return np.linalg.solve(root, surface(logs))

    middle = np.clip(surface.centre, low, high)
    found = least_squares(whitened, middle, bounds=(low, high), loss=loss, x_scale=high - low)
    jacobian = surface.slopes(found.x)
    errors = np.eye(len(surface.left)) + surface.scatter(found.x)
    # Information of the bounds: a value anywhere within them.
    prior = np.diag(12.0 / (problem.high - problem.low) ** 2)
    covariance = np.linalg.inv(jacobian.T @ np.linalg.solve(errors, jacobian) + prior)
    return _Fit(found.x, surface, covariance, float(found.cost))


def _starts(problem: _Problem, loss: str, seed: int) -> Iterator[Array]:
    """Returns the best points of a design over the bounds that are not close to each other."""
    if not problem.logs:
        problem.note(problem.start[None])
        problem.spread(problem.low, problem.high, seed, FIRST * len(problem.names))
    logs, off = problem.within(problem.low, problem.high)
    if not len(logs):
        why = f": {problem.refused[0]}" if problem.refused else ""
        raise RefusedError(f"no hammer within the bounds has a long-run response{why}")
    squares = off**2 if loss == "linear" else 2.0 * (np.sqrt(1.0 + off**2) - 1.0)
    chosen: list[Array] = []
    for point in logs[np.argsort(squares.sum(axis=1))]:
        apart = (np.abs((point - c) / (problem.high - problem.low)).max() for c in chosen)
        if all(distance > APART for distance in apart):
            chosen.append(point)
            yield point
        if len(chosen) == STARTS:
            return


def _follow(problem: _Problem, start: Array, loss: str, seed: int) -> _Fit:
    """Refines one starting point, box by box."""
    count = DENSE * curved_size(len(start))
    bounds = problem.high - problem.low
    half, here = WIDE * bounds, start
    fit: _Fit | None = None
    rough: float | None = None
    for _ in range(BOXES):
        low, high = (np.clip(here + w * half, problem.low, problem.high) for w in (-1.0, 1.0))
        problem.spread(low, high, seed, count)
        surface = _surface(problem, low, high)
        if surface is None:
            if fit is not None:
                return fit
            half = SHRINK * half
            continue
        fit = _solve(problem, surface, low, high, loss)
        moved = np.abs(fit.logs - here)
        here = fit.logs
        if not (moved < 0.9 * half).all():
            continue
        if rough is not None and surface.rough > SMOOTH * rough:
            return fit
        least = np.clip(ENOUGH * np.sqrt(np.diag(fit.covariance)), NARROW, WIDE * bounds)
        if surface.rough < SMALL or (half <= 1.01 * least).all():
            return fit
        rough, half = surface.rough, np.maximum(SHRINK * half, least)
    if fit is None:
        raise RefusedError("too few hammers near the best start have a long-run response")
    return fit


def _looked_at(
    measured: Mapping[str, Measured],
    free: Free,
    given: Mapping[str, float],
    records: Sequence[Record],
    wanted: Wanted,
) -> _Problem:
    """Checks the arguments."""
    check(records)
    rows = {name: _measured(name, numbers) for name, numbers in measured.items()}
    means = {name: row for name, row in rows.items() if row is not None}
    names = differentiable(free)
    if not (means or records) or not names:
        raise DomainError("give what was measured, and which parameters are free")
    table = np.array([*means.values()], dtype=float).reshape(len(means), 2)
    values = np.concatenate([table[:, 0], *(r.values for r in records)])
    errors = np.concatenate([table[:, 1], *(r.errors for r in records)])
    known = whole(given)
    start, low, high = (np.empty(len(names)) for _ in range(3))
    for k, name in enumerate(names):
        start[k] = known[name]
        bounds = free[name] if isinstance(free, Mapping) else None
        if bounds is not None:
            low[k], high[k] = (VARIABLES[name].number(bound) for bound in bounds)
        else:
            low[k], high[k] = start[k] / FACTOR, start[k] * FACTOR
        if not 0.0 < low[k] < high[k]:
            raise DomainError(f"the bounds of {name}, {low[k]:g} to {high[k]:g}, must be above 0")
    start = np.clip(start, low, high)
    return _Problem(
        names=names,
        start=np.log(start),
        low=np.log(low),
        high=np.log(high),
        given=given,
        means=[*means],
        records=records,
        values=values,
        errors=errors,
        wanted=wanted,
    )


def _measured(name: str, given: Measured) -> tuple[float, float] | None:
    """Returns value and standard error; None if every value is missing."""
    of = unit(named(name))
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise DomainError(f"{name} = {given!r}: {GIVE}")
    determined = [np.nan if x is None else read(x, of, name) for x in given]
    values = np.array(determined, dtype=float)
    if len(values) == 2 and isinstance(given, tuple):
        value, sigma = map(float, values)
        if np.isnan(value):
            return None
    else:
        values = values[np.isfinite(values)]
        if not len(values):
            return None
        if len(values) < 3:
            raise DomainError(f"{name}: {GIVE}")
        value, sigma = float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values)))
    if not (np.isfinite(value) and sigma > 0.0 and np.isfinite(sigma)):
        raise DomainError(f"{name} = {value:g} with error {sigma:g}: an error must be above 0")
    return value, sigma


def _described(problem: _Problem, fit: _Fit) -> Calibration:
    names, index = problem.names, pd.Index(problem.names)
    best = np.exp(fit.logs)
    sizes = np.sqrt(np.diag(fit.covariance))
    off = fit.surface(fit.logs)
    left = fit.surface.scatter(fit.logs)
    chi_square = float(off @ np.linalg.solve(np.eye(len(off)) + left, off))
    freedom = len(off) - len(names)
    near = np.minimum(fit.logs - problem.low, problem.high - fit.logs)
    tables = _tables(problem, fit, off)
    misfit = _misfit(chi_square, freedom)
    if misfit:
        warn(misfit)
    ((_, last),) = (
        responses([problem.numbers(fit.logs)], problem.wanted) if problem.means else [(0, None)]
    )
    return Calibration(
        parameters=pd.Series(best, index=index, name="value"),
        errors=pd.Series(best * sizes, index=index, name="error"),
        covariance=pd.DataFrame(fit.covariance * np.outer(best, best), index, index),
        correlation=pd.DataFrame(fit.covariance / np.outer(sizes, sizes), index, index),
        cannot_tell=_blind(problem, fit),
        at_bounds=tuple(n for n, room in zip(names, near, strict=True) if room < 1e-6),
        residuals=tables[0],
        records=tuple(tables[1:]),
        chi_square=chi_square,
        degrees_of_freedom=freedom,
        misfit=misfit,
        steady=last if isinstance(last, Steady) else None,
        evaluations=len(problem.logs),
        _problem=problem,
        _left=left,
    )


def _misfit(chi_square: float, freedom: int) -> str:
    if freedom <= 0 or need("scipy.stats", "fit").chi2.sf(chi_square, freedom) >= CHANCE:
        return ""
    return (
        f"the model does not describe what was measured: chi-square {chi_square:.4g} of {freedom} "
        "degrees of freedom; the parameters and their errors mean little"
    )


def _tables(problem: _Problem, fit: _Fit, off: Array) -> list[pd.DataFrame]:
    """Tabulates measured and fitted values of the means and of each record."""
    rough = np.sqrt(np.diag(fit.surface.scatter(fit.logs)))
    columns = {
        "measured": problem.values,
        "error": problem.errors,
        "found": problem.values + off * problem.errors,
        "roughness": rough * problem.errors,
        "residual": off / np.hypot(1.0, rough),
    }
    indices: list[pd.Index[Any]] = [pd.Index(problem.means)]
    indices += [pd.Index(r.times, name="time") for r in problem.records]
    ends = np.cumsum([len(index) for index in indices])
    parts = np.split(np.column_stack([*columns.values()]), ends[:-1])
    tables = [pd.DataFrame(p, i, [*columns]) for p, i in zip(parts, indices, strict=True)]
    tables[0]["unit"] = [unit(named(name)) for name in problem.means]
    tables[0] = beside(tables[0], "found", problem.numbers(fit.logs))
    return tables


def _blind(problem: _Problem, fit: _Fit) -> tuple[str, ...]:
    """Finds the directions and pairs of parameters that the measurements do not determine."""
    names = problem.names
    prior = (problem.high - problem.low) / np.sqrt(12.0)
    parts, directions = np.linalg.eigh(fit.covariance / np.outer(prior, prior))
    texts = []
    for part, direction in zip(np.sqrt(parts), (directions * prior[:, None]).T, strict=True):
        if part <= BLIND:
            continue
        powers = direction / np.abs(direction).max()
        largest = [k for k in np.argsort(-np.abs(powers)) if abs(powers[k]) > 0.1]
        product = " ".join(f"{names[k]}^{powers[k]:.2g}" for k in largest)
        texts.append(f"these measurements do not determine {product}: only the bounds limit it")
    sizes = np.sqrt(np.diag(fit.covariance))
    for i, first in enumerate(names):
        for k, second in enumerate(names[:i]):
            tied = fit.covariance[i, k] / (sizes[i] * sizes[k])
            if abs(tied) > CORRELATED:
                texts.append(
                    f"{second} and {first} are hardly distinguished (correlation {tied:.3f}): "
                    "another kind of measurement would help"
                )
    return tuple(texts)
