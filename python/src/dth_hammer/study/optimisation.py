"""The best design within bounds and limits, by the means of the long-run response.

A goal jumps from design to design, by up to some per cent: of many designs the best single one has
won by luck. What is made large is therefore the mean over hammers whose free numbers are off by a
stated tolerance, as those that are made will be.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..contract import typed
from ..errors import DomainError
from ..extras import bar, need
from ..run import answers
from ..scene.band import sides
from ..scene.hammers import Hammerlike, Rocklike, numbers_of
from ..scene.variables import Array, Value
from .designs import KEPT, Limits, Measure, Problem, Row, limits_of
from .longrun import Steady, Wanted
from .trends import line, sobol

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Over the bounds: first and last step of a start, and those from the best of all starts.
FIRST, COARSE, NEAR, LAST = 0.25, 0.02, 0.05, 5e-3
#: Pairs of hammers that a mean over the tolerance is of: while searching, and in the end.
PAIRS, FINAL = 4, 16
#: Number of best designs that are compared in the end.
CANDIDATES = 3
#: While searching, errors of means may be so many times larger, up to the second number.
LOOSE, LOOSEST = 4.0, 0.02
#: Steps of a start, for each parameter.
STEPS = 20
#: Half of the box about the optimum in which it is looked at, over the bounds.
AROUND = 0.02
#: A parameter at less than this part of the bounds from one of them is at it.
AT = 5e-3


@dataclass(frozen=True, repr=False)
class Optimum(answers.Answer):
    """The best design found."""

    parameters: pd.Series
    #: Mean of the goal over the tolerance, and its standard error: by the scatter of the hammers in
    #: it, or without a tolerance by the errors of the means that the goal is made of.
    value: float
    error: float
    #: The goal of the design itself, and its long-run response.
    nominal: float
    steady: Steady
    #: Bounds that hold it back, and limits.
    at_bounds: tuple[str, ...]
    at_limits: tuple[str, ...]
    #: Parameters on which the goal does not depend there, within what it jumps.
    flat: tuple[str, ...]
    #: By how much the goal jumps from design to design there, as a part of it.
    roughness: float
    #: ``optimal``, ``held``, ``rough``, ``flat`` or ``stopped``, and what that means.
    status: str
    message: str
    #: All designs in the order in which they were tried: start, parameters, goal, its error, of how
    #: many hammers it is the mean, limits, the rate of penetration with its range (``rop_low``,
    #: ``rop_high``), and why one was refused.
    history: pd.DataFrame = field(repr=False)

    @property
    def evaluations(self) -> int:
        """Number of designs that were tried."""
        return len(self.history)

    @property
    def hammers(self) -> int:
        """Number of hammers that were simulated for them."""
        return int(self.history["hammers"].sum())

    caption = "The goal of every design"

    def in_words(self) -> list[str]:
        """The goal, how it was found, and the rate."""
        return [f"{self.value:.6g} ({self.status}): {self.message}", self.steady.rate]

    def to_frame(self) -> pd.DataFrame:
        """Returns the parameters."""
        return self.parameters.to_frame("value")

    def plot(self) -> Figure:
        """Plots the goal of every design that was tried, in order."""
        return answers.history(self.history, self.value, KEPT)


@typed()
def optimise(
    hammer: Hammerlike,
    goal: Measure,
    free: Mapping[str, tuple[Value, Value]],
    *,
    least: bool = False,
    limits: Limits | None = None,
    preset: str | None = None,
    rock: Rocklike = None,
    design: Callable[[Mapping[str, float]], Mapping[str, Value]] | None = None,
    tolerance: float = 0.01,
    starts: int = 4,
    error: float = 0.002,
    seed: int = 1,
    progress: bool = False,
) -> Optimum:
    """Finds the parameters, within bounds, for which a long-run mean is largest.

    COBYQA (`scipy.optimize.minimize`), which needs no derivatives, from two starts side by side
    with single hammers, and from the others where the best designs of these differ; then once
    more from the best of all with means over the tolerance. The best designs of that are compared
    by means over more hammers, and the optimum is looked at through a plane over a small box.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        goal: a mean of `Steady`; ``power`` (energy of blows over time), ``piston_mass``,
            ``bit_mass``, ``piston_stress`` or ``bit_stress`` (largest axial stress of a settled
            cycle, on the hammer's own mesh); or a function of a `Steady`:
            ``lambda s: s["energy_drive"] / s["advance"]``.
        free: bounds by name: parameters, inputs, or what ``design`` takes.
        least: looks for the smallest value instead of the largest.
        limits: lower and upper limits of what a goal may be, None where there is none:
            ``{"blow_energy": (None, "240 J")}``.
        preset: parameter set that a mapping is laid over.
        rock: beside it: a name, a class or a strength, or a file, as `dth_hammer.rock` takes them.
        design: makes parameters of the free numbers, for instance a shape of a given mass.
        tolerance: by which each free number may be off, a part of its value: goal and limits are
            means over hammers that are off by so much, those of a design at a bound to either side
            of it; 0 for the design alone.
        starts: number of starts at most; the first is where the hammer is, or the middle of the
            bounds.
        error: relative standard error of the rate of penetration of each design.
        seed: random seed of the other starts.
        progress: shows how many designs were tried.

    Raises:
        RefusedError: no design keeps the limits, or none has a long-run response.

    Example:
        >>> from dth_hammer import optimise
        >>> rigid = {"fidelity": "Rigid"}
        >>> best = optimise(rigid, "blow_energy", {"drive.stroke": ("30 mm", "60 mm")}, starts=1)
        >>> stroke = 1e3 * best.parameters["drive.stroke"]
        >>> print(f"{stroke:.1f} mm: {best.value:.0f} J", best.at_bounds)
        60.0 mm: 272 J ('drive.stroke',)
    """
    problem = Problem(goal, free, numbers_of(hammer, preset, rock), design=design)
    problem.limits = [*limits_of(limits or {})]
    problem.wanted, problem.sign = Wanted(error=error), 1.0 if least else -1.0
    if starts < 1:
        raise DomainError(f"starts = {starts} must be 1 or more")
    if not 0.0 <= tolerance < 1.0:
        raise DomainError(f"tolerance = {tolerance:g} is not a part of a number, 0 to 1")
    problem.tolerance = tolerance
    problem.bar = bar(progress, unit="design")
    begun = [problem.begin(), *(0.5 + 0.5 * sobol(len(problem.names), starts, seed))][:starts]
    inner = np.clip(begun, 0.05, 0.95)
    strict = problem.wanted
    problem.wanted = replace(strict, error=max(min(LOOSE * error, LOOSEST), error))
    _begin(problem, inner[:2], 0)
    if len(inner) > 2 and not problem.agreed():
        _begin(problem, inner[2:], 2)
    problem.rows.sort(key=lambda row: row.start)
    if not tolerance:
        problem.wanted = strict
    ended = _search(problem, starts, problem.best().place, (NEAR, LAST), PAIRS)
    problem.wanted = strict
    return _described(problem, _chosen(problem), seed, stopped=not ended)


def _begin(problem: Problem, begun: Array, first: int) -> None:
    """Searches from several starts side by side, then takes the mean of the best of each."""

    def one(k: int) -> None:
        _search(problem, first + k, begun[k], (FIRST, COARSE), 0)
        alone = [row for row in problem.rows if row.start == first + k and row.feasible]
        if alone:
            best = min(alone, key=lambda row: row.cost)
            problem.tried(first + k, best.place, PAIRS)

    with ThreadPoolExecutor(max_workers=len(begun)) as crew:
        try:
            [*crew.map(one, range(len(begun)))]
        except BaseException:
            problem.stopped = True
            raise


def _chosen(problem: Problem) -> Row:
    """The best by means over more hammers of the designs that were best by few."""
    rows = sorted(problem.compared(), key=lambda row: row.cost)
    if not problem.tolerance:
        return problem.best()
    places = list({tuple(row.place): row for row in rows}.values())[:CANDIDATES]
    again = [problem.tried(row.start, row.place, FINAL) for row in places]
    return min([row for row in again if row.feasible] or rows, key=lambda row: row.cost)


def _search(
    problem: Problem, start: int, begun: Array, steps: tuple[float, float], pairs: int
) -> bool:
    """Runs one start with a given first and last step; returns whether it converged."""
    scipy = need("scipy.optimize")
    count = len(begun)
    held = []
    if problem.limits:
        inside = scipy.NonlinearConstraint(
            lambda x: problem.tried(start, x, pairs).passed, -np.inf, 0.0
        )
        held.append(inside)
    ending = scipy.minimize(
        lambda x: problem.cost(problem.tried(start, x, pairs)),
        begun,
        method="COBYQA",
        bounds=[(0.0, 1.0)] * count,
        constraints=held,
        options={
            "initial_tr_radius": steps[0],
            "final_tr_radius": steps[1],
            "maxfev": STEPS * (count + 1),
        },
    )
    return bool(ending.success)


def _described(problem: Problem, best: Row, seed: int, *, stopped: bool) -> Optimum:
    found = best.steady
    assert found is not None, "a design that keeps its limits has a response"
    slopes, errors, rough = _around(problem, best, seed)
    values = problem.values(best.place)
    edge = np.minimum(best.place, 1.0 - best.place) <= AT
    names = problem.names
    flat = tuple(
        name
        for k, name in enumerate(names)
        if np.isfinite(slopes[k]) and abs(slopes[k]) <= 2.0 * errors[k] and not edge[k]
    )
    at_bounds = tuple(name for name, at in zip(names, edge, strict=True) if at)
    tight = zip(problem.limits, best.passed, strict=True)
    at_limits = tuple(dict.fromkeys(side[0] for side, passed in tight if passed > -1e-2))
    status, message = _status(problem, best, (slopes, errors, rough), at_bounds + at_limits)
    if stopped:
        status, message = "stopped", "the search did not end by itself: this is the best so far"
    return Optimum(
        parameters=pd.Series(values, index=pd.Index(names), name="value"),
        value=best.goal,
        error=best.error if best.hammers > 1 else _error(problem.goal, found),
        nominal=best.nominal,
        steady=found,
        at_bounds=at_bounds,
        at_limits=at_limits,
        flat=flat,
        roughness=rough,
        status=status,
        message=message,
        history=_history(problem),
    )


def _error(goal: Callable[[Steady], float], found: Steady) -> float:
    """Standard error of a goal by those of the means, as if these were independent."""
    here, square = goal(found), 0.0
    for name in found.error.index[found.error > 0.0]:
        outputs = found.outputs.copy()
        outputs.loc[name, "mean"] += found.error[name]
        square += (goal(replace(found, outputs=outputs)) - here) ** 2
    return float(np.sqrt(square))


def _around(problem: Problem, best: Row, seed: int) -> tuple[Array, Array, float]:
    """Slopes of the goal's logarithm over the bounds, their errors, and the roughness."""
    count = len(problem.names)
    places = np.clip(best.place + AROUND * sobol(count, 2 * count + 4, seed), 0.0, 1.0)
    goals = np.array([problem.tried(-1, place).goal for place in places])
    if np.isfinite(goals).sum() < count + 3:
        return np.full(count, np.nan), np.full(count, np.nan), np.nan
    fit = line(places - best.place, goals)
    return fit.slopes, np.sqrt(np.diag(fit.covariance)[1:]), fit.left


def _status(
    problem: Problem, best: Row, around: tuple[Array, Array, float], held: Sequence[str]
) -> tuple[str, str]:
    slopes, errors, rough = around
    if not np.isfinite(rough):
        return "rough", "most designs close to it are refused"
    free = np.minimum(best.place, 1.0 - best.place) > AT
    rises = np.abs(slopes) > 3.0 * np.maximum(errors, 1e-12)
    gains = float(np.max(np.abs(slopes[free]) * AROUND, initial=0.0))
    by = f", held by {', '.join(held)}" if held else ""
    if held and not free.any():
        return "held", f"all that is free is at a bound, beyond which the goal may go on{by}"
    if not (rises & free).any() and rough < 1e-9:
        return "flat", f"nothing that is free changes the goal there{by}"
    if rough > 0.2 * gains and rough > min(problem.wanted.by_mean.values()):
        text = f"the goal jumps by {100 * rough:.2g} % from design to design: others are as good"
        return "rough", text + by
    return "optimal", f"the best of {len(problem.rows)} designs{by}"


def _history(problem: Problem) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    for row in problem.rows:
        chosen = dict(zip(problem.names, problem.values(row.place), strict=True))
        passed = dict(zip((f"past {s[0]}" for s in problem.limits), row.passed, strict=False))
        rate = {"rop": row.steady["rop"] if row.steady else np.nan}
        rate |= sides(rate, row.steady.parameters if row.steady else {})
        mean = {"goal": row.goal, "error": row.error, "hammers": row.hammers}
        tried = {"start": row.start, **chosen, **mean, **passed, **rate}
        rows.append(tried | {"refused": row.refused})
    return pd.DataFrame(rows)
