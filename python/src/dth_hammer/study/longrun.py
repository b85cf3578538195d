"""Long-run means over blows, with standard errors, whether or not the blows repeat."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .. import _native
from ..errors import DomainError, RefusedError, UnknownNameError
from ..extras import bar
from ..frames import np, pd
from ..scene import quantities
from ..scene.band import beside, factor, in_words
from ..scene.mesh import errors_in_words
from ..scene.variables import VARIABLES, Array, Value, whole
from ..simulation import answers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEANS: tuple[str, ...] = tuple(_native.MEANS)
#: A simulation ends when these means are accurate enough, unless the user names others.
RATES = ("rop", "tip_rate")
KIND = "kind"
#: Units of the means that are not variables of the engine.
UNITS = {
    "blow_frequency": "Hz",
    "period": "s",
    "advance": "m",
    "rebound_speed": "m/s",
    "rebound_ratio": "1",
}
#: Warning of a simulation that ended at its largest number of blows.
NOT_REACHED = (
    "the error asked for is not reached after {} blows: allow more blows, or a larger error"
)
#: Interval between updates of the progress bar, s.
UPDATE_INTERVAL = 0.3
#: Smallest value that the limit of blows may have.
FEWEST = 100
WORKS = tuple(name for name in MEANS if name.startswith("energy_"))


@dataclass(frozen=True, repr=False)
class Steady(answers.Answer):
    """The long-run response of a hammer."""

    #: ``cycle`` if every blow is like the one before, ``cycle of 2`` if every second one is, and so
    #: on; ``irregular`` if blows do not repeat; ``stalled`` if there are no blows.
    kind: str
    #: One row per output, with the columns ``mean``, ``low`` and ``high`` (the range of a rate of
    #: penetration that follows from the rock's specific energy), ``error`` (standard error),
    #: ``spread`` (standard deviation from blow to blow) and ``unit``. A rate of penetration is the
    #: advance of all blows divided by their time; energies are per blow.
    outputs: pd.DataFrame
    #: Number of blows in the means.
    blows: int
    #: Whether the requested error was reached.
    reached: bool
    #: Numbers of all parameters and inputs that were set, by name, in SI units.
    parameters: Mapping[str, float] = field(repr=False)
    #: Warnings about this hammer.
    warnings: tuple[str, ...] = ()
    #: Motions that the hammer settles to, if ``starts`` were requested: one row per motion with its
    #: kind, its share of the starts and its means. The first row is the motion from the hammer's
    #: own start.
    motions: pd.DataFrame | None = field(default=None, repr=False)

    @property
    def mean(self) -> pd.Series:
        """Means by name, in SI units."""
        return self.outputs["mean"]

    @property
    def error(self) -> pd.Series:
        """Standard errors of the means; 0 if the blows repeat."""
        return self.outputs["error"]

    @property
    def spread(self) -> pd.Series:
        """Standard deviations from blow to blow."""
        return self.outputs["spread"]

    @property
    def repeats(self) -> bool:
        """Whether the blows repeat."""
        return self.kind.startswith("cycle")

    def __getitem__(self, name: str) -> float:
        """Returns a mean, or the number of a parameter that was set."""
        if name in self.parameters and name not in self.outputs.index:
            return self.parameters[name]
        return float(self.mean[named(name)])

    @property
    def rate(self) -> str:
        """The rate of penetration and its range, as text."""
        return in_words(self["rop"], self.parameters)

    def specific_energy(self, rate: Value) -> float:
        """Returns the rock's specific energy from one measured rate of penetration, J/m3.

        ``E_v = 4 P / (pi D^2 rate)`` with the mean power ``P`` that the hammer gives the rock, and
        the hole's diameter ``D`` (``hole.diameter``).

        Args:
            rate: measured rate of penetration, m/s or text with a unit (``"30 m/h"``).

        Raises:
            DomainError: the rate is not above 0.
            RefusedError: the hammer comes to rest.
        """
        number = quantities.read(rate, "m/s", "rate")
        diameter = whole(self.parameters)["hole.diameter"]
        if not (np.isfinite(number) and number > 0.0):
            raise DomainError(f"rate = {number:g} m/s is not finite and above 0")
        if self.kind == "stalled":
            raise RefusedError("the hammer comes to rest: no specific energy follows from a rate")
        work = self.mean["energy_rock_dissipated"] + self.mean["energy_viscous"]
        return float(work / self.mean["period"] / (0.25 * np.pi * diameter**2 * number))

    def measured(self, rate: Value, scatter: float = 0.1) -> dict[str, float]:
        """Returns the rock's specific energy and its uncertainty from one measured rate.

        Args:
            rate: measured rate of penetration, as for `specific_energy`.
            scatter: relative uncertainty of the measured rate, 0 to 1.
        """
        if not 0.0 <= scatter <= 1.0:
            raise DomainError(f"scatter = {scatter:g} is not a share of the rate, 0 to 1")
        return {
            "rock.specific_energy": self.specific_energy(rate),
            "rock.specific_energy_factor": 1.0 + scatter,
        }

    caption = "Energy of a blow"

    def in_words(self) -> list[str]:
        """Returns kind of motion and number of blows, the rate, and the error of the mesh."""
        text = f"{self.kind}, {self.blows} blows" + ("" if self.reached else ", error not reached")
        return [text, self.rate, *errors_in_words(self.parameters)] if self.rate else [text]

    def to_frame(self) -> pd.DataFrame:
        """Returns means, ranges, errors and spreads, one row per output."""
        return self.outputs

    def plot(self) -> Figure:
        """Plots the energies of a blow: work done on the hammer, and losses."""
        return answers.energies(dict(self.mean[[*WORKS]]))


def named(name: str) -> str:
    """Returns the name; raises an `UnknownNameError` if no mean has it."""
    if name not in MEANS:
        raise UnknownNameError("mean", name, MEANS)
    return name


def unit(name: str) -> str:
    """Returns the unit of a mean."""
    return UNITS.get(name) or VARIABLES[name].unit


#: The engine's default settings of a long-run simulation.
DEFAULTS = _native.wanted()


@dataclass(frozen=True)
class Wanted:
    """When a long-run simulation ends."""

    #: Largest relative standard error: one number for both rates, or numbers by name of a mean.
    error: float | Mapping[str, float] = DEFAULTS["error"]
    #: Largest number of blows to simulate.
    blows: int = int(DEFAULTS["blows"])
    #: If a hammer makes no blow for this time (s), it has stalled.
    limit: float = DEFAULTS["limit"]
    #: Whether a motion that repeats is also tried from a second start. If it does not repeat from
    #: there, a warning says so.
    second: bool = False

    def __post_init__(self) -> None:
        bounds = [("blows", self.blows, FEWEST, 1e7), ("limit", self.limit, 1e-3, 1e4)]
        bounds += [(f"error of {name}", error, 1e-6, 1.0) for name, error in self.by_mean.items()]
        for name, value, low, high in bounds:
            if not low <= quantities.read(value, "1", name) <= high:
                raise DomainError(f"{name} = {value} must be {low:g} to {high:g}")

    @property
    def by_mean(self) -> dict[str, float]:
        """Largest relative standard errors by name of a mean."""
        if isinstance(self.error, Mapping):
            return {named(name): error for name, error in self.error.items()}
        return dict.fromkeys(RATES, self.error)

    @property
    def errors(self) -> list[float]:
        """Largest relative standard error of each mean; infinity where none is requested."""
        return [self.by_mean.get(name, np.inf) for name in MEANS]

    @property
    def engine_arguments(self) -> tuple[list[float], int, float, int, bool]:
        """Returns these settings as the engine takes them.

        The fourth is the longest cycle that the engine looks for, in blows.
        """
        return self.errors, self.blows, self.limit, int(DEFAULTS["repeating"]), self.second


def responses(
    points: Sequence[Mapping[str, float]], wanted: Wanted, **options: Any
) -> list[Steady | str]:
    """Returns the long-run responses of many hammers in their order; text is a refusal's reason."""
    response_by_index = dict(finished(points, wanted, **options))
    return [response_by_index[k] for k in range(len(points))]


def finished(
    points: Sequence[Mapping[str, float]],
    wanted: Wanted,
    *,
    progress: bool = False,
    stopped: Callable[[], bool] = lambda: False,
) -> Iterator[tuple[int, Steady | str]]:
    """Yields index and long-run response of many hammers, in the order in which they finish.

    The response of a refused hammer is the reason, as text. Ctrl-C ends all runs. ``stopped`` does
    the same if it returns True; other threads need it, since only the main thread gets signals.
    """
    scenes = [[*point.items()] for point in points]
    if not scenes:
        return
    batch = _native.Batch.steady(scenes, wanted.engine_arguments, cores())
    done = 0
    with progress_reporter(progress, len(scenes)) as report:
        try:
            while done < len(scenes):
                for index, values, refused, warnings in batch.take(1, UPDATE_INTERVAL) or ():
                    done += 1
                    yield index, refused or answered(values, points[index], warnings)
                if stopped():
                    raise KeyboardInterrupt
                report(*batch.progress(), done)
        finally:
            batch.stop()


def cores() -> int:
    """Returns the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def answered(
    values: Sequence[float], point: Mapping[str, float], warnings: Sequence[str]
) -> Steady:
    """Returns the response that the engine's numbers describe."""
    repeating, blows, reached, *numbers = values
    kinds = {-1: "stalled", 0: "irregular", 1: "cycle"}
    kind = kinds.get(int(repeating), f"cycle of {repeating:g}")
    statistics = np.array(numbers).reshape(3, len(MEANS))
    if kind == "stalled":
        statistics[:] = np.nan
    not_reached = () if reached > 0.5 else (NOT_REACHED.format(int(blows)),)
    reasons = (*warnings, *not_reached)
    return Steady(
        kind, tabled(statistics, point), int(blows), not not_reached, dict(point), reasons
    )


def tabled(statistics: Array, given: Mapping[str, float]) -> pd.DataFrame:
    """Returns the table `Steady.outputs` of means, errors and spreads."""
    columns = dict(zip(("mean", "error", "spread"), statistics, strict=True))
    frame = pd.DataFrame(columns, index=pd.Index(MEANS, name="output"))
    frame = beside(frame, "mean", factor(given))
    frame["unit"] = [unit(name) for name in MEANS]
    return frame


@contextmanager
def progress_reporter(show: bool, total: int = 1) -> Iterator[Callable[..., None]]:
    """Opens a progress bar, if one is shown, and yields the function that updates it.

    Its arguments are the number of blows so far, the ratio of the error to the requested error, and
    the number of finished hammers.
    """
    options = {"total": total, "unit": "hammer"}
    progress_bar = bar(show, **(options if total > 1 else {"unit": "blow"}))
    with nullcontext() if progress_bar is None else progress_bar:

        def report(blows: int, error_ratio: float, done: int = 0) -> None:
            if progress_bar is not None:
                progress_bar.n = done if total > 1 else blows
                known = np.isfinite(error_ratio)
                text = f"{error_ratio:.2g} times the one wanted" if known else "not yet known"
                progress_bar.set_postfix_str(f"error {text}")

        yield report
