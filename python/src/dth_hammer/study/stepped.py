"""Long-run means of a hammer that Python steps: with varying inputs, a controller or a partner."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from ..errors import DomainError, warn
from ..scene.signals import Function
from ..simulation.hammer import Hammer
from .longrun import Steady, Wanted, answered


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
    size: float

    def stepper(self, hammer: Hammer) -> Callable[[], None]:
        """Returns a function that makes a step."""
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
    report: Callable[[int, float], None] = lambda *_: None,
) -> Steady:
    """Returns the long-run response of a hammer that Python steps.

    The engine finds it from its own records of the blows, as for a hammer that it steps itself.
    """
    start = dict(given) | {name: signal(0.0) for name, signal in acts.signals.items()}
    with Hammer(start) as hammer:
        values = hammer.machine.steady(acts.stepper(hammer), wanted.engine_arguments, report)
        found = answered(values, given, hammer.warnings)
    for text in found.warnings[len(hammer.warnings) :]:
        warn(text)
    return found
