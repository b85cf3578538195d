"""The designs that an optimisation tries, each simulated as it is or averaged over a tolerance."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..errors import DomainError, DthHammerError, RefusedError
from ..frames import np
from ..scene.quantities import alike, read
from ..scene.variables import VARIABLES, Array, Value, whole
from ..simulation.gradients import differentiable
from .longrun import Steady, Wanted, responses
from .measures import measure, unit
from .trends import fitted, has_no_response, sobol

#: A measure of a hammer: the name of a mean, or a function of a `Steady`.
Measure = str | Callable[[Steady], float]
#: Lower and upper limit; None for no limit on that side.
Limit = tuple[Value | None, Value | None]
#: Limits by measure; a measure is a name or a function.
Limits = Mapping[str, Limit] | Mapping[Callable[[Steady], float], Limit] | Mapping[Measure, Limit]

#: Penalty of a refused design: its cost exceeds the worst known cost by this many times the
#: difference between the worst and the best known cost.
PENALTY = 1.0
#: A limit counts as satisfied if it is exceeded by no more than this, relative to the limit.
LIMIT_TOLERANCE = 1e-4
#: The search needs no further starts if the best goals of the first ones agree within this relative
#: difference, or within twice their combined standard error.
AGREEMENT = 3e-3


@dataclass
class Row:
    """A design that was tried."""

    #: Number of the start that tried it; -1 for designs that only probe the optimum.
    start: int
    #: Free numbers, scaled so that 0 and 1 are their bounds.
    place: Array
    #: The quantity to minimise: the goal, with its sign changed if it is to be maximised.
    cost: float = math.inf
    #: By how much each limit is exceeded, relative to the limit; negative within the limit.
    passed: Array = field(default_factory=lambda: np.zeros(0))
    #: Mean of the goal over the hammers of the design.
    goal: float = math.nan
    #: Goal of the design itself, without the tolerance.
    nominal: float = math.nan
    #: Standard error of `goal`.
    error: float = math.nan
    #: Number of hammers that `goal` is the mean of.
    hammers: int = 1
    steady: Steady | None = None
    refused: str = ""

    @property
    def feasible(self) -> bool:
        """Whether the design satisfies its limits."""
        return self.steady is not None and bool((self.passed <= LIMIT_TOLERANCE).all())


class Problem:
    """An optimisation problem: the goal, the free numbers, and the designs tried so far."""

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
        self.goal, self.given, self.design = measure(goal), given, design
        bounds = [
            [self._number(name, bound) for bound in alike(free[name], name)] for name in self.names
        ]
        self.low, self.high = np.array(bounds, dtype=float).T
        for name, low, high in zip(self.names, self.low, self.high, strict=True):
            if not low < high:
                raise DomainError(f"{name} from {low:g} to {high:g}: the first must be less")
        self.limits: list[_Side] = []
        self.wanted, self.sign, self.stopped, self.tolerance = Wanted(), -1.0, False, 0.0
        self.rows: list[Row] = []
        #: Progress bar; None if the user does not want one.
        self.bar: Any = None

    def _number(self, name: str, value: Value) -> float:
        if self.design is None or name in VARIABLES:
            return VARIABLES.settable(name).number(value)
        return read(value, "1", name)

    def begin(self) -> Array:
        """Returns the hammer's own design, moved inside the bounds and scaled to 0 to 1."""
        own_values, middle = whole(self.given), 0.5 * (self.low + self.high)
        place = [own_values.get(name, m) for name, m in zip(self.names, middle, strict=True)]
        return np.asarray(np.clip((np.array(place) - self.low) / (self.high - self.low), 0.0, 1.0))

    def values(self, place: Array) -> Array:
        """Returns the free numbers, in SI units, of a scaled design."""
        return np.asarray(self.low + np.clip(place, 0.0, 1.0) * (self.high - self.low))

    def offsets(self, pairs: int) -> Array:
        """Returns the offsets of a design's hammers, in units of the tolerance.

        The first row is the design itself. The others are Sobol points and their mirror images, so
        that a linear dependence cancels in the mean.
        """
        count = len(self.names)
        if not (pairs and self.tolerance):
            return np.zeros((1, count))
        half = sobol(count, pairs, seed=pairs)
        return np.concatenate([np.zeros((1, count)), half, -half])

    def numbers(self, values: Array) -> dict[str, float]:
        """Returns the checked numbers of the hammer with these free numbers."""
        chosen = dict(zip(self.names, map(float, values), strict=True))
        parameters = self.design(chosen) if self.design else chosen
        if not isinstance(parameters, Mapping):
            raise DomainError(f"design returned {parameters!r}, not parameters by name")
        return {
            **self.given,
            **{name: VARIABLES.settable(name).number(x) for name, x in parameters.items()},
        }

    def tried(self, start: int, place: Array, pairs: int = 0) -> Row:
        """Simulates a design, alone or with pairs of hammers within the tolerance.

        If any of these hammers is refused or stalls, the design counts as worse than all others.
        """
        offsets = self.offsets(pairs)
        for row in self.rows:
            same = row.start == start and row.hammers == len(offsets)
            if same and np.array_equal(row.place, place):
                return row
        if self.stopped:
            raise KeyboardInterrupt
        row = Row(start, np.array(place), hammers=len(offsets))
        free_numbers = self.values(place) * (1.0 + self.tolerance * offsets)
        try:
            numbers = [self.numbers(values) for values in free_numbers]
            answers = responses(numbers, self.wanted, stopped=lambda: self.stopped)
        except DthHammerError as error:
            answers = [str(error)]
        # Goal and limits are evaluated outside the try block: their errors must reach the user.
        if failure := next((answer for answer in answers if has_no_response(answer)), None):
            row.refused = failure if isinstance(failure, str) else failure.kind
        else:
            self._measured(row, [a for a in answers if isinstance(a, Steady)], offsets)
        if row.steady is None:
            row.passed = np.zeros(len(self.limits))
        self.rows.append(row)
        if self.bar is not None:
            self.bar.update()
        return row

    def _measured(self, row: Row, answers: Sequence[Steady], offsets: Array) -> None:
        goals = np.array([self.goal(answer) for answer in answers])
        if not np.isfinite(goals).all():
            row.refused = "the goal is no number"
            return
        row.steady, row.nominal, row.goal = answers[0], float(goals[0]), float(goals.mean())
        row.cost = self.sign * row.goal
        if len(goals) > 1:
            # The scatter of the mean is what remains after a linear fit in the offsets.
            *_, scatter = fitted(np.column_stack([np.ones(len(goals)), offsets]), goals)
            row.error = scatter / float(np.sqrt(len(goals)))
        row.passed = np.array(
            [
                sign * (np.mean([function(answer) for answer in answers]) / size - edge)
                for _, function, sign, size, edge in self.limits
            ]
        )

    def compared(self) -> list[Row]:
        """Returns the designs that satisfy the limits and may be compared with each other.

        With a tolerance these are only the designs whose goal is a mean over several hammers.
        """
        rows = [row for row in self.rows if row.feasible and row.start >= 0]
        return [row for row in rows if row.hammers > 1] if self.tolerance else rows

    def agreed(self) -> bool:
        """Returns whether the best designs of all starts so far are equally good."""
        starts = {row.start for row in self.rows}
        rows_by_start = [[r for r in self.compared() if r.start == k] for k in starts]
        if not all(rows_by_start):
            return False
        best_rows = [min(rows, key=lambda row: row.cost) for rows in rows_by_start]
        goals = [row.goal for row in best_rows]
        errors = np.nan_to_num([row.error for row in best_rows])
        return bool(
            np.ptp(goals) <= max(AGREEMENT * abs(goals[0]), 2.0 * float(np.hypot.reduce(errors)))
        )

    def best(self) -> Row:
        """Returns the best design that satisfies the limits."""
        rows = self.compared() or [row for row in self.rows if row.feasible]
        if not rows:
            reason = next((row.refused for row in self.rows if row.refused), "the limits")
            raise RefusedError(f"none of {len(self.rows)} designs satisfies {reason}")
        return min(rows, key=lambda row: row.cost)

    def cost(self, row: Row) -> float:
        """Returns the cost to minimise, scaled by the cost of its starting point."""
        same_start = [r for r in self.rows if r.start == row.start and r.hammers == row.hammers]
        known_costs = [r.cost for r in same_start if r.steady is not None]
        scale = abs(known_costs[0]) if known_costs and known_costs[0] else 1.0
        if row.steady is not None:
            return row.cost / scale
        worst = max(known_costs, default=0.0)
        return (
            worst + PENALTY * max(worst - min(known_costs, default=0.0), 0.1 * abs(worst))
        ) / scale


#: One side of a limit: name, measure, sign (-1 lower, 1 upper), size of the limit, limit over size.
_Side = tuple[str, Callable[[Steady], float], float, float, float]


def limits_of(limits: Limits) -> Iterator[_Side]:
    """Yields the sides of all limits, in the units of the measures."""
    for given, pair in limits.items():
        name = given if isinstance(given, str) else getattr(given, "__name__", "limit")
        function = measure(given)
        for bound, sign in zip(alike(pair, name), (-1.0, 1.0), strict=True):
            if bound is None:
                continue
            number = read(bound, unit(given) if isinstance(given, str) else "1", name)
            size = abs(number) or 1.0
            yield name, function, sign, size, number / size
