"""The best design within bounds and limits, judged by long-run means.

The goal jumps by up to a few per cent between neighbouring designs, so the single best of many
designs is partly luck. The search therefore maximises the mean over hammers whose free numbers
deviate from the design by a stated tolerance, as those of manufactured hammers do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from ..contract import typed
from ..errors import DomainError
from ..extras import bar, need
from ..frames import np, pd
from ..scene.band import sides
from ..scene.hammers import Hammerlike, Rocklike, numbers_of
from ..scene.variables import Array, Value
from ..simulation import answers
from .designs import LIMIT_TOLERANCE, Limits, Measure, Problem, Row, limits_of
from .longrun import Steady, Wanted
from .trends import line, sobol

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Trust-region radii as shares of the distance between the bounds: first and last of each start,
#: then first and last of the final search from the best start.
FIRST, COARSE, NEAR, LAST = 0.25, 0.02, 0.05, 5e-3
#: Pairs of hammers in a mean over the tolerance: during the search, and in the final comparison.
PAIRS, FINAL = 4, 16
#: Number of best designs in the final comparison.
CANDIDATES = 3
#: During the search the allowed error of a mean is this many times larger, at most `LOOSEST`.
LOOSE, LOOSEST = 4.0, 0.02
#: Largest number of evaluations of a search, for each free number (plus one).
STEPS = 20
#: Half width of the box in which slopes at the optimum are fitted, as a share of the distance
#: between the bounds.
BOX = 0.02
#: A free number counts as at a bound if it is within this share of the range from it.
AT_BOUND = 5e-3


@dataclass(frozen=True, repr=False)
class Optimum(answers.Answer):
    """The best design found."""

    #: Free numbers of the best design.
    parameters: pd.Series
    #: Goal of the best design, averaged over the tolerance.
    value: float
    #: Standard error of `value`. It follows from the scatter of the hammers in the mean; without a
    #: tolerance, from the errors of the long-run means in the goal.
    error: float
    #: Goal of the design itself, without the tolerance.
    nominal: float
    #: Long-run response of the design itself.
    steady: Steady
    #: Free numbers that are at a bound.
    at_bounds: tuple[str, ...]
    #: Limits that the design just satisfies.
    at_limits: tuple[str, ...]
    #: Free numbers that have no significant effect on the goal near the optimum.
    flat: tuple[str, ...]
    #: Relative scatter of the goal between neighbouring designs near the optimum.
    roughness: float
    #: ``optimal``, ``held``, ``rough``, ``flat`` or ``stopped``; `message` explains it.
    status: str
    message: str
    #: All designs in the order of trial: start, free numbers, goal, its error, the number of
    #: hammers in its mean, by how much each limit is exceeded, the rate of penetration with its
    #: range (``rop_low``, ``rop_high``), and the reason if the design was refused.
    history: pd.DataFrame = field(repr=False)

    @property
    def evaluations(self) -> int:
        """Number of designs tried."""
        return len(self.history)

    @property
    def hammers(self) -> int:
        """Number of hammers simulated for all designs."""
        return int(self.history["hammers"].sum())

    caption = "The goal of every design"

    def in_words(self) -> list[str]:
        """Returns the goal with the status of the search, then the rate of penetration."""
        return [f"{self.value:.6g} ({self.status}): {self.message}", self.steady.rate]

    def to_frame(self) -> pd.DataFrame:
        """Returns the free numbers of the best design."""
        return self.parameters.to_frame("value")

    def plot(self) -> Figure:
        """Plots the goal of every design in the order of trial."""
        return answers.history(self.history, self.value, LIMIT_TOLERANCE)


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

    The search uses COBYQA (`scipy.optimize.minimize`), which needs no derivatives:

    1. It searches from two starts in parallel, with one hammer per design. If the two best designs
       differ, it searches from the other starts too.
    2. It searches once more from the best design of all starts, now with means over the tolerance.
    3. It compares the best designs of that search by means over more hammers.
    4. It fits a plane to the goal in a small box around the optimum, for slopes and roughness.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        goal: a mean of `Steady`; ``power`` (energy of blows over time), ``piston_mass``,
            ``bit_mass``, ``piston_stress`` or ``bit_stress`` (largest axial stress of a settled
            cycle, on the hammer's own mesh); or a function of a `Steady`:
            ``lambda s: s["energy_drive"] / s["advance"]``.
        free: bounds by name of a parameter or an input, or of a number that ``design`` takes.
        least: looks for the smallest value instead of the largest.
        limits: lower and upper limits by measure (whatever a goal may be), None for no limit:
            ``{"blow_energy": (None, "240 J")}``.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        design: returns parameters for given free numbers, for instance a shape of a given mass.
        tolerance: relative deviation of the free numbers of manufactured hammers. Goal and limits
            are means over hammers that deviate by up to this in both directions, also beyond a
            bound; with 0 only the design itself counts.
        starts: largest number of starts; the first is the hammer's own design, moved inside the
            bounds. A number that the hammer does not have starts at the middle of its bounds.
        error: relative standard error of the rate of penetration of each design.
        seed: random seed of the other starts.
        progress: shows how many designs were tried.

    Raises:
        RefusedError: no design satisfies the limits, or none has a long-run response.

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
    start_places = [problem.begin(), *(0.5 + 0.5 * sobol(len(problem.names), starts, seed))][
        :starts
    ]
    inside_bounds = np.clip(start_places, 0.05, 0.95)
    strict_settings = problem.wanted
    problem.wanted = replace(strict_settings, error=max(min(LOOSE * error, LOOSEST), error))
    _begin(problem, inside_bounds[:2], 0)
    if len(inside_bounds) > 2 and not problem.agreed():
        _begin(problem, inside_bounds[2:], 2)
    problem.rows.sort(key=lambda row: row.start)
    if not tolerance:
        problem.wanted = strict_settings
    converged = _search(problem, starts, problem.best().place, (NEAR, LAST), PAIRS)
    problem.wanted = strict_settings
    return _described(problem, _chosen(problem), seed, stopped=not converged)


def _begin(problem: Problem, begun: Array, first: int) -> None:
    """Searches from several starts in parallel, then averages each best design over the tolerance.

    ``first`` is the number of the first of these starts.
    """

    def search(k: int) -> None:
        _search(problem, first + k, begun[k], (FIRST, COARSE), 0)
        own_rows = [row for row in problem.rows if row.start == first + k and row.feasible]
        if own_rows:
            best = min(own_rows, key=lambda row: row.cost)
            problem.tried(first + k, best.place, PAIRS)

    with ThreadPoolExecutor(max_workers=len(begun)) as crew:
        try:
            [*crew.map(search, range(len(begun)))]
        except BaseException:
            problem.stopped = True
            raise


def _chosen(problem: Problem) -> Row:
    """Returns the best of the leading designs, compared by means over more hammers."""
    rows = sorted(problem.compared(), key=lambda row: row.cost)
    if not problem.tolerance:
        return problem.best()
    places = list({tuple(row.place): row for row in rows}.values())[:CANDIDATES]
    rows_over_more = [problem.tried(row.start, row.place, FINAL) for row in places]
    return min([row for row in rows_over_more if row.feasible] or rows, key=lambda row: row.cost)


def _search(
    problem: Problem, start: int, begun: Array, steps: tuple[float, float], pairs: int
) -> bool:
    """Searches from one start with a first and a last step; returns whether it converged."""
    scipy = need("scipy.optimize")
    count = len(begun)
    constraints = []
    if problem.limits:
        limits = scipy.NonlinearConstraint(
            lambda x: problem.tried(start, x, pairs).passed, -np.inf, 0.0
        )
        constraints.append(limits)
    result = scipy.minimize(
        lambda x: problem.cost(problem.tried(start, x, pairs)),
        begun,
        method="COBYQA",
        bounds=[(0.0, 1.0)] * count,
        constraints=constraints,
        options={
            "initial_tr_radius": steps[0],
            "final_tr_radius": steps[1],
            "maxfev": STEPS * (count + 1),
        },
    )
    return bool(result.success)


def _described(problem: Problem, best: Row, seed: int, *, stopped: bool) -> Optimum:
    response = best.steady
    assert response is not None, "a design that keeps its limits has a response"
    slopes, errors, rough = _around(problem, best, seed)
    values = problem.values(best.place)
    at_bound = np.minimum(best.place, 1.0 - best.place) <= AT_BOUND
    names = problem.names
    flat = tuple(
        name
        for k, name in enumerate(names)
        if np.isfinite(slopes[k]) and abs(slopes[k]) <= 2.0 * errors[k] and not at_bound[k]
    )
    at_bounds = tuple(
        name for name, is_at_bound in zip(names, at_bound, strict=True) if is_at_bound
    )
    limit_rows = zip(problem.limits, best.passed, strict=True)
    at_limits = tuple(dict.fromkeys(side[0] for side, passed in limit_rows if passed > -1e-2))
    status, message = _status(problem, best, (slopes, errors, rough), at_bounds + at_limits)
    if stopped:
        status, message = "stopped", "the search did not end by itself: this is the best so far"
    return Optimum(
        parameters=pd.Series(values, index=pd.Index(names), name="value"),
        value=best.goal,
        error=best.error if best.hammers > 1 else _error(problem.goal, response),
        nominal=best.nominal,
        steady=response,
        at_bounds=at_bounds,
        at_limits=at_limits,
        flat=flat,
        roughness=rough,
        status=status,
        message=message,
        history=_history(problem),
    )


def _error(goal: Callable[[Steady], float], response: Steady) -> float:
    """Returns the standard error of a goal from those of the means, taken as independent."""
    value, square = goal(response), 0.0
    for name in response.error.index[response.error > 0.0]:
        outputs = response.outputs.copy()
        outputs.loc[name, "mean"] += response.error[name]
        square += (goal(replace(response, outputs=outputs)) - value) ** 2
    return float(np.sqrt(square))


def _around(problem: Problem, best: Row, seed: int) -> tuple[Array, Array, float]:
    """Returns slopes of the goal's logarithm near the optimum, their errors, and the roughness.

    The slopes are with respect to the free numbers scaled to 0 to 1 between their bounds.
    """
    count = len(problem.names)
    places = np.clip(best.place + BOX * sobol(count, 2 * count + 4, seed), 0.0, 1.0)
    goals = np.array([problem.tried(-1, place).goal for place in places])
    if np.isfinite(goals).sum() < count + 3:
        return np.full(count, np.nan), np.full(count, np.nan), np.nan
    fit = line(places - best.place, goals)
    return fit.slopes, np.sqrt(np.diag(fit.covariance)[1:]), fit.residual


def _status(
    problem: Problem, best: Row, around: tuple[Array, Array, float], held: Sequence[str]
) -> tuple[str, str]:
    slopes, errors, rough = around
    if not np.isfinite(rough):
        return "rough", "most designs close to it are refused"
    free = np.minimum(best.place, 1.0 - best.place) > AT_BOUND
    significant = np.abs(slopes) > 3.0 * np.maximum(errors, 1e-12)
    largest_gain = float(np.max(np.abs(slopes[free]) * BOX, initial=0.0))
    held_text = f", held by {', '.join(held)}" if held else ""
    if held and not free.any():
        return "held", f"all that is free is at a bound, beyond which the goal may go on{held_text}"
    if not (significant & free).any() and rough < 1e-9:
        return "flat", f"nothing that is free changes the goal there{held_text}"
    if rough > 0.2 * largest_gain and rough > min(problem.wanted.by_mean.values()):
        text = f"the goal jumps by {100 * rough:.2g} % from design to design: others are as good"
        return "rough", text + held_text
    return "optimal", f"the best of {len(problem.rows)} designs{held_text}"


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
