"""The stationary cycle, as a solved equation: what a hammer settles to, and its derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from . import _native
from .errors import DomainError, RefusedError
from .gradients import differentiable
from .variables import Array, Value, numbers, whole

#: Works and losses of a period.
ENERGY = "energy_"


@dataclass(frozen=True)
class Cycle:
    """A stationary cycle, in SI units."""

    #: Time of a cycle, s.
    period: float
    #: Advance of the hole in it, m.
    advance: float
    #: Mean rate of penetration, m/s.
    rop: float
    #: Time from the relay's turn to driving to the (first) impact, s.
    blow_phase: float
    #: Relative mean speed at the (first) impact, m/s.
    blow_speed: float
    #: Half the piston's mass times that squared, J.
    blow_energy: float
    #: Upward mean speed at which the piston leaves the bit for the last time, m/s.
    rebound_speed: float
    #: Blows, and changes of mode, in a cycle.
    blows: int
    events: int
    #: Largest contact and rock force, N.
    contact_force_peak: float
    rock_force_peak: float
    #: Works and losses of a cycle, J.
    energies: Mapping[str, float]
    #: Leading Floquet multipliers: what is left of a disturbance after a cycle.
    multipliers: Array
    #: Whether all of them are below one.
    stable: bool
    #: Derivatives of the cycle's numbers (rows) by parameters and inputs (columns).
    gradient: pd.DataFrame
    #: Errors of these, estimated.
    gradient_errors: pd.DataFrame = field(repr=False)
    #: How far each may change before events change their order, to first order.
    reach: pd.Series
    #: Why derivatives hold on one side at most, in words; empty where all is smooth.
    nonsmooth: tuple[str, ...]
    #: How far the map still moves the state, over its size; steps made.
    distance: float
    steps: int
    #: A number that cycles of another order of events hardly share.
    fingerprint: int
    #: Values of what the gradient is by.
    values: Mapping[str, float] = field(repr=False)

    @property
    def frequency(self) -> float:
        """Cycles per second, Hz."""
        return 1.0 / self.period

    @property
    def rebound_ratio(self) -> float:
        """Rebound speed over impact speed."""
        return self.rebound_speed / self.blow_speed

    def number(self, name: str) -> float:
        """A number that has derivatives, by its name in `gradient`."""
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
    #: Whether the parameter rises where the branch goes on.
    rises: bool
    #: Whether the way to here was not resolved: over a jump, or past what is finer than strides.
    unresolved: bool
    #: Whether events changed their order since the last point.
    other_order: bool


class Cycles:
    """Cycles of one hammer after another, each sought from where the last one was if one likes."""

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
        """How cycles are sought: ``returns`` (returns that one closes after), ``settle`` (simulated
        first), ``steps`` (at most), ``longest_return`` (s), ``krylov_vectors`` (for multipliers).
        """
        self._finder.settings({name: float(value) for name, value in values.items()})

    def value(self, name: str) -> float:
        """A parameter's or input's value."""
        return whole(self._numbers)[name]

    def find(
        self,
        parameters: Mapping[str, Value] | None = None,
        gradient: Iterable[str] = (),
        *,
        near: bool = False,
        settle: bool = True,
    ) -> Cycle:
        """The cycle with these parameters laid over those before.

        Args:
            parameters: by dotted name.
            gradient: what its numbers are differentiated by.
            near: begins where the last one was found.
            settle: simulates first; if not, what is found near need not attract.
        """
        changed, by = numbers(None, parameters), differentiable(gradient)
        self._numbers |= changed
        return self._cycle(self._finder.find(changed, by, near, settle), by)

    def branch(self, name: str, step: float, gradient: Iterable[str] = ()) -> Iterator[BranchPoint]:
        """The branch of cycles from the last one found on, along a parameter.

        Through folds, where the parameter turns back, and on where the cycle no longer attracts.

        Args:
            name: parameter or input, not 0.
            stride: the longest, in parts of its value; the sign says which way it goes at first.
            gradient: what the cycles are differentiated by.

        Yields:
            One point after another; none where the branch ends.
        """
        if step == 0.0:
            raise DomainError("a stride of 0 leads nowhere")
        (along,), by = differentiable([name]), differentiable(gradient)
        last = self._last.fingerprint if self._last else None
        self._finder.begin_branch(along, step > 0.0)
        while True:
            try:
                value, rises, unresolved, found = self._finder.next(abs(step), by)
            except RefusedError:
                return
            cycle = self._cycle(found, by)
            other = last is not None and cycle.fingerprint != last
            yield BranchPoint(value, cycle, rises, unresolved, other)
            last = cycle.fingerprint

    def _cycle(self, found: dict[str, Any], by: list[str]) -> Cycle:
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
        }
        self._last = Cycle(**found)
        return self._last


def stationary(
    parameters: Mapping[str, Value] | None = None,
    gradient: Iterable[str] = (),
    *,
    preset: str | None = None,
    returns: int = 1,
) -> Cycle:
    """The cycle that a hammer settles to, and its derivatives.

    Args:
        parameters: by dotted name, as for `simulate`; constant inputs too.
        gradient: parameters and inputs to differentiate by.
        preset: parameter set to start from.
        returns: returns of the drive that the cycle closes after.

    Raises:
        RefusedError: there is no such cycle, none was found, or it is not stable: the hammer
            does not settle to it; the message says why. `steady` has an answer for every hammer.
    """
    cycle = Cycles(parameters, preset=preset, returns=returns).find(gradient=gradient)
    if not cycle.stable:
        raise RefusedError(
            f"the cycle found is not stable (leading multiplier {cycle.multipliers[0]:.3g}): the "
            "hammer does not settle to it. `steady` tells what it does, `Cycles.find` the cycle"
        )
    return cycle


def found(cycles: Cycles, *arguments: Any, **named: Any) -> Cycle | None:
    """The cycle, or None where there is none."""
    try:
        return cycles.find(*arguments, **named)
    except RefusedError:
        return None
