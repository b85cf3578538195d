"""Records of a sensor over time, and what a hammer would have shown there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from .errors import DomainError, UnknownNameError
from .gradients import announced
from .hammer import Hammer
from .package import Package
from .variables import Array

#: Step by which an impact is looked for, and how far beyond it its derivative is read, s.
STRIDE, BEYOND = 5e-3, 1e-9
#: Longest time from one impact to the next, s.
LONGEST = 10.0


@dataclass(frozen=True)
class Record:
    """Samples of a force or a motion, as a sensor gives them.

    Args:
        signal: an output that has derivatives: ``contact_force``, ``rock_force``,
            ``piston_velocity``, ``bit_tip_position`` and so on.
        samples: values in SI units over time in seconds, rising.
        error: standard error of a sample, or one for each.
        blow: the impact that times count from, 1 the first; ``None``: from the start. Of a
            hammer that drills steadily, any blow that has forgotten the start.
    """

    signal: str
    samples: pd.Series
    error: float | Sequence[float] | Array
    blow: int | None = 1

    def __post_init__(self) -> None:
        times, values, errors = self.times, self.values, self.errors
        if not len(times) or (np.diff(times) <= 0.0).any() or times[0] < 0.0:
            raise DomainError(f"a record of {self.signal} needs rising times from 0 on")
        if not np.isfinite(values).all():
            raise DomainError(f"a record of {self.signal} has samples that are no numbers")
        if errors.shape != times.shape or not (errors > 0.0).all() or not np.isfinite(errors).all():
            raise DomainError(
                f"a record of {self.signal} needs one error above 0, or one for each sample"
            )
        if self.blow is not None and self.blow < 1:
            raise DomainError(f"blow = {self.blow}: the first is 1")

    @property
    def times(self) -> Array:
        """Instants of the samples, s."""
        return np.asarray(self.samples.index, dtype=float)

    @property
    def values(self) -> Array:
        """The samples."""
        return self.samples.to_numpy(float)

    @property
    def errors(self) -> Array:
        """A standard error each."""
        given = np.asarray(self.error, dtype=float)
        return np.full(len(self.samples), float(given)) if given.ndim == 0 else given


def check(package: Package, records: Sequence[Record]) -> None:
    """Refuses a record of what has no derivatives."""
    told = announced(package)
    known = [name for name in told.outputs if name not in told.on_demand]
    for record in records:
        if record.signal not in known:
            raise UnknownNameError("signal with derivatives", record.signal, known)


def seen(
    record: Record, package: Package, parameters: Mapping[str, float], by: Sequence[str] = ()
) -> tuple[Array, Array]:
    """What a record would be of a hammer with these parameters, and its derivatives.

    A sample is taken a given time after the impact, which moves with a parameter: to its
    derivative at a fixed time comes its rate times that of the impact.

    Returns:
        The samples, and a row of derivatives by each.
    """
    values = np.empty(len(record.samples))
    slopes = np.zeros((len(values), len(by)))
    with Hammer(parameters, fmu=package, quiet=True, gradient=by) as hammer:
        began, moves = (0.0, np.zeros(len(by)))
        if record.blow is not None:
            began, moves = _impact(hammer, record.blow, bool(by))
        for i, time in enumerate(record.times):
            hammer.advance(max(began + float(time), hammer.time))
            values[i] = hammer[record.signal]
            if by:
                slopes[i] = hammer.slopes.of([record.signal])[0]
                slopes[i] += hammer.rate(record.signal) * moves
    return values, slopes


def _impact(hammer: Hammer, number: int, differentiated: bool) -> tuple[float, Array]:
    """The instant of an impact and its derivatives; the hammer stands before it."""
    last, before = 0.0, hammer.save()
    while True:
        count = int(hammer["blow_count"])
        hammer.step(STRIDE)
        told = hammer.step_blows()["blow_time"]
        if count + len(told) >= number:
            break
        last = told[-1] if told else last
        if hammer.time - last > LONGEST:
            raise DomainError(f"blow {number} does not come: none for {LONGEST:g} s")
        hammer.forget(before)
        before = hammer.save()
    began = told[number - count - 1]
    moves = np.zeros(0)
    if differentiated:
        hammer.restore(before)
        hammer.advance(began + BEYOND)
        moves = hammer.slopes.of(["blow_time"])[0]
    hammer.restore(before)
    hammer.forget(before)
    return began, moves
