"""Designs that an optimisation tries, each as it is or over a tolerance."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import DomainError, DthHammerError, RefusedError
from ..run.gradients import differentiable
from ..scene.quantities import alike, read
from ..scene.variables import VARIABLES, Array, Value, whole
from .longrun import Steady, Wanted, responses
from .measures import measure, unit
from .trends import fitted, lost, sobol

#: A mean by name, or a function of a `Steady`.
Measure = str | Callable[[Steady], float]
#: Lower and upper limit; None where there is none.
Limit = tuple[Value | None, Value | None]
#: Limits of what a goal may be: names, functions, or both.
Limits = Mapping[str, Limit] | Mapping[Callable[[Steady], float], Limit] | Mapping[Measure, Limit]

#: A refused design is so much worse than the worst, in spreads of what was found.
WORSE = 1.0
#: Limits are kept to this part.
KEPT = 1e-4
#: Starts whose best designs agree to this part, or to their errors, are enough.
AGREED = 3e-3


@dataclass
class Row:
    """A design that was tried."""

    start: int
    #: Within the bounds, from 0 to 1.
    place: Array
    #: To be made small; by how much limits are passed, over their size.
    cost: float = np.inf
    passed: Array = field(default_factory=lambda: np.zeros(0))
    goal: float = np.nan
    #: The goal of the design itself, the standard error of the mean, and hammers that it is of.
    nominal: float = np.nan
    error: float = np.nan
    hammers: int = 1
    steady: Steady | None = None
    refused: str = ""

    @property
    def feasible(self) -> bool:
        """Whether the design satisfies its limits."""
        return self.steady is not None and bool((self.passed <= KEPT).all())


class Problem:
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
        #: A bar of progress, if it is wanted.
        self.bar: Any = None

    def _number(self, name: str, value: Value) -> float:
        if self.design is None or name in VARIABLES:
            return VARIABLES.settable(name).number(value)
        return read(value, "1", name)

    def begin(self) -> Array:
        """Returns the scene's own point, moved inside the bounds."""
        known, middle = whole(self.given), 0.5 * (self.low + self.high)
        at = [known.get(name, m) for name, m in zip(self.names, middle, strict=True)]
        return np.asarray(np.clip((np.array(at) - self.low) / (self.high - self.low), 0.0, 1.0))

    def values(self, place: Array) -> Array:
        """The free numbers of a design."""
        return np.asarray(self.low + np.clip(place, 0.0, 1.0) * (self.high - self.low))

    def offsets(self, pairs: int) -> Array:
        """The design itself, and pairs of hammers to either side of it, over the tolerance."""
        count = len(self.names)
        if not (pairs and self.tolerance):
            return np.zeros((1, count))
        half = sobol(count, pairs, seed=pairs)
        return np.concatenate([np.zeros((1, count)), half, -half])

    def numbers(self, values: Array) -> dict[str, float]:
        """The hammer of the free numbers."""
        chosen = dict(zip(self.names, map(float, values), strict=True))
        made = self.design(chosen) if self.design else chosen
        if not isinstance(made, Mapping):
            raise DomainError(f"design returned {made!r}, not parameters by name")
        return {
            **self.given,
            **{name: VARIABLES.settable(name).number(x) for name, x in made.items()},
        }

    def tried(self, start: int, place: Array, pairs: int = 0) -> Row:
        """Simulates a design, alone or over the tolerance; if it is refused or stalls anywhere it
        counts as worse than all others.
        """
        offsets = self.offsets(pairs)
        for row in self.rows:
            same = row.start == start and row.hammers == len(offsets)
            if same and np.array_equal(row.place, place):
                return row
        if self.stopped:
            raise KeyboardInterrupt
        row = Row(start, np.array(place), hammers=len(offsets))
        off = self.values(place) * (1.0 + self.tolerance * offsets)
        try:
            numbers = [self.numbers(values) for values in off]
            found = responses(numbers, self.wanted, stopped=lambda: self.stopped)
        except DthHammerError as error:
            found = [str(error)]
        # What a goal or a limit raises is its own fault, not the design's.
        if bad := next((answer for answer in found if lost(answer)), None):
            row.refused = bad if isinstance(bad, str) else bad.kind
        else:
            self._measured(row, [a for a in found if isinstance(a, Steady)], offsets)
        if row.steady is None:
            row.passed = np.zeros(len(self.limits))
        self.rows.append(row)
        if self.bar is not None:
            self.bar.update()
        return row

    def _measured(self, row: Row, found: Sequence[Steady], offsets: Array) -> None:
        goals = np.array([self.goal(answer) for answer in found])
        if not np.isfinite(goals).all():
            row.refused = "the goal is no number"
            return
        row.steady, row.nominal, row.goal = found[0], float(goals[0]), float(goals.mean())
        row.cost = self.sign * row.goal
        if len(goals) > 1:
            # By what a plane leaves.
            *_, left = fitted(np.column_stack([np.ones(len(goals)), offsets]), goals)
            row.error = left / float(np.sqrt(len(goals)))
        row.passed = np.array(
            [
                way * (np.mean([of(answer) for answer in found]) / size - edge)
                for _, of, way, size, edge in self.limits
            ]
        )

    def compared(self) -> list[Row]:
        """The designs that keep the limits and can be compared: those over the tolerance."""
        rows = [row for row in self.rows if row.feasible and row.start >= 0]
        return [row for row in rows if row.hammers > 1] if self.tolerance else rows

    def agreed(self) -> bool:
        """Whether the best designs of the starts so far are equally good."""
        starts = {row.start for row in self.rows}
        ends = [[r for r in self.compared() if r.start == k] for k in starts]
        if not all(ends):
            return False
        found = [min(rows, key=lambda row: row.cost) for rows in ends]
        goals = [row.goal for row in found]
        errors = np.nan_to_num([row.error for row in found])
        return bool(
            np.ptp(goals) <= max(AGREED * abs(goals[0]), 2.0 * float(np.hypot.reduce(errors)))
        )

    def best(self) -> Row:
        """The best design that keeps the limits."""
        rows = self.compared() or [row for row in self.rows if row.feasible]
        if not rows:
            why = next((row.refused for row in self.rows if row.refused), "the limits")
            raise RefusedError(f"none of {len(self.rows)} designs satisfies {why}")
        return min(rows, key=lambda row: row.cost)

    def cost(self, row: Row) -> float:
        """Returns the cost to minimise, scaled by the cost of its starting point."""
        alike = [r for r in self.rows if r.start == row.start and r.hammers == row.hammers]
        known = [r.cost for r in alike if r.steady is not None]
        scale = abs(known[0]) if known and known[0] else 1.0
        if row.steady is not None:
            return row.cost / scale
        worst = max(known, default=0.0)
        return (worst + WORSE * max(worst - min(known, default=0.0), 0.1 * abs(worst))) / scale


#: Name, measure, side, size, and limit over its size.
_Side = tuple[str, Callable[[Steady], float], float, float, float]


def limits_of(limits: Limits) -> Iterator[_Side]:
    """Returns one number per side of each limit; a positive one violates the limit."""
    for given, pair in limits.items():
        name = given if isinstance(given, str) else getattr(given, "__name__", "limit")
        of = measure(given)
        for bound, way in zip(alike(pair, name), (-1.0, 1.0), strict=True):
            if bound is None:
                continue
            number = read(bound, unit(given) if isinstance(given, str) else "1", name)
            size = abs(number) or 1.0
            yield name, of, way, size, number / size
