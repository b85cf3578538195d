"""The stationary cycle as a fixed point of the Poincaré map, and its derivatives."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from . import _native, answers
from .band import in_words
from .contract import typed
from .errors import DomainError, RefusedError, warn
from .gradients import differentiable
from .longrun import MEANS, Wanted, responses, unit
from .motions import SAME
from .variables import Array, Value, numbers, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Works and losses of a period.
ENERGY = "energy_"
#: A warning of slopes.
UNSTABLE = (
    "the cycle is not stable: its slopes are not those of what the hammer does in the long run, "
    "which `trend` finds"
)
#: Error of the mean of a motion that is not the cycle.
ELSEWHERE = 0.05


@dataclass(frozen=True)
class Cycle:
    """A stationary cycle, in SI units."""

    #: Time of a cycle, s.
    period: float
    #: Gain of the tip in it, m.
    advance: float
    #: Rate of penetration of the hole, by specific energy, m/s.
    rop: float
    #: Mean gain of the tip per time, m/s.
    tip_rate: float
    #: Time from the relay's switching to driving until the first impact, s.
    blow_phase: float
    #: Relative mean speed at the first impact, m/s.
    blow_speed: float
    #: Half the piston's mass times that squared, J.
    blow_energy: float
    #: Upward mean speed of the piston when it leaves the bit for the last time, m/s.
    rebound_speed: float
    #: Blows, and changes of mode, in a cycle.
    blows: int
    events: int
    #: Largest contact and rock force, N.
    contact_force_peak: float
    rock_force_peak: float
    #: Works and losses of a cycle, J.
    energies: Mapping[str, float]
    #: Leading Floquet multipliers: the factors of a disturbance after a cycle.
    multipliers: Array
    #: Whether all of them are below 1 in size.
    stable: bool
    #: Derivatives of the cycle's numbers (rows) by parameters and inputs (columns).
    gradient: pd.DataFrame
    #: Estimated errors of the derivatives.
    gradient_errors: pd.DataFrame = field(repr=False)
    #: Least change of each that changes the order of events, to first order.
    reach: pd.Series
    #: Why derivatives are one-sided, in words; empty at a smooth point.
    nonsmooth: tuple[str, ...]
    #: Relative distance between the state and its image; number of steps.
    distance: float
    steps: int
    #: A hash of the order of events.
    fingerprint: int
    #: Values of the parameters of the gradient.
    values: Mapping[str, float] = field(repr=False)
    #: Numbers of all that was set, by name, in SI units.
    parameters: Mapping[str, float] = field(repr=False)

    @property
    def rate(self) -> str:
        """The rate of penetration with the range that the rock's specific energy leaves of it."""
        return in_words(self.rop, self.parameters)

    @property
    def frequency(self) -> float:
        """Cycles per second, Hz."""
        return 1.0 / self.period

    @property
    def rebound_ratio(self) -> float:
        """Rebound speed over impact speed."""
        return self.rebound_speed / self.blow_speed

    def _repr_html_(self) -> str:
        names = [n for n in MEANS if not n.startswith(ENERGY) and hasattr(self, n)]
        rows = pd.DataFrame({"value": [self.number(n) for n in names]}, index=pd.Index(names))
        rows["unit"] = [unit(name) for name in names]
        sizes = ", ".join(f"{size:.3g}" for size in np.abs(self.multipliers))
        text = (
            f"{'stable' if self.stable else 'unstable'} cycle of {self.blows} blows, {self.events} "
        )
        text += f"events; sizes of its multipliers: {sizes}"
        table = f"<p>{text}</p><p>{html.escape(self.rate)}</p>"
        table += rows.to_html(float_format="{:.6g}".format)
        if self.gradient.shape[1]:
            note = "" if self.stable else f": {UNSTABLE}"
            shares = self.elasticities.to_html(float_format="{:.3g}".format)
            table += f"<p>elasticities{note}</p>{shares}"
        return answers.with_figure(table, self.plot, "Energy of a cycle")

    def plot(self) -> Figure:
        """Plots the energy of a cycle: work beside losses."""
        return answers.energies(self.energies)

    def number(self, name: str) -> float:
        """Returns a number of the cycle by its name in `gradient`."""
        if name.startswith(ENERGY):
            return self.energies[name.removeprefix(ENERGY)]
        return float(getattr(self, name))

    @property
    def elasticities(self) -> pd.DataFrame:
        """``d ln number / d ln parameter``."""
        scale = pd.Series(self.values, dtype=float)[self.gradient.columns]
        numbers = pd.Series({name: self.number(str(name)) for name in self.gradient.index})
        return self.gradient.mul(scale, axis=1).div(numbers, axis=0)


@dataclass(frozen=True)
class BranchPoint:
    """A point of a branch of cycles."""

    #: The parameter's value.
    value: float
    cycle: Cycle
    #: Whether the parameter rises in the direction of the branch.
    rises: bool
    #: Whether the branch was not resolved up to here: a jump, or details finer than steps.
    unresolved: bool
    #: Whether the order of events differs from the last point.
    other_order: bool


@typed()
class Cycles:
    """Finds stationary cycles of a hammer; a search may begin at the last cycle found.

    Example:
        >>> from dth_hammer import Cycles
        >>> cycles = Cycles()
        >>> for force in (1600.0, 1800.0):
        ...     print(f"{cycles.find({'drive.amplitude': force}).blow_energy:.0f} J")
        202 J
        227 J
    """

    def __init__(
        self,
        parameters: Mapping[str, Value] | None = None,
        *,
        preset: str | None = None,
        returns: int = 1,
    ) -> None:
        self._numbers = numbers(preset, parameters)
        self._finder = _native.Finder(self._numbers)
        self._last: Cycle | None = None
        self.settings(returns=returns)

    def settings(self, **values: float) -> None:
        """Sets the search: ``returns`` (per cycle), ``settle`` (returns simulated first), ``steps``
        (at most), ``longest_return`` (s), ``krylov_vectors`` (at most, for multipliers).
        """
        self._finder.settings({name: float(value) for name, value in values.items()})

    def value(self, name: str) -> float:
        """Returns the value of a parameter or input."""
        return whole(self._numbers)[name]

    def find(
        self,
        parameters: Mapping[str, Value] | None = None,
        gradient: Iterable[str] = (),
        *,
        near: bool = False,
        settle: bool = True,
    ) -> Cycle:
        """Changes parameters and finds the stationary cycle.

        Args:
            parameters: by dotted name.
            gradient: parameters and inputs to differentiate by.
            near: begins at the last cycle that was found.
            settle: simulates first; otherwise the cycle found is more often unstable.

        Warns of slopes of an unstable cycle: no motion stays on it.
        """
        by = differentiable(gradient)
        cycle = self._nearest(parameters or {}, by, near=near, settle=settle)
        if by and not cycle.stable:
            warn(UNSTABLE)
        return cycle

    def _nearest(
        self,
        parameters: Mapping[str, Value],
        gradient: Iterable[str] = (),
        *,
        near: bool = False,
        settle: bool = True,
    ) -> Cycle:
        """Finds a cycle as `find` does, but warns of nothing."""
        changed, by = numbers(None, parameters), differentiable(gradient)
        self._numbers |= changed
        return self._cycle(self._finder.find(changed, by, near, settle), by)

    def branch(self, name: str, step: float, gradient: Iterable[str] = ()) -> Iterator[BranchPoint]:
        """Follows the branch of cycles from the last one found, along a parameter.

        It continues through folds, where the parameter turns back, and where cycles are unstable.

        Args:
            name: parameter or input, not 0.
            step: the longest step, relative to its value; the sign gives the first direction.
            gradient: parameters and inputs to differentiate by.

        Yields:
            One point after another, until the branch ends.
        """
        if step == 0.0:
            raise DomainError("the step along a branch must not be 0")
        (along,), by = differentiable([name]), differentiable(gradient)
        last = self._last.fingerprint if self._last else None
        self._finder.begin_branch(along, step > 0.0)
        while True:
            try:
                value, rises, unresolved, found = self._finder.next(abs(step), by)
            except RefusedError:
                return
            cycle = self._cycle(found, by, {along: value})
            other = last is not None and cycle.fingerprint != last
            yield BranchPoint(value, cycle, rises, unresolved, other)
            last = cycle.fingerprint

    def _cycle(
        self, found: dict[str, Any], by: list[str], at: Mapping[str, float] | None = None
    ) -> Cycle:
        rows = pd.Index(_native.cycle_numbers())

        def table(values: list[list[float]]) -> pd.DataFrame:
            whole_table = np.array(values, dtype=float).reshape(len(rows), len(by))
            return pd.DataFrame(whole_table, index=rows, columns=pd.Index(by))

        energies = {n.removeprefix(ENERGY): found.pop(n) for n in rows if n.startswith(ENERGY)}
        found |= {
            "gradient": table(found["gradient"]),
            "gradient_errors": table(found["gradient_errors"]),
            "reach": pd.Series(found["reach"], index=pd.Index(by), name="reach", dtype=float),
            "multipliers": np.array([complex(*pair) for pair in found["multipliers"]]),
            "nonsmooth": tuple(found["nonsmooth"]),
            "energies": energies,
            "values": {name: self.value(name) for name in by},
            "parameters": {**self._numbers, **(at or {})},
        }
        self._last = Cycle(**found)
        return self._last


@typed()
def stationary(
    parameters: Mapping[str, Value] | None = None,
    gradient: Iterable[str] = (),
    *,
    preset: str | None = None,
    returns: int = 1,
) -> Cycle:
    """Finds the cycle that a hammer settles to, and its derivatives.

    Warns if a simulation from the hammer's own start settles to another motion.

    Args:
        parameters: by dotted name, as for `simulate`; constant inputs too.
        gradient: parameters and inputs to differentiate by.
        preset: parameter set to start from.
        returns: number of returns of the drive in the cycle.

    Raises:
        RefusedError: no cycle was found, or it is unstable, so the hammer does not settle to it;
            the message says which. `steady` has an answer for every hammer.

    Example:
        >>> from dth_hammer import stationary
        >>> cycle = stationary(gradient=["rock.stiffness"])
        >>> print(f"{1e3 * cycle.period:.3f} ms, stable: {cycle.stable}")
        45.613 ms, stable: True
        >>> print(cycle.elasticities.loc["blow_energy"].round(4).to_dict())
        {'rock.stiffness': 0.0218}
    """
    cycle = Cycles(parameters, preset=preset, returns=returns)._nearest({}, gradient)
    if not cycle.stable:
        leading = f"{cycle.multipliers[0]:.3g}" if len(cycle.multipliers) else "not resolved"
        raise RefusedError(
            f"the cycle found is not stable (leading multiplier {leading}): the hammer does not "
            "settle to it. `steady` tells what it does, `Cycles.find` the cycle"
        )
    _tell_where_it_goes(cycle, numbers(preset, parameters))
    return cycle


def _tell_where_it_goes(cycle: Cycle, given: Mapping[str, float]) -> None:
    """Warns if a simulation from the hammer's start settles to another motion than the cycle."""
    ((_, answer),) = responses([given], Wanted(error=ELSEWHERE))
    if isinstance(answer, str):
        why = answer
    elif answer.kind == "stalled":
        why = "it stalls"
    elif answer.repeats and abs(answer["tip_rate"] / cycle.tip_rate - 1.0) <= SAME:
        return
    else:
        why = f"{answer.kind}, {1e3 * answer['tip_rate']:.5g} mm/s (tip)"
    warn(
        f"a simulation from the start does not go to this cycle of {1e3 * cycle.tip_rate:.5g} mm/s "
        f"(tip): {why}. `steady(starts=16)` tells which motions there are"
    )


def found(cycles: Cycles, *arguments: Any, **named: Any) -> Cycle | None:
    """Returns the cycle, or None where there is none."""
    try:
        return cycles.find(*arguments, **named)
    except RefusedError:
        return None
