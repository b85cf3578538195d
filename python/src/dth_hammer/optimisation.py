"""The best design within bounds and limits, by the means of the long-run response."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from . import answers
from .band import sides
from .contract import typed
from .errors import DomainError, DthHammerError, RefusedError
from .extras import need
from .gradients import differentiable
from .longrun import Hammerlike, Steady, Wanted, named, numbers_of, responses, unit
from .quantities import read
from .trends import line, lost, sobol
from .variables import VARIABLES, Array, Value, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: A mean by name, or a function of a `Steady`.
Measure = str | Callable[[Steady], float]
#: Lower and upper limit; None where there is none.
Limit = tuple[Value | None, Value | None]

#: Over the bounds: a start's first step, the last one, and the first from the best of all starts.
FIRST, LAST, NEAR = 0.25, 5e-3, 0.05
#: Means on the way to it may err by so many times more, up to a largest error.
LOOSE, LOOSEST = 4.0, 0.02
#: Steps of a start, for each parameter.
STEPS = 20
#: A refused design is so much worse than the worst, in spreads of what was found.
WORSE = 1.0
#: Limits are kept to this part.
KEPT = 1e-4
#: Half of the box about the optimum in which it is looked at, over the bounds.
AROUND = 0.02
#: A parameter at less than this part of the bounds from one of them is at it.
AT = 5e-3


@dataclass(frozen=True)
class Optimum:
    """The best design found."""

    parameters: pd.Series
    #: The goal's value, and its standard error by those of the means that it is made of.
    value: float
    error: float
    steady: Steady
    #: Bounds that hold it back, and limits.
    at_bounds: tuple[str, ...]
    at_limits: tuple[str, ...]
    #: Parameters on which the goal does not depend there, within what it jumps.
    flat: tuple[str, ...]
    #: By how much the goal jumps from design to design there, as a part of it.
    roughness: float
    #: ``optimal``, ``rough``, ``flat`` or ``stopped``, and what that means.
    status: str
    message: str
    #: All designs in the order in which they were tried: start, parameters, goal, limits, the
    #: rate of penetration with its range (``rop_low``, ``rop_high``), and why one was refused.
    history: pd.DataFrame = field(repr=False)

    @property
    def evaluations(self) -> int:
        """Number of designs that were tried."""
        return len(self.history)

    def _repr_html_(self) -> str:
        table = f"<p>{self.value:.6g} ({self.status}): {html.escape(self.message)}</p>"
        table += f"<p>{html.escape(self.steady.rate)}</p>"
        table += self.parameters.to_frame("value").to_html(float_format="{:.6g}".format)
        return answers.with_figure(table, self.plot, "The goal of every design")

    def plot(self) -> Figure:
        """Plots the goal of every design that was tried, in order."""
        return answers.history(self.history, self.value, KEPT)


@typed()
def optimise(
    goal: Measure,
    free: Mapping[str, tuple[Value, Value]],
    scene: Hammerlike = None,
    *,
    least: bool = False,
    limits: Mapping[Measure, Limit] | None = None,
    preset: str | None = None,
    design: Callable[[Mapping[str, float]], Mapping[str, Value]] | None = None,
    starts: int = 4,
    error: float = 0.002,
    seed: int = 1,
) -> Optimum:
    """Finds the parameters, within bounds, for which a long-run mean is largest.

    COBYQA (`scipy.optimize.minimize`), which needs no derivatives, from several starts side by
    side with cheap means, then once more from the best of all with means of the error asked for;
    that optimum is then looked at through a plane over a small box around it.

    Args:
        goal: a mean of `Steady`, or a function of it:
            ``lambda s: s["energy_drive"] / s["advance"]``.
        free: bounds by name: parameters, inputs, or what ``design`` takes.
        scene: the others: a `Scene`, or parameters by name.
        least: looks for the smallest value instead.
        limits: lower and upper limits of means or of functions, None where there is none:
            ``{"blow_energy": (None, "240 J")}``.
        preset: parameter set to start from.
        design: makes parameters of the free numbers, for instance a shape of a given mass.
        starts: how many; the first is where ``scene`` is, or the middle of the bounds.
        error: of the rate of penetration of each design, over it.
        seed: of the other starts.

    Raises:
        RefusedError: no design keeps the limits, or none has a long-run response.

    Example:
        >>> from dth_hammer import optimise
        >>> rigid = {"fidelity": "Rigid"}
        >>> best = optimise("blow_energy", {"drive.stroke": ("30 mm", "60 mm")}, rigid, starts=1)
        >>> stroke = 1e3 * best.parameters["drive.stroke"]
        >>> print(f"{stroke:.1f} mm: {best.value:.0f} J", best.at_bounds)
        60.0 mm: 272 J ('drive.stroke',)
    """
    problem = _Problem(goal, free, numbers_of(scene, preset), design=design)
    problem.limits = [*_limits(limits or {})]
    problem.wanted, problem.sign = Wanted(error=error), 1.0 if least else -1.0
    if starts < 1:
        raise DomainError(f"starts = {starts} must be 1 or more")
    begun = [problem.begin(), *(0.5 + 0.5 * sobol(len(problem.names), starts, seed))][:starts]
    strict = problem.wanted
    problem.wanted = replace(strict, error=max(min(LOOSE * error, LOOSEST), error))
    with ThreadPoolExecutor(max_workers=len(begun)) as crew:
        try:
            inner = np.clip(begun, 0.05, 0.95)
            [*crew.map(lambda k: _search(problem, k, inner[k], FIRST), range(len(inner)))]
        except BaseException:
            problem.stopped = True
            raise
    problem.rows.sort(key=lambda row: row.start)
    problem.wanted = strict
    ended = _search(problem, starts, problem.best().place, NEAR)
    return _described(problem, problem.best(starts), seed, stopped=not ended)


@dataclass
class _Row:
    """A design that was tried."""

    start: int
    #: Within the bounds, from 0 to 1.
    place: Array
    #: To be made small; by how much limits are passed, over their size.
    cost: float = np.inf
    passed: Array = field(default_factory=lambda: np.zeros(0))
    goal: float = np.nan
    steady: Steady | None = None
    refused: str = ""

    @property
    def feasible(self) -> bool:
        """Whether the design satisfies its limits."""
        return self.steady is not None and bool((self.passed <= KEPT).all())


class _Problem:
    """A goal, what is free, and what was tried."""

    def __init__(
        self,
        goal: Measure,
        free: Mapping[str, tuple[Value, Value]],
        given: Mapping[str, float],
        *,
        design: Callable[[Mapping[str, float]], Mapping[str, Value]] | None,
    ) -> None:
        self.names = [*free] if design else differentiable(free)
        if not self.names:
            raise DomainError("free is empty: give bounds of at least one parameter")
        self.goal, self.given, self.design = _measure(goal), given, design
        bounds = [[self._number(name, bound) for bound in free[name]] for name in self.names]
        self.low, self.high = np.array(bounds, dtype=float).T
        for name, low, high in zip(self.names, self.low, self.high, strict=True):
            if not low < high:
                raise DomainError(f"{name} from {low:g} to {high:g}: the first must be less")
        self.limits: list[_Side] = []
        self.wanted, self.sign, self.stopped = Wanted(), -1.0, False
        self.rows: list[_Row] = []

    def _number(self, name: str, value: Value) -> float:
        if self.design is None or name in VARIABLES:
            return VARIABLES.settable(name).number(value)
        return read(value, "1", name)

    def begin(self) -> Array:
        """Returns the scene's own point, moved inside the bounds."""
        known, middle = whole(self.given), 0.5 * (self.low + self.high)
        at = [known.get(name, m) for name, m in zip(self.names, middle, strict=True)]
        return np.asarray(np.clip((np.array(at) - self.low) / (self.high - self.low), 0.0, 1.0))

    def numbers(self, place: Array) -> dict[str, float]:
        """The hammer of a design."""
        values = self.low + np.clip(place, 0.0, 1.0) * (self.high - self.low)
        chosen = dict(zip(self.names, map(float, values), strict=True))
        made = self.design(chosen) if self.design else chosen
        if not isinstance(made, Mapping):
            raise DomainError(f"design returned {made!r}, not parameters by name")
        return {
            **self.given,
            **{name: VARIABLES.settable(name).number(x) for name, x in made.items()},
        }

    def tried(self, start: int, place: Array) -> _Row:
        """Simulates a design; one that is refused counts as worse than all others."""
        for row in self.rows:
            if row.start == start and np.array_equal(row.place, place):
                return row
        if self.stopped:
            raise KeyboardInterrupt
        row = _Row(start, np.array(place))
        try:
            numbers = [self.numbers(place)]
            ((_, found),) = responses(numbers, self.wanted, stopped=lambda: self.stopped)
        except DthHammerError as error:
            found = str(error)
        # What a goal or a limit raises is its own fault, not the design's.
        if lost(found):
            row.refused = found if isinstance(found, str) else found.kind
        elif isinstance(found, Steady):
            self._measured(row, found)
        if row.steady is None:
            row.passed = np.zeros(len(self.limits))
        self.rows.append(row)
        return row

    def _measured(self, row: _Row, found: Steady) -> None:
        row.goal = self.goal(found)
        if not np.isfinite(row.goal):
            row.refused = "the goal is no number"
            return
        row.steady, row.cost = found, self.sign * row.goal
        row.passed = np.array(
            [way * (of(found) / size - edge) for _, of, way, size, edge in self.limits]
        )

    def best(self, start: int = 0) -> _Row:
        """The best design that keeps the limits, of those from a start on if there is one."""
        rows = [row for row in self.rows if row.feasible]
        if not rows:
            why = next((row.refused for row in self.rows if row.refused), "the limits")
            raise RefusedError(f"none of {len(self.rows)} designs satisfies {why}")
        return min([r for r in rows if r.start >= start] or rows, key=lambda row: row.cost)

    def cost(self, row: _Row) -> float:
        """Returns the cost to minimise, scaled by the cost of its starting point."""
        known = [r.cost for r in self.rows if r.start == row.start and r.steady is not None]
        scale = abs(known[0]) if known and known[0] else 1.0
        if row.steady is not None:
            return row.cost / scale
        worst = max(known, default=0.0)
        return (worst + WORSE * max(worst - min(known, default=0.0), 0.1 * abs(worst))) / scale


def _measure(given: Measure) -> Callable[[Steady], float]:
    if callable(given):
        return lambda found: read(given(found), "1", getattr(given, "__name__", "the goal"))
    name = named(given)
    return lambda found: found[name]


#: Name, measure, side, size, and limit over its size.
_Side = tuple[str, Callable[[Steady], float], float, float, float]


def _limits(limits: Mapping[Measure, Limit]) -> Iterator[_Side]:
    """Returns one number per side of each limit; a positive one violates the limit."""
    for given, pair in limits.items():
        name = given if isinstance(given, str) else getattr(given, "__name__", "limit")
        of = _measure(given)
        for bound, way in zip(pair, (-1.0, 1.0), strict=True):
            if bound is None:
                continue
            number = read(bound, unit(given) if isinstance(given, str) else "1", name)
            size = abs(number) or 1.0
            yield name, of, way, size, number / size


def _search(problem: _Problem, start: int, begun: Array, first: float) -> bool:
    """Runs one start with a given first step; returns whether it converged."""
    scipy = need("scipy.optimize", "fit")
    count = len(begun)
    held = []
    if problem.limits:
        inside = scipy.NonlinearConstraint(lambda x: problem.tried(start, x).passed, -np.inf, 0.0)
        held.append(inside)
    ending = scipy.minimize(
        lambda x: problem.cost(problem.tried(start, x)),
        begun,
        method="COBYQA",
        bounds=[(0.0, 1.0)] * count,
        constraints=held,
        options={
            "initial_tr_radius": first,
            "final_tr_radius": LAST,
            "maxfev": STEPS * (count + 1),
        },
    )
    return bool(ending.success)


def _described(problem: _Problem, best: _Row, seed: int, *, stopped: bool) -> Optimum:
    found = best.steady
    assert found is not None, "a design that keeps its limits has a response"
    slopes, errors, rough = _around(problem, best, seed)
    values = problem.low + np.clip(best.place, 0.0, 1.0) * (problem.high - problem.low)
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
        error=_error(problem.goal, found),
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


def _around(problem: _Problem, best: _Row, seed: int) -> tuple[Array, Array, float]:
    """Slopes of the goal's logarithm over the bounds, their errors, and the roughness."""
    count = len(problem.names)
    places = np.clip(best.place + AROUND * sobol(count, 2 * count + 4, seed), 0.0, 1.0)
    goals = np.array([problem.tried(-1, place).goal for place in places])
    if np.isfinite(goals).sum() < count + 3:
        return np.full(count, np.nan), np.full(count, np.nan), np.nan
    fit = line(places - best.place, goals)
    return fit.slopes, np.sqrt(np.diag(fit.covariance)[1:]), fit.left


def _status(
    problem: _Problem, best: _Row, around: tuple[Array, Array, float], held: Sequence[str]
) -> tuple[str, str]:
    slopes, errors, rough = around
    if not np.isfinite(rough):
        return "rough", "most designs close to it are refused"
    free = np.minimum(best.place, 1.0 - best.place) > AT
    rises = np.abs(slopes) > 3.0 * np.maximum(errors, 1e-12)
    gains = float(np.max(np.abs(slopes[free]) * AROUND, initial=0.0))
    by = f", held by {', '.join(held)}" if held else ""
    if not (rises & free).any() and rough < 1e-9:
        return "flat", f"nothing that is free changes the goal there{by}"
    if rough > 0.2 * gains and rough > min(problem.wanted.by_mean.values()):
        text = f"the goal jumps by {100 * rough:.2g} % from design to design: others are as good"
        return "rough", text + by
    return "optimal", f"the best of {len(problem.rows)} designs{by}"


def _history(problem: _Problem) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    for row in problem.rows:
        values = problem.low + row.place * (problem.high - problem.low)
        chosen = dict(zip(problem.names, values, strict=True))
        passed = dict(zip((f"past {s[0]}" for s in problem.limits), row.passed, strict=False))
        rate = {"rop": row.steady["rop"] if row.steady else np.nan}
        rate |= sides(rate, row.steady.parameters if row.steady else {})
        tried = {"start": row.start, **chosen, "goal": row.goal, **passed, **rate}
        rows.append(tried | {"refused": row.refused})
    return pd.DataFrame(rows)
