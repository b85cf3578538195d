"""Estimates a hammer's parameters, with reliable error bars, from measurements while it runs.

The response is only piecewise smooth, so it is not differentiated. An emulator approximates it, as
a function of the parameters' logarithms, from all simulated hammers (`posterior`); its deviation
from a smooth function is the roughness. With measured values ``m`` of covariance ``S``, emulated
means ``f`` and the covariance ``R`` of a new hammer around them, the likelihood is that of

    (m - f(x)) . (S + R)^-1 (m - f(x))

within the bounds. A population is drawn from it, some of its members are simulated, and this is
repeated until the population no longer changes and the emulator is certain of nearly all of it.
Until then, members with a large uncertainty are preferred. Otherwise a ridge (a combination of
parameters that is known much better than each of them) would be as wide as the emulator's
uncertainty. The best values are those of the best member, moved to the nearest maximum of the
likelihood.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..contract import typed
from ..errors import DomainError, RefusedError, warn
from ..extras import need
from ..frames import np, pd
from ..scene.band import beside, factor
from ..scene.hammers import Hammerlike, Rocklike, numbers_of
from ..scene.variables import Array
from ..simulation import answers
from ..simulation.records import Record
from .longrun import Steady, Wanted, named, responses, unit
from .measurements import GIVE, Free, Measured, Problem, problem_of
from .posterior import LOSSES, Emulator, maximum, modes, population
from .trends import table_of

#: Points of the first design per parameter, and fewest further ones that need a response.
FIRST_POINTS, FEWEST_MORE = 16, 3
#: Least standard deviation of a result, in logarithms.
LEAST_DEVIATION = 1e-3
#: A misfit is reported if its probability is below this.
CHANCE = 1e-3
#: Correlation beyond which two estimates are hardly distinguishable; error over the bounds' width
#: beyond which a direction is undetermined.
CORRELATED, UNDETERMINED = 0.95, 0.5
#: Most turns of refinement; new hammers per turn and parameter; change of an interval, as a share
#: of its width, that counts as none.
ROUNDS, NEW_POINTS, SETTLED = 10, 8, 0.1
#: Allowed uncertainty of the emulator, in standard errors of a measurement, and the share of the
#: population that must meet it: 0.3 makes an interval hypot(1, 0.3) = 1.04 times as wide.
MOST_SPREAD, SHARE = 0.3, 0.9
#: If a measured value differs from the fitted one by this factor, its unit may be wrong.
WRONG_UNIT = 10.0


@dataclass(frozen=True, repr=False)
class Calibration(answers.Answer):
    """Estimated parameters and their uncertainty."""

    #: Best values.
    parameters: pd.Series
    #: Standard deviations of the samples; those of the bounds if undetermined.
    errors: pd.Series
    covariance: pd.DataFrame
    correlation: pd.DataFrame
    #: Samples of the likelihood within the bounds: one row each, one column per parameter.
    samples: pd.DataFrame = field(repr=False)
    #: Best values and share of each mode of the likelihood, the largest first.
    modes: pd.DataFrame
    #: Parameters and combinations that these measurements do not determine, one sentence each.
    cannot_tell: tuple[str, ...]
    #: Parameters at their bounds.
    at_bounds: tuple[str, ...]
    #: Measured and fitted values (a rate with its range), the errors of both, and the difference
    #: divided by these errors.
    residuals: pd.DataFrame
    #: The same table for each record, over its time.
    records: tuple[pd.DataFrame, ...]
    #: Sum of the squared residuals over their errors; number of measurements minus parameters.
    chi_square: float
    degrees_of_freedom: int
    #: The reason why the model does not describe the measurements; empty if it may.
    misfit: str
    #: The long-run response of the best values; None if only records were fitted.
    steady: Steady | None
    #: Number of simulated hammers.
    evaluations: int
    _problem: Problem = field(repr=False)
    _left: Array = field(repr=False)

    @property
    def hammer(self) -> dict[str, float]:
        """Numbers of the fitted hammer, including those that were given."""
        return {**self._problem.given, **self.parameters}

    def interval(self, level: float = 0.95) -> pd.DataFrame:
        """Returns an interval of each parameter with this probability, one row each.

        Both tails are equally probable, so the interval is not symmetric about the best value.

        Args:
            level: probability that an interval contains the value, above 0 and below 1.
        """
        if not 0.0 < level < 1.0:
            raise DomainError(f"level = {level:g} must be above 0 and below 1")
        sides = self.samples.quantile([0.5 - 0.5 * level, 0.5 + 0.5 * level]).T
        return sides.set_axis(["low", "high"], axis=1)

    def to_frame(self) -> pd.DataFrame:
        """Returns medians and 95 % intervals of the samples, and best values with their errors."""
        own = {"best": self.parameters, "error": self.errors}
        return pd.DataFrame({"median": self.samples.median(), **self.interval(), **own})

    def log_likelihood(self, theta: Sequence[float] | Array) -> Any:
        """Returns the logarithm of the likelihood of parameters, without its constant.

        For samplers such as emcee. It is minus infinity outside the bounds, and where the engine
        refuses the hammer or the hammer stalls; it is never NaN.

        Args:
            theta: values in SI units, in the order of `parameters`, or many of them, a row each.

        Returns:
            A number, or one for each row.
        """
        problem = self._problem
        try:
            points = np.asarray(theta, dtype=float)
        except (TypeError, ValueError):
            points = np.zeros(0)
        if points.ndim not in (1, 2) or points.shape[-1] != len(problem.names):
            raise DomainError(
                f"theta of shape {points.shape} must have {len(problem.names)} numbers a row: "
                f"{', '.join(problem.names)}"
            )
        rows = np.atleast_2d(points)
        logs = np.log(np.where(rows > 0.0, rows, np.nan))
        inside = np.array([problem.holds(row) for row in logs], dtype=bool)
        values = np.full((len(rows), len(problem.values)), np.nan)
        if inside.any():
            values[inside] = problem.at(logs[inside])
        off = (values - problem.values) / problem.errors
        solved = np.linalg.solve(np.eye(off.shape[1]) + self._left, off.T).T
        found = -0.5 * np.sum(off * solved, axis=1)
        found[~np.isfinite(found)] = -np.inf
        return float(found[0]) if points.ndim == 1 else found

    caption = "Fitted less measured, over the error"

    def in_words(self) -> list[str]:
        """Returns sentences about undetermined parameters, the misfit, and the rate."""
        fits = f"chi-square {self.chi_square:.3g} of {self.degrees_of_freedom} degrees of freedom"
        texts = [fits, *self.cannot_tell, *(f"{n} is at its bound" for n in self.at_bounds)]
        texts += [self.misfit] if self.misfit else []
        return texts + ([self.steady.rate] if self.steady is not None else [])

    def plot(self) -> Any:
        """Plots the fitted hammer with each measurement, or with the first record."""
        return answers.residuals(self.residuals if len(self.residuals) else self.records[0])


@typed(measured=GIVE)
def calibrate(
    hammer: Hammerlike,
    measured: Mapping[str, Measured] | pd.DataFrame | str | Path,
    free: Free,
    *,
    records: Sequence[Record] = (),
    preset: str | None = None,
    rock: Rocklike = None,
    loss: str = "linear",
    error: float = 0.005,
    seed: int = 1,
    progress: bool = False,
) -> Calibration:
    """Fits parameters to long-run measurements of a hammer, and to records over time.

    Args:
        hammer: all other parameters, and the first estimate: parameters by name, a preset's name,
            a `Scene` or its file, a `Datasheet`, a `Run`.
        measured: means of `Steady` by name: a value with its standard error, numbers in SI units or
            text (``("34 mm/s", "0.5 mm/s")``), or three or more repeated measurements; or a table
            or a file with a column each, as for `specific_energy`. Impossible values, and a few
            that are more than ten median deviations from the median, are left out, and a warning
            lists them. Unless the rock's specific energy is free, its error adds to that of
            ``rop``.
        free: parameters and constant inputs to estimate, all above 0, optionally with bounds:
            ``{"rock.stiffness": ("50 MN/m", "500 MN/m")}``; the default is a factor of three both
            ways.
        records: samples of a force or a motion over time, see `Record`.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        loss: ``linear``, or a robust one of `scipy.optimize.least_squares`: ``soft_l1``,
            ``huber``, ``cauchy``, ``arctan``.
        error: relative standard error of the rate of penetration of each simulated hammer.
        seed: random seed of the simulated points.
        progress: shows progress bars.

    Example:
        >>> from dth_hammer import calibrate, steady
        >>> rigid = {"fidelity": "Rigid"}
        >>> rate = steady(rigid | {"rock.stiffness": 1.5e8}).mean["tip_rate"]
        >>> found = calibrate(rigid, {"tip_rate": (rate, 0.01 * rate)}, ["rock.stiffness"])
        >>> print(f"{found.parameters['rock.stiffness']:.2e} N/m")
        1.50e+08 N/m
    """
    if loss not in LOSSES:
        raise DomainError(f"loss = {loss!r} must be one of {', '.join(LOSSES)}")
    if seed < 0:
        raise DomainError(f"seed = {seed} must be 0 or more")
    problem = problem_of(
        measured, free, numbers_of(hammer, preset, rock), records, Wanted(error=error)
    )
    problem.progress = progress
    problem.add(problem.start[None])
    problem.add_design(FIRST_POINTS * len(problem.names), seed)
    emulator, members = _refined(problem, loss, seed)
    size = members.std(axis=0) + LEAST_DEVIATION
    peaks = [
        (maximum(emulator, peak, size, problem.low, problem.high), share)
        for peak, share in modes(emulator, members)
    ]
    peaks, members = problem.confirmed(peaks, members)
    best = max((peak for peak, _ in peaks), key=lambda peak: emulator(peak[None])[0])
    return _result(problem, best, emulator, members, peaks)


def _refined(problem: Problem, loss: str, seed: int) -> tuple[Emulator, Array]:
    """Returns an emulator and a population over its likelihood, refined until it settles."""
    groups = len(problem.means), [len(record.values) for record in problem.records]
    bounds = (problem.low, problem.high)
    before: Array | None = None
    for turn in range(ROUNDS):
        found = (np.array(problem.found) - problem.values) / problem.errors
        if np.isfinite(found).all(axis=1).sum() < len(problem.names) + FEWEST_MORE:
            why = f": {problem.refused[0]}" if problem.refused else ""
            raise RefusedError(f"no hammer within the bounds has a long-run response{why}")
        emulator = Emulator(np.array(problem.logs), found, bounds, groups, loss)
        members = population(emulator, *bounds, seed + turn)
        spread = emulator.spread(members)
        is_certain = bool(np.quantile(spread, SHARE) <= MOST_SPREAD)
        sides = np.quantile(members, [0.025, 0.5, 0.975], axis=0)
        wide = sides[2] - sides[0] + LEAST_DEVIATION
        is_settled = before is not None and bool((np.abs(sides - before) < SETTLED * wide).all())
        if is_certain and is_settled:
            break
        before = sides
        if turn < ROUNDS - 1:
            random, count = np.random.default_rng([seed, turn]), NEW_POINTS * len(problem.names)
            # If the emulator is certain, any members; otherwise members by the variance of the
            # emulator, which may seem plausible only because nothing is known about them.
            chance = None if is_certain else spread**2 / np.sum(spread**2)
            problem.add(members[random.choice(len(members), count, replace=is_certain, p=chance)])
    return emulator, members


def _result(
    problem: Problem,
    logs: Array,
    emulator: Emulator,
    members: Array,
    peaks: list[tuple[Array, float]],
) -> Calibration:
    names, index = problem.names, pd.Index(problem.names)
    best = np.exp(logs)
    covariance = np.atleast_2d(np.cov(members.T)) + LEAST_DEVIATION**4 * np.eye(len(names))
    sizes = np.sqrt(np.diag(covariance))
    off, left = emulator.at(logs)
    chi_square = float(off @ np.linalg.solve(np.eye(len(off)) + left, off))
    freedom = len(off) - len(names)
    near = np.minimum(logs - problem.low, problem.high - logs)
    misfit = _misfit(chi_square, freedom)
    (last,) = responses([problem.numbers(logs)], problem.wanted) if problem.means else (None,)
    # The fitted values are simulated, not emulated.
    simulated = problem.values + off * problem.errors
    if last is not None:
        simulated[: len(problem.means)] = table_of([last], problem.means)[0]
    if misfit:
        pairs = zip(problem.means, problem.values, simulated, strict=False)
        suspects = [
            name for name, value, own in pairs if not own < WRONG_UNIT * value < WRONG_UNIT**2 * own
        ]
        misfit += "".join(f"; is the unit of {name} right?" for name in suspects)
        warn(misfit)
    rough = np.sqrt(np.diag(left))
    tables = _tables(problem, logs, rough, (simulated - problem.values) / problem.errors)
    return Calibration(
        parameters=pd.Series(best, index=index, name="value"),
        errors=pd.Series(best * sizes, index=index, name="error"),
        covariance=pd.DataFrame(covariance * np.outer(best, best), index, index),
        correlation=pd.DataFrame(covariance / np.outer(sizes, sizes), index, index),
        samples=pd.DataFrame(np.exp(members), columns=index),
        modes=pd.DataFrame(np.exp([peak for peak, _ in peaks]), columns=index).assign(
            share=[share for _, share in peaks]
        ),
        cannot_tell=(
            *_undetermined(problem, covariance),
            *_several_modes(names, peaks),
            *_uncertain(float(np.quantile(emulator.spread(members), SHARE)), len(problem.logs)),
        ),
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
    # If there are as many parameters as measurements, all can be met; any misfit then counts, with
    # one degree of freedom.
    if need("scipy.special").chdtrc(max(freedom, 1), chi_square) >= CHANCE:
        return ""
    return (
        f"the model does not describe what was measured: chi-square {chi_square:.4g} of {freedom} "
        "degrees of freedom; the parameters and their errors mean little"
    )


def _tables(problem: Problem, logs: Array, rough: Array, off: Array) -> list[pd.DataFrame]:
    """Tabulates measured and fitted values of the means and of each record."""
    columns = {
        "measured": problem.values,
        "error": problem.errors,
        "found": problem.values + off * problem.errors,
        "roughness": rough * problem.errors,
        "residual": off / np.hypot(1.0, rough),
    }
    indices: list[pd.Index[Any]] = [pd.Index(problem.means)]
    indices += [pd.Index(r.times, name="time") for r in problem.records]
    ends = np.cumsum([len(index) for index in indices])[:-1]
    parts = zip(np.split(np.column_stack([*columns.values()]), ends), indices, strict=True)
    tables = [pd.DataFrame(part, index, [*columns]) for part, index in parts]
    tables[0]["unit"] = [unit(named(name)) for name in problem.means]
    tables[0] = beside(tables[0], "found", factor(problem.numbers(logs)))
    return tables


def _uncertain(spread: float, hammers: int) -> tuple[str, ...]:
    """Says that intervals include the emulator's uncertainty."""
    wide = np.hypot(1.0, spread)
    text = f"after {hammers} hammers the response is not well known: intervals are up to {wide:.1f}"
    return (f"{text} times as wide as the measurements make them",) if spread > MOST_SPREAD else ()


def _several_modes(names: Sequence[str], peaks: list[tuple[Array, float]]) -> tuple[str, ...]:
    """Says that the likelihood has several modes."""
    texts = [
        f"{', '.join(f'{n} = {x:.4g}' for n, x in zip(names, np.exp(peak), strict=True))} "
        f"({share:.0%})"
        for peak, share in peaks
    ]
    text = f"these measurements allow for {len(texts)} hammers: {'; '.join(texts)}"
    return (text,) if len(texts) > 1 else ()


def _undetermined(problem: Problem, covariance: Array) -> tuple[str, ...]:
    """Finds the directions and pairs of parameters that the measurements do not determine."""
    names = problem.names
    prior = (problem.high - problem.low) / np.sqrt(12.0)
    parts, directions = np.linalg.eigh(covariance / np.outer(prior, prior))
    texts = []
    for part, direction in zip(np.sqrt(parts), (directions * prior[:, None]).T, strict=True):
        if part <= UNDETERMINED:
            continue
        powers = direction / np.abs(direction).max()
        largest = [k for k in np.argsort(-np.abs(powers)) if abs(powers[k]) > 0.1]
        product = " ".join(f"{names[k]}^{powers[k]:.2g}" for k in largest)
        texts.append(f"these measurements do not determine {product}: only the bounds limit it")
    sizes = np.sqrt(np.diag(covariance))
    for i, first in enumerate(names):
        for k, second in enumerate(names[:i]):
            tied = covariance[i, k] / (sizes[i] * sizes[k])
            if abs(tied) > CORRELATED:
                texts.append(
                    f"{second} and {first} are hardly distinguished (correlation {tied:.3f}): "
                    "another kind of measurement would help"
                )
    return tuple(texts)
