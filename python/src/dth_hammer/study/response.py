"""The long-run response of one hammer, or a table of the responses of many."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Executor
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import TypeGuard, cast, overload

from ..contract import typed
from ..errors import DomainError, RefusedError, warn
from ..frames import pd
from ..scene import quantities
from ..scene.band import factor, unseen
from ..scene.hammers import Hammerlike, Rocklike, numbers_of, scene_of
from ..scene.signals import Signal, signals_of
from ..scene.variables import STEP, Value
from ..simulation.hammer import Hammer
from .cases import Case
from .longrun import DEFAULTS, Steady, Wanted, progress_reporter, responses
from .motions import motions_of, random_starts
from .stepped import Acts, Stepped, moved
from .sweeping import Grid, several, table_of


@overload
def steady(  # type: ignore[overload-overlap]
    hammer: Hammerlike = ...,
    *,
    preset: str | None = ...,
    rock: Rocklike = ...,
    error: float | Mapping[str, float] | None = ...,
    blows: int = ...,
    limit: float | str = ...,
    starts: int = ...,
    seed: int = ...,
    inputs: Mapping[str, Signal] | None = ...,
    control: Callable[[Hammer], None] | None = ...,
    partner: Callable[[Hammer], Stepped] | None = ...,
    step: float | str | None = ...,
    progress: bool = ...,
) -> Steady: ...


@overload
def steady(
    hammer: Grid,
    *,
    preset: str | None = ...,
    rock: Rocklike = ...,
    error: float | Mapping[str, float] | None = ...,
    blows: int = ...,
    limit: float | str = ...,
    out: str | Path | None = ...,
    scheduler: Executor | None = ...,
    workers: int | None = ...,
    progress: bool = ...,
) -> pd.DataFrame: ...


@typed()
def steady(
    hammer: Hammerlike
    | Mapping[str, Value | Collection[Value]]
    | Sequence[Mapping[str, Value]]
    | pd.DataFrame = None,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    error: float | Mapping[str, float] | None = None,
    blows: int = Wanted.blows,
    limit: float | str = Wanted.limit,
    starts: int = 1,
    seed: int = 1,
    inputs: Mapping[str, Signal] | None = None,
    control: Callable[[Hammer], None] | None = None,
    partner: Callable[[Hammer], Stepped] | None = None,
    step: float | str | None = None,
    out: str | Path | None = None,
    scheduler: Executor | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> Steady | pd.DataFrame:
    """Finds the long-run means of one hammer, or of each of many hammers, with their errors.

    If the blows come to repeat to 1e-9, the means are those of the last blows, without error.
    Otherwise several simulations run in parallel until the standard error of the rate of
    penetration is small enough. The start of each is left out, and correlated blows are averaged in
    batches.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet` or a
            `Run`. Many hammers are given as for `sweep`: values by parameter, a list of parameters
            by name, or a DataFrame. The result is then a table with one row each: means, their
            errors (``rop_error`` and so on), kind of motion, number of blows, whether the error was
            reached, and in ``error`` the reason why a hammer was refused.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        error: largest relative standard error of the rates of hole and tip, or errors of any means
            by name: ``{"blow_energy": 0.005}``. The default is 1 %, or of one hammer the largest
            error that does not show in the range of its rate.
        blows: the largest number of blows to simulate. If they are not enough, `Steady.reached`
            is false and a warning is given.
        limit: a hammer that makes no blow for this time counts as stalled: s, or text with a unit.
        starts: number of starts: the hammer's own, and random ones with the piston at another
            height and speed. `Steady.motions` has the motions to which they settle; the result is
            that of the own start. A cycle is always tried from a second start: if it is irregular
            from there, a warning says so.
        seed: random seed of the starts.
        inputs: inputs over time, as for `simulate`.
        control: called with the hammer before each step.
        partner: takes a hammer and returns an object that steps it, such as a `Coupling` with a
            model of its drive.
        step: communication step of inputs, control and partner; by default that of `simulate`.
        out: Parquet or CSV file for the rows of many hammers; as with `sweep`, the same call
            computes only the missing rows.
        scheduler: an executor that distributes many hammers, as for `sweep`.
        workers: number of the engine's threads; by default one per core.
        progress: shows blows and error so far.

    Raises:
        RefusedError: the engine refuses the hammer; the message says why.

    Example:
        >>> from dth_hammer import steady
        >>> found = steady({"feed_force": "6 kN"})
        >>> print(found.kind, f"{found.mean['blow_frequency']:.2f} Hz")
        cycle 21.99 Hz
        >>> table = steady({"feed_force": ["4 kN", "6 kN"], "fidelity": "Rigid"})
        >>> print(table[["feed_force", "kind"]].to_string(index=False))
         feed_force  kind
             4000.0 cycle
             6000.0 cycle
    """
    wanted = Wanted(
        Wanted.error if error is None else error,
        blows,
        quantities.duration(limit, "limit"),
        second=starts == 1,
    )
    if _many(hammer):
        if starts != 1 or inputs or control or partner or step is not None:
            raise DomainError(
                "many hammers have one start each, and no inputs over time, control or partner "
                "here: call steady for each hammer that has those"
            )
        by, case = (scheduler, workers), Case(numbers_of(None, preset, rock))
        return table_of(hammer, wanted, {"": case}, out=out, by=by, progress=progress)
    if out is not None or scheduler is not None or workers is not None:
        raise DomainError("out, scheduler and workers are for many hammers: give lists or rows")
    scene = scene_of(cast("Hammerlike", hammer), rock, preset)
    given, signals = scene.numbers, {**scene.inputs, **(inputs or {})}
    if error is None:
        wanted = replace(wanted, error=max(DEFAULTS["error"], unseen(factor(given))))
    if starts < 1:
        raise DomainError(f"starts = {starts} must be 1 or more")
    if signals or control or partner:
        if starts > 1:
            raise DomainError("starts are drawn of hammers without inputs, control or partner only")
        size = STEP if step is None else quantities.duration(step, "step")
        acts = Acts(signals_of(signals), deepcopy(control), partner, size)
        with progress_reporter(progress) as report:
            return moved(given, wanted, acts, report)
    if step is not None:
        raise DomainError("a step changes nothing without inputs over time, control or a partner")
    (found,) = responses([given], wanted, progress=progress)
    if isinstance(found, str):
        raise RefusedError(found)
    for text in found.warnings:
        warn(text)
    if starts == 1:
        return found
    speed = found["blow_speed"] if found.kind != "stalled" else 1.0
    others = responses(random_starts(given, speed, starts - 1, seed), wanted, progress=progress)
    motions, texts = motions_of(found, others)
    for text in texts:
        warn(text)
    return replace(found, motions=motions, warnings=(*found.warnings, *texts))


def _many(hammer: Hammerlike | Grid) -> TypeGuard[Grid]:
    """Returns whether these are many hammers: several values of a parameter, or rows."""
    if isinstance(hammer, Mapping):
        return any(several(values) for values in hammer.values())
    return isinstance(hammer, pd.DataFrame | list | tuple)
