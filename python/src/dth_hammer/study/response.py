"""The long-run response: of one hammer, or a table of many."""

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
from ..scene.hammers import Hammerlike, Rocklike, numbers_of, scene_of
from ..scene.signals import Signal, signals_of
from ..scene.variables import STEP, Value
from ..simulation.hammer import Hammer
from .cases import Case
from .longrun import Steady, Wanted, responses, telling
from .motions import drawn, met
from .stepped import Acts, Stepped, moved
from .sweeping import Grid, several, table_of


@overload
def steady(  # type: ignore[overload-overlap]
    hammer: Hammerlike = ...,
    *,
    preset: str | None = ...,
    rock: Rocklike = ...,
    error: float | Mapping[str, float] = ...,
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
    error: float | Mapping[str, float] = ...,
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
    error: float | Mapping[str, float] = Wanted.error,
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
    """Finds the long-run means of a hammer, or of each of many, with their errors.

    If the blows come to repeat, to 1e-9, the means are those of the last ones, without error.
    Otherwise several simulations run side by side until the standard error of the rate of
    penetration is small enough. The start of each is left out, and correlated blows are averaged
    in batches.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet` or a
            `Run`. Of many hammers, as for `sweep`: values by parameter, a list of parameters by
            name, or a DataFrame. The answer is then a table, a row each: means, their errors as
            ``rop_error`` and so on, what kind of motion it is, of how many blows, and whether the
            error was reached; why one is refused is in ``error``.
        preset: parameter set that a mapping is laid over.
        rock: beside it: a name, a class or a strength, or a file, as `dth_hammer.rock` takes them.
        error: largest relative standard error of the rates of hole and tip. A mapping
            has one for any means by name: ``{"blow_energy": 0.005}``.
        blows: the largest number of blows to simulate. If they are not enough, `Steady.reached`
            is false and a warning is given.
        limit: a hammer that strikes no blow for this long counts as stalled: s, or text with a
            unit.
        starts: number of starts from which it is simulated: its own, and others that are drawn,
            with the piston elsewhere above the bit and at another speed. `Steady.motions` has what
            they settle to; the answer is that of its own start. A cycle is tried from a second
            start even if no other is asked for: if it is irregular from there, a warning says so.
        seed: random seed of the starts that are drawn.
        inputs: over time, as for `simulate`.
        control: called with the hammer before each step.
        partner: takes a hammer and returns what steps it, such as a `Coupling` with a model of
            its drive.
        step: communication step of inputs, control and partner; as of `simulate` if None.
        out: Parquet or CSV file for the rows of many hammers: the same call made again seeks
            only what is missing, as with `sweep`.
        scheduler: an executor that shares many hammers out, as for `sweep`.
        workers: number of the engine's threads; as many as there are cores if not given.
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
    wanted = Wanted(error, blows, quantities.duration(limit, "limit"), second=starts == 1)
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
    if starts < 1:
        raise DomainError(f"starts = {starts} must be 1 or more")
    if signals or control or partner:
        if starts > 1:
            raise DomainError("starts are drawn of hammers without inputs, control or partner only")
        size = STEP if step is None else quantities.duration(step, "step")
        acts = Acts(signals_of(signals), deepcopy(control), partner, size)
        with telling(progress) as tell:
            return moved(given, wanted, acts, tell)
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
    others = responses(drawn(given, speed, starts - 1, seed), wanted, progress=progress)
    motions, texts = met(found, others)
    for text in texts:
        warn(text)
    return replace(found, motions=motions, warnings=(*found.warnings, *texts))


def _many(hammer: Hammerlike | Grid) -> TypeGuard[Grid]:
    """Whether these are many hammers: several values of a parameter, or rows."""
    if isinstance(hammer, Mapping):
        return any(several(values) for values in hammer.values())
    return isinstance(hammer, pd.DataFrame | list | tuple)
