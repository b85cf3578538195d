"""Co-simulation of the hammer with a model of its drive.

The partner computes pressures from the piston's motion. A `Coupling` steps both:

* ``gauss-seidel``: the hammer steps first; the partner then follows the known motion, a cubic;
* ``jacobi``: both use only values from the start of the step (they could run in parallel); the
  partner extrapolates the piston's motion with the acceleration of the previous step;
* ``tolerance``: if a pressure after a step differs by more than this from the one that the hammer
  used, both states are restored and a smaller step is made.

Pressures are constant over a step. They belong to the start of the step, and `coupling.delay` (0.5
steps before the middle of the step) tells the hammer so: it extrapolates them, and both schemes are
of second order in the step. `energy_exchange` is the remaining error, and the hammer warns of it. A
partner that holds a flow over its step needs a delay of 0 in the first scheme and 1 in the second.

A partner that switches at positions of the piston sets them with `Hammer.stop_at`. A step then ends
there, the partner follows to that instant, and its new values act from then on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

from ..contract import typed
from ..errors import DomainError
from ..frames import np, pd
from ..scene import quantities
from ..scene.variables import VARIABLES, whole
from . import answers
from .hammer import Hammer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Scheme = Literal["jacobi", "gauss-seidel"]
POSITION, VELOCITY = "relative_position", "relative_velocity"
DELAY, SOURCE = "coupling.delay", "drive.source"
#: Largest number of steps in a history; older steps are dropped.
HISTORY_LIMIT = 1_000_000


@dataclass(frozen=True)
class Motion:
    """The piston over one step: position (m) and velocity (m/s) from its start.

    Example:
        >>> from dth_hammer import Motion
        >>> position, velocity = Motion.onward(-0.02, 5.0)(1e-3)
        >>> print(round(position, 4), velocity)
        -0.015 5.0
    """

    coefficients: tuple[float, float, float, float]
    rate: tuple[float, float, float]
    #: End of the step, with exact position and velocity: a partner that switches there needs them.
    end: tuple[float, float, float] | None = None

    def __call__(self, time: float) -> tuple[float, float]:
        """Returns position and velocity at a time after the start of the step."""
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
    def onward(cls, position: float, velocity: float, acceleration: float = 0.0) -> Motion:
        """Returns a motion of constant acceleration."""
        return cls((position, velocity, 0.5 * acceleration, 0.0), (velocity, acceleration, 0.0))

    @classmethod
    def between(cls, start: tuple[float, float], end: tuple[float, float], size: float) -> Motion:
        """Returns the cubic through both positions with both velocities."""
        (x, v), (y, w) = start, end
        mean = (y - x) / size
        c, d = (3.0 * mean - 2.0 * v - w) / size, (v + w - 2.0 * mean) / (size * size)
        return cls((x, v, c, d), (v, 2.0 * c, 3.0 * d), (size, *end))


class Partner(Protocol):
    """A model that drives the hammer.

    If its state depends on the piston's position (a chamber with gas in it), it also has
    ``start(position)``, which sets the state for this position, m. `Coupling` calls it.
    """

    def outputs(self) -> Mapping[str, float]:
        """Returns values of the hammer's inputs, by name."""

    def advance(self, size: float, motion: Motion, /) -> None:
        """Integrates over one step; ``motion`` gives the piston's position and velocity in it."""


class Restorable(Partner, Protocol):
    """A partner whose steps can be taken back, for `Coupling` with a tolerance."""

    def save(self) -> Any:
        """Returns the state."""

    def restore(self, state: Any, /) -> None:
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
        delay: float | None = None,
        tolerance: float | None = None,
        smallest: float | str = 1e-7,
    ) -> None:
        wanted = ["advance", "outputs", *(["save", "restore"] if tolerance is not None else ())]
        if lacks := [name for name in wanted if not callable(getattr(partner, name, None))]:
            raise DomainError(
                f"a {type(partner).__name__} lacks {', '.join(lacks)}, which a Partner has"
            )
        self.hammer, self.partner = hammer, partner
        self.largest = quantities.duration(step, "step")
        self.smallest = quantities.duration(smallest, "smallest")
        self.tolerance = tolerance
        self.scheme = scheme
        self.delay = 0.5 if delay is None else delay
        self.accepted = self.rejected = 0
        self._step = self.largest
        self._motion = hammer.reader([POSITION, VELOCITY])
        self._exchanged: deque[tuple[float, ...]] = deque(maxlen=HISTORY_LIMIT)
        self._end = hammer.time
        self._names: tuple[str, ...] = ()
        if VARIABLES[SOURCE].labels[int(whole(hammer.numbers)[SOURCE])] in ("Force", "Pressure"):
            hammer.set({DELAY: self.delay})
        start = getattr(partner, "start", None)
        if hammer.time == 0.0 and callable(start):
            start(self._now()[0])

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

    def _exchange(self, size: float) -> dict[str, float]:
        """Makes one step of both. Returns the inputs that the hammer was given."""
        hammer, partner = self.hammer, self.partner
        start = self._now()
        given = dict(partner.outputs())
        self._give(given)
        begun = hammer.time
        # The step may end early, at a stop that the partner asked for.
        self._end = hammer.step(size)
        size = self._end - begun
        end = self._now()
        if self.scheme == "jacobi":
            motion = self._onward(start, size)
        elif size > 0.0:
            motion = Motion.between(start, end, size)
        else:
            motion = Motion.held(*end)
        partner.advance(size, motion)
        self.accepted += 1
        return given

    def _onward(self, start: tuple[float, float], size: float) -> Motion:
        """Extrapolates the motion of the piston, with the acceleration of the previous step.

        Without the acceleration, a partner that integrates the flow would be half a step late. A
        previous step that was much shorter is not used: it may contain an impact.
        """
        x, v = start
        time, _, before, *_ = self._exchanged[-2 if len(self._exchanged) > 1 else -1]
        past = self._exchanged[-1][0] - time
        return Motion.onward(x, v, (v - before) / past if past >= 0.5 * size > 0.0 else 0.0)

    def _give(self, given: Mapping[str, float]) -> None:
        """Sets the hammer's inputs and records them."""
        self.hammer.set(given)
        self._names = self._names or tuple(given)
        inputs = (given.get(name, np.nan) for name in self._names)
        self._exchanged.append((self.hammer.time, *self._now(), *inputs))

    @property
    def history(self) -> pd.DataFrame:
        """Returns the piston's motion and the inputs at the start of each step, by time.

        Steps that were undone are not included. Only the latest million steps are stored.
        """
        columns = [POSITION, VELOCITY, *self._names]
        units = {name: VARIABLES[name].unit for name in columns}
        rows = np.array(self._exchanged).reshape(-1, 1 + len(columns))
        table = pd.DataFrame(rows[:, 1:], pd.Index(rows[:, 0], name="time"), pd.Index(columns))
        table.attrs = {"units": quantities.Fixed(units)}
        return table

    def plot(self, last: float | str | None = None) -> Figure:
        """Draws the history: the hammer's inputs, and the piston's height above the bit.

        Args:
            last: duration to draw, up to the present, s or text with a unit; by default everything.
        """
        table = self.history
        if last is not None:
            table = table[table.index >= self._end - quantities.duration(last, "last")]
        return answers.exchanged(table, self._end)

    def _now(self) -> tuple[float, float]:
        position, velocity = self._motion()
        return position, velocity

    def _attempt(self, size: float, tolerance: float) -> None:
        hammer, partner = self.hammer, cast(Restorable, self.partner)
        before, state = hammer.save(), partner.save()
        while True:
            error = self._error(self._exchange(size)) / tolerance
            factor = 0.9 * max(error, 1e-6) ** -0.5
            if error <= 1.0 or size <= self.smallest:
                break
            hammer.restore(before)
            partner.restore(state)
            self._exchanged.pop()
            self.accepted -= 1
            self.rejected += 1
            size = max(self.smallest, size * max(0.2, factor))
        # A last step that was cut short does not determine the size of the next.
        grown = size * min(2.0, max(0.2, factor))
        self._step = min(self.largest, max(self.smallest, grown))

    def _error(self, given: Mapping[str, float]) -> float:
        """Returns the error of the pressures in the middle of the step, from those at its end."""
        begun, after = self._exchanged[-1][0], self.partner.outputs()
        time, _, _, *inputs = self._exchanged[-2 if len(self._exchanged) > 1 else -1]
        before, size = dict(zip(self._names, inputs, strict=True)), self._end - begun

        def off(name: str) -> float:
            rise = after[name] - given[name]
            if begun <= time:
                return 0.5 * rise
            slope = (given[name] - before.get(name, given[name])) / (begun - time)
            return 0.5 * (rise - slope * size)

        return max(abs(off(name)) for name in given)
