"""Co-simulation of the hammer with a model of its drive.

The partner gives pressures and needs the piston's motion. A `Coupling` steps both:

* ``jacobi``: both step with the values at the start of the step (they could run in parallel);
* ``gauss-seidel``: the hammer steps first, the partner then follows its known motion;
* ``slopes``: time derivatives of the pressures are asked for too, and the motion is a polynomial
  instead of a constant. The hammer takes them as straight lines, or as the constants of the same
  mean, ``p + p' H / 2`` over a step ``H`` (``"midpoint"``). Both are of second order in the step.
  Constants cost the hammer less; if nothing is said it gets them wherever the partner is soft: its
  stiffness ``k`` and the piston's mass ``m`` keep ``H sqrt(k / m)`` below `SOFT`;
* ``tolerance``: if, after a step, the pressures differ by more than this from those that the
  hammer used, both states are restored and a smaller step is made.

A partner that switches at positions of the piston asks for them by `Hammer.stop_at`: a step
then ends there, the partner follows to that instant, and its new values hold from there on.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
import pandas as pd

from . import _native, answers, quantities
from .contract import typed
from .errors import DomainError, warn
from .fixed import Fixed
from .hammer import Hammer
from .variables import VARIABLES, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Scheme = Literal["jacobi", "gauss-seidel"]
Slopes = bool | Literal["midpoint"]
POSITION, VELOCITY = "relative_position", "relative_velocity"
#: Angle, in the oscillation of the piston on the partner as a spring, up to which a step may hold a
#: pressure at its mean. Its course in the step, ``p' (t - H / 2)``, then moves the piston by a part
#: of ``SOFT**2 / 12``, 0.08 %, of its way: no more than what straight lines leave out.
SOFT = 0.1
#: Most exchanges that a history keeps, the latest.
KEPT = 1_000_000


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
    """A model that drives the hammer.

    What fills with the piston's position (a chamber with gas in it) has ``start(position)`` too,
    which makes its state for a piston that stands there, m; `Coupling` calls it.
    """

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
        slopes: Slopes | None = None,
        tolerance: float | None = None,
        smallest: float | str = 1e-7,
    ) -> None:
        asked = slopes is not False
        wanted = ["advance", "outputs", *(["slopes"] if asked else ())]
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
        self.scheme, self.with_slopes, self.slopes = scheme, asked, slopes
        self.accepted = self.rejected = 0
        self._step = self.largest
        self._motion = hammer.reader([POSITION, VELOCITY])
        self._forces = _forces(hammer.numbers)
        self._sloped: tuple[str, ...] = ()
        self._exchanged, self._end = array("d"), hammer.time
        self._names: tuple[str, ...] = ()
        if hammer.time == 0.0:
            self._start()

    def _start(self) -> None:
        """Starts the partner where the piston stands, if it can."""
        position, velocity = self._now()
        start = getattr(self.partner, "start", None)
        if callable(start):
            start(position)
        elif self.with_slopes and self._stiffness(position, velocity):
            warn(
                f"a {type(self.partner).__name__} has no start(position), though its pressures "
                f"follow the piston: its state is taken as it is, for a piston at {position:g} m"
            )

    def _stiffness(
        self, position: float, velocity: float, slopes: Mapping[str, float] | None = None
    ) -> float:
        """Stiffness of the partner against the piston over its mass, 1/s2."""
        if slopes is None:
            slopes = self.partner.slopes(position, velocity)
        faster = self.partner.slopes(position, velocity + 1.0)
        return abs(sum((faster[n] - slopes[n]) * self._forces.get(n, 0.0) for n in slopes))

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
        soft = self.slopes == "midpoint" or (
            self.slopes is None and self._stiffness(position, velocity, slopes) * size**2 <= SOFT**2
        )
        self._give(given, slopes, 0.5 * size if soft else 0.0)
        begun = hammer.time
        # It may end before its time, where it was asked to stop.
        self._end = hammer.step(size)
        size = self._end - begun
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

    def _give(self, given: Mapping[str, float], slopes: Mapping[str, float], middle: float) -> None:
        """Sets the hammer's inputs: their values at the middle of the step, or straight lines."""
        values = {name: x + middle * slopes.get(name, 0.0) for name, x in given.items()}
        lines = {} if middle else slopes
        self.hammer.set(values)
        if lines or self._sloped:
            self.hammer.set_slopes({**dict.fromkeys(self._sloped, 0.0), **lines})
        self._sloped = tuple(lines)
        self._names = self._names or tuple(values)
        if len(self._exchanged) >= 2 * KEPT * self._width:
            del self._exchanged[: KEPT * self._width]
        row = [self.hammer.time, *self._now()]
        for name in self._names:
            row += [values.get(name, np.nan), lines.get(name, 0.0)]
        self._exchanged.extend(row)

    @property
    def _width(self) -> int:
        """Numbers of an exchange."""
        return 3 + 2 * len(self._names)

    @property
    def history(self) -> pd.DataFrame:
        """What was exchanged at the start of each step, by time: the piston's motion and inputs.

        A column ``... slope`` has the time derivative that the hammer was given with an input.
        Steps that were taken back are not in it, nor more than the latest million.
        """
        columns = [POSITION, VELOCITY]
        units = {name: VARIABLES[name].unit for name in (*columns, *self._names)}
        for name in self._names:
            columns += [name, f"{name} slope"]
            units[f"{name} slope"] = f"{units[name]}/s"
        rows = np.array(self._exchanged).reshape(-1, self._width)
        index = pd.Index(rows[:, 0], name="time")
        table = pd.DataFrame(rows[:, 1:], index, pd.Index(columns)).iloc[-KEPT:]
        table.attrs = {"units": Fixed(units)}
        return table

    def plot(self, last: float | str | None = None) -> Figure:
        """Draws the history: inputs as the hammer had them, and the piston over the bit.

        Args:
            last: how long before now, s or text with a unit; all of it if not given.
        """
        table = self.history
        if last is not None:
            table = table[table.index >= self._end - quantities.duration(last, "last")]
        return answers.exchanged(table, self._end)

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
            del self._exchanged[-self._width :]
            self.accepted -= 1
            self.rejected += 1
            size = max(self.smallest, size * max(0.2, factor))
        # A last step that was cut short says nothing about the length of the next.
        grown = size * min(2.0, max(0.2, factor))
        self._step = min(self.largest, max(self.smallest, grown))


def _forces(numbers: Mapping[str, float]) -> dict[str, float]:
    """Acceleration of the piston by each input of a drive."""
    known = whole(numbers)
    volume = sum(length * area for length, area in _native.sections(numbers, "piston"))
    mass = volume * known["material.density"]
    return {
        "drive_force": 1.0 / mass,
        "drive_pressure": known["drive.area_drive"] / mass,
        "return_pressure": -known["drive.area_return"] / mass,
    }
