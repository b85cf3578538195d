"""The stationary cycle, as a solved equation: what a hammer settles to, and its derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pandas as pd

from .errors import DomainError, RefusedError
from .gradients import announced
from .instance import Instance
from .package import Package, load
from .variables import Array, Value

#: Works and losses of a period.
ENERGY = "energy_"
#: Numbers of a cycle that `Cycle` has as they are.
PLAIN = (
    "period",
    "advance",
    "rop",
    "blow_phase",
    "blow_speed",
    "blow_energy",
    "rebound_speed",
    "contact_force_peak",
    "rock_force_peak",
)


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
    #: Leading multipliers: what is left of a disturbance after a cycle.
    multipliers: Array
    #: Whether all of them are below one.
    stable: bool
    #: Derivatives of the cycle's numbers (rows) by parameters and inputs (columns).
    gradient: pd.DataFrame
    #: How far each may change before events change their order, to first order.
    reach: pd.Series
    #: Places where derivatives hold on one side at most.
    cautions: int
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
class Waypoint:
    """A point of a branch of cycles."""

    #: The parameter's value.
    value: float
    cycle: Cycle
    #: Whether the parameter rises where the branch goes on.
    rises: bool
    #: Whether the way to here was not resolved: over a jump, or past what is finer than strides.
    over: bool
    #: Whether events changed their order since the last point.
    other_order: bool


class Cycles:
    """Cycles of one hammer after another, by one instance of the FMU."""

    def __init__(
        self,
        parameters: Mapping[str, Value] | None = None,
        *,
        preset: str | None = None,
        laps: int = 1,
        fmu: str | Path | Package | None = None,
    ) -> None:
        self.package = load(fmu)
        self._told = announced(self.package)
        self._numbers = self.package.values(preset, parameters)
        self._instance = Instance(self.package, lambda _text: None)
        self._continues = False
        try:
            self._write(self._numbers)
            self.settings(laps=laps)
        except BaseException:
            self.close()
            raise

    def settings(self, **values: float) -> None:
        """How cycles are sought: ``laps`` (turns of the relay that one closes after),
        ``settle`` (simulated first), ``steps`` (at most), ``longest_lap`` (s),
        ``krylov_vectors`` (for multipliers), ``continues`` (1: from the last one found; 2: from
        there, simulated first).
        """
        for name, value in values.items():
            if name not in self._told.settings:
                raise DomainError(f"no setting {name!r}: there is {', '.join(self._told.settings)}")
            self._set(self._told.settings[name], float(value))

    def value(self, name: str) -> float:
        """A parameter's or input's value."""
        variable = self.package.variables.settable(name)
        start = 0.0 if variable.start is None else variable.start
        return self._numbers.get(name, start)

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
        changed = self.package.values(None, parameters)
        self._numbers |= changed
        self._write(changed)
        self.settings(continues=float(near) * (2.0 if settle else 1.0), waypoint=0.0)
        return self._told_of(gradient)

    def branch(self, name: str, stride: float, gradient: Iterable[str] = ()) -> Iterator[Waypoint]:
        """The branch of cycles from the last one found on, along a parameter.

        Through folds, where the parameter turns back, and on where the cycle no longer attracts.

        Args:
            name: parameter or input, not 0.
            stride: the longest, in parts of its value; the sign says which way it goes at first.
            gradient: what the cycles are differentiated by.

        Yields:
            One point after another; none where the branch ends.
        """
        along = self.package.variables.settable(name).reference
        self.settings(continues=1.0, waypoint=0.0, branch_along=along, branch_stride=stride)
        last = self._read(self._told.cycle["fingerprint"])
        for number in count(1):
            self.settings(waypoint=float(number))
            try:
                cycle = self._told_of(gradient)
            except RefusedError:
                return
            value, rises, over = (self._read(r) for r in self._told.branch.values())
            yield Waypoint(value, cycle, bool(rises), bool(over), cycle.fingerprint != last)
            last = cycle.fingerprint

    def _told_of(self, gradient: Iterable[str]) -> Cycle:
        by = [*dict.fromkeys(gradient)]
        seeds = [self._told.seed(self.package, name) for name in by]
        rows = [name for name in self._told.smooth if name != "reach"]
        table, reach = self._gradient(rows, seeds)
        told = {name: self._read(reference) for name, reference in self._told.cycle.items()}
        known = int(told["multipliers"])
        first = self._told.multipliers
        parts = [self._read(first + k) for k in range(2 * known)]
        return Cycle(
            **{name: told[name] for name in PLAIN},
            blows=int(told["blows"]),
            events=int(told["events"]),
            energies={
                name.removeprefix(ENERGY): value
                for name, value in told.items()
                if name.startswith(ENERGY)
            },
            multipliers=np.array(parts[::2]) + 1j * np.array(parts[1::2]),
            stable=bool(told["stable"]),
            gradient=pd.DataFrame(table, index=pd.Index(rows), columns=pd.Index(by)),
            reach=pd.Series(reach, index=pd.Index(by), name="reach", dtype=float),
            cautions=int(told["cautions"]),
            distance=told["distance"],
            steps=int(told["steps"]),
            fingerprint=int(told["fingerprint"]),
            values={name: self.value(name) for name in by},
        )

    def close(self) -> None:
        """Frees the instance."""
        self._instance.close()

    def __enter__(self) -> Cycles:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.close()

    def _gradient(self, rows: Sequence[str], seeds: Sequence[int]) -> tuple[Array, list[float]]:
        references = [self._told.cycle[name] for name in [*rows, "reach"]]
        call, slave = self._instance.call, self._instance.slave
        if seeds:
            # All at once: one search serves them all.
            call(slave.getDirectionalDerivative, references[:1], [*seeds], [0.0] * len(seeds))
        columns = [
            list(call(slave.getDirectionalDerivative, references, [seed], [1.0])) for seed in seeds
        ]
        found = np.array(columns, dtype=float).reshape(len(seeds), len(references)).T
        return found[:-1], [float(x) for x in found[-1]]

    def _read(self, reference: int) -> float:
        return float(self._instance.call(self._instance.slave.getReal, [reference])[0])

    def _set(self, reference: int, value: float) -> None:
        self._instance.call(self._instance.slave.setReal, [reference], [value])

    def _write(self, numbers: Mapping[str, float]) -> None:
        for name, number in numbers.items():
            variable = self.package.variables[name]
            if variable.kind == "Real":
                self._set(variable.reference, number)
            else:
                slave = self._instance.slave
                self._instance.call(slave.setInteger, [variable.reference], [int(number)])


def stationary(
    parameters: Mapping[str, Value] | None = None,
    gradient: Iterable[str] = (),
    *,
    preset: str | None = None,
    laps: int = 1,
    fmu: str | Path | Package | None = None,
) -> Cycle:
    """The cycle that a hammer with a relay settles to, and its exact derivatives.

    Args:
        parameters: by dotted name, as for `simulate`; constant inputs too.
        gradient: parameters and inputs to differentiate by.
        preset: parameter set to start from.
        laps: turns of the relay that the cycle closes after.
        fmu: file to use instead of the one found.

    Raises:
        RefusedError: there is no such cycle, or none was found; the message says why.
    """
    with Cycles(parameters, preset=preset, laps=laps, fmu=fmu) as cycles:
        return cycles.find(gradient=gradient)


def found(cycles: Cycles, *arguments: Any, **named: Any) -> Cycle | None:
    """The cycle, or None where there is none."""
    try:
        return cycles.find(*arguments, **named)
    except RefusedError:
        return None
