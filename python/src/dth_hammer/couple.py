"""Co-simulation of the hammer with a model of its drive.

The partner gives pressures and needs the piston's motion. A `Coupling` steps both:

* ``jacobi``: both step with the values at the start of the step (they could run in parallel);
* ``gauss-seidel``: the hammer steps first, the partner then follows its known motion;
* ``slopes``: time derivatives of the pressures are exchanged too, and the motion is a
  polynomial instead of a constant;
* ``tolerance``: if, after a step, the pressures differ by more than this from those that the
  hammer used, both states are restored and a smaller step is made.

A partner that switches at positions of the piston asks for them by `Hammer.stop_at`: a step
then ends there, the partner follows to that instant, and its new values hold from there on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from . import quantities
from .contract import typed
from .errors import DomainError
from .hammer import Hammer

Scheme = Literal["jacobi", "gauss-seidel"]
POSITION, VELOCITY = "relative_position", "relative_velocity"


@dataclass(frozen=True)
class Motion:
    """The piston over one step: position (m) and velocity (m/s) from its start.

    Example:
        >>> from dth_hammer import Motion
        >>> position, velocity = Motion.straight(-0.02, 5.0)(1e-3)
        >>> print(round(position, 4), velocity)
        -0.015 5.0
    """

    coefficients: tuple[float, float, float, float]
    rate: tuple[float, float, float]
    #: The end of the step, and both there to the bit: what switches there decides by them.
    end: tuple[float, float, float] | None = None

    def __call__(self, time: float) -> tuple[float, float]:
        """Position and velocity at a time after the start of the step."""
        if self.end is not None and time == self.end[0]:
            return self.end[1:]
        a, b, c, d = self.coefficients
        e, f, g = self.rate
        return a + time * (b + time * (c + time * d)), e + time * (f + time * g)

    @classmethod
    def held(cls, position: float, velocity: float) -> Motion:
        """Returns constant position and velocity, as in a host without derivatives."""
        return cls((position, 0.0, 0.0, 0.0), (velocity, 0.0, 0.0))

    @classmethod
    def straight(cls, position: float, velocity: float) -> Motion:
        """Returns a motion of constant velocity."""
        return cls((position, velocity, 0.0, 0.0), (velocity, 0.0, 0.0))

    @classmethod
    def between(cls, start: tuple[float, float], end: tuple[float, float], size: float) -> Motion:
        """Returns the cubic through both positions with both velocities."""
        (x, v), (y, w) = start, end
        mean = (y - x) / size
        c, d = (3.0 * mean - 2.0 * v - w) / size, (v + w - 2.0 * mean) / (size * size)
        return cls((x, v, c, d), (v, 2.0 * c, 3.0 * d), (size, *end))


class Partner(Protocol):
    """A model that drives the hammer."""

    def outputs(self) -> dict[str, float]:
        """Returns values of the hammer's inputs, by name."""

    def slopes(self, position: float, velocity: float) -> dict[str, float]:
        """Returns their time derivatives, for a piston with this position and velocity."""

    def advance(self, size: float, motion: Callable[[float], tuple[float, float]]) -> None:
        """Integrates over one step; ``motion`` gives the piston's position and velocity in it."""

    def save(self) -> Any:
        """Returns the state."""

    def restore(self, state: Any) -> None:
        """Restores a saved state."""


@typed()
class Coupling:
    """Steps a hammer and a model of its drive together.

    Example:
        >>> from dth_hammer import Coupling, Hammer
        >>> from dth_hammer.models.hydraulic import WaterDrive
        >>> drive = WaterDrive()
        >>> with Hammer(drive.water.parameters()) as hammer:
        ...     Coupling(hammer, drive, step="50 us").advance("100 ms")
        ...     print(hammer["blow_count"], "blows")
        4 blows
    """

    def __init__(
        self,
        hammer: Hammer,
        partner: Partner,
        step: float | str,
        *,
        scheme: Scheme = "gauss-seidel",
        slopes: bool = True,
        tolerance: float | None = None,
        smallest: float | str = 1e-7,
    ) -> None:
        wanted = ["advance", "outputs", *(["slopes"] if slopes else ())]
        wanted += ["save", "restore"] if tolerance is not None else []
        if lacks := [name for name in wanted if not callable(getattr(partner, name, None))]:
            without = "; without slopes: slopes=False" if lacks == ["slopes"] else ""
            raise DomainError(
                f"a {type(partner).__name__} lacks {', '.join(lacks)}, which a Partner has{without}"
            )
        self.hammer, self.partner = hammer, partner
        self.largest = quantities.duration(step, "step")
        self.smallest = quantities.duration(smallest, "smallest")
        self.tolerance = tolerance
        self.scheme, self.with_slopes = scheme, slopes
        self.accepted = self.rejected = 0
        self._step = self.largest
        self._motion = hammer.reader([POSITION, VELOCITY])

    def advance(self, to: float | str) -> None:
        """Advances both to a time, in seconds or as text with a unit."""
        hammer, to = self.hammer, quantities.seconds(to, "to")
        while (left := to - hammer.time) > 1e-9 * self.largest:
            # Two equal last steps instead of a full one and a very short one.
            size = left if left <= self._step * (1 + 1e-9) else min(self._step, left)
            if self.tolerance is None:
                self._exchange(size)
            else:
                self._attempt(size, self.tolerance)

    def _exchange(self, size: float) -> float:
        """Makes one step of both and returns the error of the hammer's inputs at its end."""
        hammer, partner = self.hammer, self.partner
        position, velocity = start = self._now()
        given = partner.outputs()
        slopes = partner.slopes(position, velocity) if self.with_slopes else {}
        hammer.set(given)
        if slopes:
            hammer.set_slopes(slopes)
        begun = hammer.time
        # It may end before its time, where it was asked to stop.
        size = hammer.step(size) - begun
        end = self._now()
        if self.scheme == "jacobi":
            motion = (Motion.straight if self.with_slopes else Motion.held)(*start)
        elif self.with_slopes and size > 0.0:
            motion = Motion.between(start, end, size)
        else:
            motion = Motion.held(*end)
        partner.advance(size, motion)
        self.accepted += 1
        after = partner.outputs()
        return max(abs(after[n] - given[n] - slopes.get(n, 0.0) * size) for n in given)

    def _now(self) -> tuple[float, float]:
        position, velocity = self._motion()
        return position, velocity

    def _attempt(self, size: float, tolerance: float) -> None:
        hammer, partner = self.hammer, self.partner
        before, state = hammer.save(), partner.save()
        order = 2 if self.with_slopes else 1
        while True:
            error = self._exchange(size) / tolerance
            factor = 0.9 * max(error, 1e-6) ** (-1.0 / order)
            if error <= 1.0 or size <= self.smallest:
                break
            hammer.restore(before)
            partner.restore(state)
            self.accepted -= 1
            self.rejected += 1
            size = max(self.smallest, size * max(0.2, factor))
        # A last step that was cut short says nothing about the length of the next.
        grown = size * min(2.0, max(0.2, factor))
        self._step = min(self.largest, max(self.smallest, grown))
