"""Measured records of a sensor over time, and the same record as a simulated hammer gives it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..contract import typed
from ..errors import DomainError, UnknownNameError
from ..frames import np, pd
from ..scene.hammers import Hammerlike, numbers_of
from ..scene.variables import VARIABLES, Array
from .hammer import Hammer

#: Longest time from one impact to the next, s.
LONGEST = 10.0


@typed()
@dataclass(frozen=True)
class Record:
    """Samples of a force or a motion, as a sensor gives them.

    Args:
        signal: name of an output: ``contact_force``, ``rock_force``,
            ``piston_velocity``, ``bit_tip_position`` and so on.
        samples: values in SI units; the index is the time in seconds and must increase.
        error: standard error of every sample, or one for each sample.
        blow: number of the impact at which the record's time is 0; the first impact is 1. With
            ``None`` time counts from the start of the simulation. If the record comes from steady
            drilling, choose any blow late enough that the start no longer matters.

    Example:
        >>> from dth_hammer import Record, simulate
        >>> frame = simulate(until="40 ms", step="10 us").frame
        >>> after = frame.loc[0.0137:0.0139, "contact_force"]
        >>> print(len(Record("contact_force", after, error=5e3, blow=None).times), "samples")
        20 samples
    """

    signal: str
    samples: pd.Series
    error: float | Sequence[float]
    blow: int | None = 1

    def __post_init__(self) -> None:
        known = [v.name for v in VARIABLES.of("output")]
        if self.signal not in known:
            raise UnknownNameError("signal", self.signal, known)
        try:
            times, values, errors = self.times, self.values, self.errors
        except (TypeError, ValueError) as error:
            raise DomainError(f"the samples of {self.signal} must be numbers: {error}") from None
        if not len(times) or (np.diff(times) <= 0.0).any() or times[0] < 0.0:
            raise DomainError(f"a record of {self.signal} needs rising times from 0 on")
        if not np.isfinite(values).all():
            raise DomainError(f"a sample of {self.signal} is not a finite number")
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
        """Values of the samples, in SI units."""
        return self.samples.to_numpy(float)

    @property
    def errors(self) -> Array:
        """Standard errors of the samples, in SI units."""
        errors = np.asarray(self.error, dtype=float)
        return np.full(len(self.samples), float(errors)) if errors.ndim == 0 else errors

    def simulated(self, hammer: Hammerlike) -> Array:
        """Returns the samples that a hammer gives at the record's times."""
        return simulated(self, numbers_of(hammer))


def simulated(record: Record, parameters: Mapping[str, float]) -> Array:
    """Returns the samples that a hammer with these parameters gives at the record's times."""
    origin = 0.0 if record.blow is None else _impact(parameters, record.blow)
    with Hammer(parameters, quiet=True) as hammer:
        return hammer.run(origin + record.times, [record.signal], {})[0].ravel()


def _impact(numbers: Mapping[str, float], number: int) -> float:
    """Returns the instant of an impact, s; the first impact has the number 1."""
    with Hammer(numbers, quiet=True) as hammer:
        hammer.stop_at(blows=True)
        for _ in range(number):
            end = hammer.time + LONGEST
            if hammer.advance(end) >= end:
                raise DomainError(
                    f"blow {number} does not occur: the hammer strikes none for {LONGEST:g} s"
                )
        return hammer.time
