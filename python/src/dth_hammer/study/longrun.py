"""Long-run means over blows, with errors, of hammers that repeat or not."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from .. import _native
from ..errors import DomainError, RefusedError, UnknownNameError
from ..extras import bar
from ..run import answers
from ..scene import quantities
from ..scene.band import beside, factor, in_words
from ..scene.variables import VARIABLES, Array, Value, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Names of the means, in their order.
MEANS: tuple[str, ...] = tuple(_native.MEANS)
#: Means whose errors end a simulation, unless others are named.
RATES = ("rop", "tip_rate")
#: What a table calls the kind of a response.
KIND = "kind"
#: Units of those that are no variables.
UNITS = {
    "blow_frequency": "Hz",
    "period": "s",
    "advance": "m",
    "rebound_speed": "m/s",
    "rebound_ratio": "1",
}
#: A warning where blows have run out.
NOT_REACHED = (
    "the error asked for is not reached after {} blows: allow more blows, or a larger error"
)
#: Interval between updates of the progress bar, s.
PART = 0.3
#: Fewest blows of a mean.
FEWEST = 100
#: Energies of a blow.
WORKS = tuple(name for name in MEANS if name.startswith("energy_"))


@dataclass(frozen=True, repr=False)
class Steady(answers.Answer):
    """A long-run response."""

    #: ``cycle``, ``cycle of 2`` and so on, ``irregular``, ``stalled``.
    kind: str
    #: Mean, the range that the rock's specific energy leaves of a rate of penetration (``low``,
    #: ``high``), standard error and spread from blow to blow of each output, and its unit. A rate
    #: of penetration is the advance over the time of all blows; energies are those of a blow.
    outputs: pd.DataFrame
    #: Blows that the means are of.
    blows: int
    #: Whether the error asked for was reached.
    reached: bool
    #: Numbers of all that was set, by name, in SI units.
    parameters: Mapping[str, float] = field(repr=False)
    #: What was warned of.
    warnings: tuple[str, ...] = ()
    #: With ``starts``: a row for each motion that was met, with its kind, its share of the starts
    #: and its means; that of the scene's own start is the first.
    motions: pd.DataFrame | None = field(default=None, repr=False)

    @property
    def mean(self) -> pd.Series:
        """Means by name, SI units."""
        return self.outputs["mean"]

    @property
    def error(self) -> pd.Series:
        """Standard errors of the means; 0 of blows that repeat."""
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
        """Returns a mean, or the value of a parameter that was set."""
        if name in self.parameters and name not in self.outputs.index:
            return self.parameters[name]
        return float(self.mean[named(name)])

    @property
    def rate(self) -> str:
        """The rate of penetration with the range that the rock's specific energy leaves of it."""
        return in_words(self["rop"], self.parameters)

    def specific_energy(self, rate: Value) -> float:
        """Returns the rock's specific energy from one measured rate of penetration, J/m3.

        ``E_v = 4 P / (pi D^2 rate)`` with the mean power ``P`` that the hammer gives the rock, and
        the hole's diameter ``D`` (``hole.diameter``).

        Args:
            rate: of penetration, m/s or text with a unit (``"30 m/h"``).

        Raises:
            DomainError: no rate above 0.
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
            rate: of penetration, as for `specific_energy`.
            scatter: of the measured rate, a share of it.
        """
        if not 0.0 <= scatter <= 1.0:
            raise DomainError(f"scatter = {scatter:g} is not a share of the rate, 0 to 1")
        return {
            "rock.specific_energy": self.specific_energy(rate),
            "rock.specific_energy_factor": 1.0 + scatter,
        }

    caption = "Energy of a blow"

    def in_words(self) -> list[str]:
        """The kind of motion, and the rate."""
        text = f"{self.kind}, {self.blows} blows" + ("" if self.reached else ", error not reached")
        return [text, self.rate] if self.rate else [text]

    def to_frame(self) -> pd.DataFrame:
        """Returns means, ranges, errors and spreads, a row each."""
        return self.outputs

    def plot(self) -> Figure:
        """Plots the energy of a blow: work beside losses."""
        return answers.energies(dict(self.mean[[*WORKS]]))


def named(name: str) -> str:
    """Returns the name of a mean; raises if there is none."""
    if name not in MEANS:
        raise UnknownNameError("mean", name, MEANS)
    return name


def unit(name: str) -> str:
    """Unit of a mean."""
    return UNITS.get(name) or VARIABLES[name].unit


#: The engine's own.
DEFAULTS = _native.wanted()


@dataclass(frozen=True)
class Wanted:
    """How long-run responses are found."""

    #: Largest standard error of both rates, or by name of any means, over the mean.
    error: float | Mapping[str, float] = DEFAULTS["error"]
    #: Most blows simulated.
    blows: int = int(DEFAULTS["blows"])
    #: Without a blow for so long it is stalled, s.
    limit: float = DEFAULTS["limit"]

    def __post_init__(self) -> None:
        bounds = [("blows", self.blows, FEWEST, 1e7), ("limit", self.limit, 1e-3, 1e4)]
        bounds += [(f"error of {name}", error, 1e-6, 1.0) for name, error in self.by_mean.items()]
        for name, value, low, high in bounds:
            if not low <= quantities.read(value, "1", name) <= high:
                raise DomainError(f"{name} = {value} must be {low:g} to {high:g}")

    @property
    def by_mean(self) -> dict[str, float]:
        """Errors by the names of the means."""
        if isinstance(self.error, Mapping):
            return {named(name): error for name, error in self.error.items()}
        return dict.fromkeys(RATES, self.error)

    @property
    def errors(self) -> list[float]:
        """An error for each mean, infinity where any will do."""
        return [self.by_mean.get(name, np.inf) for name in MEANS]

    @property
    def ways(self) -> tuple[list[float], int, float, int]:
        """The same as the engine takes it, with the most blows after which a motion may repeat."""
        return self.errors, self.blows, self.limit, int(DEFAULTS["repeating"])


def responses(
    points: Sequence[Mapping[str, float]], wanted: Wanted, **ways: Any
) -> list[Steady | str]:
    """Returns the long-run responses of many hammers in their order, found as by `finished`."""
    found = dict(finished(points, wanted, **ways))
    return [found[k] for k in range(len(points))]


def finished(
    points: Sequence[Mapping[str, float]],
    wanted: Wanted,
    *,
    progress: bool = False,
    stopped: Callable[[], bool] = lambda: False,
) -> Iterator[tuple[int, Steady | str]]:
    """Yields the long-run responses of many hammers as they finish; text says why one is refused.

    Ctrl-C ends all, and so does ``stopped``: a thread that is not the main one hears of no signal.
    """
    scenes = [[*point.items()] for point in points]
    if not scenes:
        return
    batch = _native.Batch.steady(scenes, wanted.ways, cores())
    done = 0
    with telling(progress, len(scenes)) as tell:
        try:
            while done < len(scenes):
                for index, values, refused, warnings in batch.take(1, PART) or ():
                    done += 1
                    yield index, refused or answered(values, points[index], warnings)
                if stopped():
                    raise KeyboardInterrupt
                tell(*batch.progress(), done)
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
    """Returns a response from the engine's answer."""
    repeating, blows, reached, *numbers = values
    kinds = {-1: "stalled", 0: "irregular", 1: "cycle"}
    kind = kinds.get(int(repeating), f"cycle of {repeating:g}")
    parts = np.array(numbers).reshape(3, len(MEANS))
    if kind == "stalled":
        parts[:] = np.nan
    short = () if reached > 0.5 else (NOT_REACHED.format(int(blows)),)
    reasons = (*warnings, *short)
    return Steady(kind, tabled(parts, point), int(blows), not short, dict(point), reasons)


def tabled(parts: Array, given: Mapping[str, float]) -> pd.DataFrame:
    """Returns means, errors and spreads as a table of outputs."""
    columns = dict(zip(("mean", "error", "spread"), parts, strict=True))
    frame = pd.DataFrame(columns, index=pd.Index(MEANS, name="output"))
    frame = beside(frame, "mean", factor(given))
    frame["unit"] = [unit(name) for name in MEANS]
    return frame


@contextmanager
def telling(shown: bool, total: int = 1) -> Iterator[Callable[..., None]]:
    """A progress bar, if it is wanted, as what is told blows so far and error over that wanted."""
    many = {"total": total, "unit": "hammer"}
    drawn = bar(shown, **(many if total > 1 else {"unit": "blow"}))
    with nullcontext() if drawn is None else drawn:

        def tell(blows: int, error_ratio: float, done: int = 0) -> None:
            if drawn is not None:
                drawn.n = done if total > 1 else blows
                known = np.isfinite(error_ratio)
                text = f"{error_ratio:.2g} times the one wanted" if known else "not yet known"
                drawn.set_postfix_str(f"error {text}")

        yield tell
