"""Long-run means of a hammer that Python steps: inputs over time, a controller, a model coupled."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .. import _native
from ..errors import DomainError, warn
from ..run.hammer import Hammer
from ..scene.signals import Function
from ..scene.variables import Array
from .longrun import FEWEST, MEANS, NOT_REACHED, WORKS, Steady, Wanted, tabled

#: Blows that are compared; how near they are if they repeat.
OBSERVED, SAME = 12, 1e-6
#: What is read of the hammer, in the order of a blow's numbers.
BLOW = ("blow_period", "blow_penetration", "blow_speed", "blow_energy")
PEAKS = ("contact_force_peak", "rock_force_peak")


class Stepped(Protocol):
    """Something that steps a hammer, as a `Coupling` does."""

    def advance(self, to: float) -> object:
        """Steps up to an instant, s."""


@dataclass(frozen=True)
class Acts:
    """Inputs over time, controller and partner of a hammer."""

    signals: Mapping[str, Function]
    control: Callable[[Hammer], None] | None
    partner: Callable[[Hammer], Stepped] | None
    #: Communication step, s.
    size: float

    def stepper(self, hammer: Hammer) -> Callable[[], None]:
        """Makes a step."""
        coupled = self.partner(hammer) if self.partner else hammer
        if not hasattr(coupled, "advance"):
            raise DomainError(
                f"partner returned a {type(coupled).__name__}, which does not step a hammer"
            )

        def step() -> None:
            to = hammer.time + self.size
            hammer.move(self.signals, to)
            if self.control:
                self.control(hammer)
            coupled.advance(to)

        return step


def moved(
    given: Mapping[str, float],
    wanted: Wanted,
    acts: Acts,
    tell: Callable[[int, float], None] = lambda *_: None,
) -> Steady:
    """Returns the long-run response of a hammer that Python steps."""
    for name in wanted.by_mean:
        if name.startswith("rebound"):
            raise DomainError(
                f"{name} has no error with inputs over time, control or a partner: leave it out"
            )
    start = dict(given) | {name: signal(0.0) for name, signal in acts.signals.items()}
    with Hammer(start) as hammer:

        def ended(kind: str, parts: Array, blows: int, *short: str) -> Steady:
            reasons = (*hammer.warnings, *short)
            return Steady(kind, tabled(parts, given), blows, not short, dict(given), reasons)

        step = acts.stepper(hammer)
        blows: list[list[float]] = []
        due = FEWEST
        for blow in _blows(hammer, step, wanted.limit):
            blows.append(blow)
            count = len(blows)
            if count < due:
                continue
            due += due // 2
            table = np.array(blows)
            if order := repeats(table[-OBSERVED:, 0]):
                *parts, _ = _native.means(table[-order:], exact=True)
                kind = "cycle" if order == 1 else f"cycle of {order}"
                return ended(kind, np.array(parts), order)
            *known, kept = _native.means(table)
            found = np.array(known)
            asked = np.isfinite(wanted.errors)
            over = found[1][asked] / np.abs(found[0][asked]) / np.array(wanted.errors)[asked]
            error_ratio = float(over.max())
            tell(count, error_ratio)
            if error_ratio <= 1.0 or count >= wanted.blows:
                short = [] if error_ratio <= 1.0 else [NOT_REACHED.format(count)]
                for text in short:
                    warn(text)
                return ended("irregular", found, kept, *short)
        return ended("stalled", np.full((3, len(MEANS)), np.nan), 0)


def _blows(hammer: Hammer, step: Callable[[], None], limit: float) -> Iterator[list[float]]:
    """Numbers of blow after blow, as `_native.means` wants them; ends where none come.

    How the piston rebounds is not read. Works are differences between communication points; the
    length drilled is that of the blow.
    """
    read = hammer.reader(["blow_count", "stalled", "rop", "air_flow", *BLOW, *PEAKS, *WORKS])
    count, last, peaks, before = 0.0, hammer.time, np.zeros(2), np.zeros(len(WORKS))
    while hammer.time - last <= limit:
        step()
        now, stalled, rop, air, *numbers = read()
        own, works = numbers[: len(BLOW)], np.array(numbers[len(BLOW) + 2 :])
        peaks = np.maximum(peaks, numbers[len(BLOW) : len(BLOW) + 2])
        if now > count + 1:
            raise DomainError(
                f"{now - count:g} blows in one step at {hammer.time:g} s: give a smaller step"
            )
        if now > count:
            if own[0] > 0.0:
                yield [*own, np.nan, *peaks, *(works - before), rop * own[0], air * own[0]]
            count, last, peaks, before = now, hammer.time, np.zeros(2), works
        elif stalled:
            return


def repeats(periods: Array) -> int:
    """The number of blows after which the last periods repeat; 0 if they do not."""
    ways = range(1, len(periods) // 2 + 1)
    same = (k for k in ways if np.allclose(periods[k:], periods[:-k], rtol=SAME, atol=0.0))
    return next(same, 0)
