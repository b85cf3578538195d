"""From parameters to a run: `simulate`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _native
from ..contract import typed
from ..errors import DomainError, UnknownNameError, warn
from ..extras import bar
from ..frames import pd
from ..scene import quantities
from ..scene.band import factor
from ..scene.hammers import Hammerlike, Rocklike, scene_of
from ..scene.mesh import coarse_for, errors_in_words
from ..scene.scene import Scene
from ..scene.signals import Function, Signal, instants_of, signals_of
from ..scene.variables import STEP, VARIABLES, Array, Variable, model, numbers, whole
from . import answers
from .gradients import derivatives, derivatives_in, warnings_of, with_derivatives
from .hammer import Hammer
from .summary import readable, summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Parts of a run between which a progress bar moves.
PARTS = 100
#: First columns of a table of blows.
PER_BLOW = (
    *("blow_time", "blow_period", "blow_speed", "blow_energy", "blow_penetration"),
    *("rop", "tip_rate"),
)
#: Columns of a table of blows: unit, display unit, and whether the engine must record it.
OF_BLOW = {name: (unit, display, must) for name, unit, display, must in _native.BLOW}
#: Outputs of a step whose search takes longer than the run: `Run.blows` has them of blows.
PER_STEP = ("contact_force_peak", "rock_force_peak", "chuck_force_peak")


@dataclass(frozen=True, repr=False, eq=False)
class Run(answers.Answer):
    """A run: its outputs over time, its blows, and the scene that was simulated."""

    #: Outputs over time, a column each; ``attrs["units"]`` says in which units.
    frame: pd.DataFrame = field(repr=False)
    #: The engine's record of each blow, counted from 1, however often one looked: `blow_time`,
    #: `blow_speed`, `blow_energy` of its impact; since the blow before (or the start)
    #: `blow_period`, `blow_penetration` and `tip_rate` of the bit's tip, `blow_length` and `rop` of
    #: the hole, `rebound_speed`, largest forces, works (`rock_work` is `crushing_work` and
    #: `viscous_work`), `free_air`.
    blows: pd.DataFrame = field(repr=False)
    #: What was asked for.
    scene: Scene
    #: Numbers of all that was set, by name, in SI units.
    parameters: Mapping[str, float] = field(repr=False)
    #: What was warned of.
    warnings: tuple[str, ...] = ()
    #: Values of what derivatives are by, if they were asked for.
    by: Mapping[str, float] = field(default_factory=dict, repr=False)
    #: What a figure needs beside: the instant of an impact (s), a period (s) and so on.
    notes: Mapping[str, float] = field(default_factory=dict, repr=False)
    #: Version of the engine.
    model: str = field(default_factory=model)

    def __getitem__(self, name: str) -> pd.Series:
        """An output over time."""
        if name not in self.frame:
            raise UnknownNameError("output of the run", name, self)
        return self.frame[name]

    def __contains__(self, name: object) -> bool:
        """Returns whether an output was read."""
        return name in self.frame

    def __iter__(self) -> Iterator[str]:
        """Iterates over the names of the outputs."""
        return map(str, self.frame)

    def __len__(self) -> int:
        """Number of outputs that were read: that of the names."""
        return self.frame.shape[1]

    def keys(self) -> list[str]:
        """Names of the outputs, so that ``dict(run)`` has each over time."""
        return [*self]

    def __eq__(self, other: object) -> bool:
        """Whether both have the same numbers, to the last binary digit, of the same parameters."""
        if not isinstance(other, Run):
            return NotImplemented
        tables = self.frame.equals(other.frame) and self.blows.equals(other.blows)
        return tables and self.parameters == other.parameters

    __hash__ = None  # type: ignore[assignment]

    @property
    def time(self) -> Array:
        """The instants, s."""
        return self.frame.index.to_numpy(float)

    @property
    def units(self) -> Mapping[str, str]:
        """Units of the columns."""
        return {"time": "s", **self.frame.attrs["units"]}

    def convert(self, units: quantities.Units) -> Run:
        """Returns the run in other units.

        Args:
            units: ``"si"``, ``"metric"`` (what people use), ``"us"`` (in, ft, lbf, psi), or a unit
                by column, for instance ``{"rop": "m/h"}``.
        """
        own = units
        if not isinstance(units, str):
            own = {n: u for n, u in units.items() if n in self.frame or n not in self.blows}
        blows = quantities.convert(self.blows, units, skip_missing=True)
        return replace(self, frame=quantities.convert(self.frame, own), blows=blows)

    def to_frame(self, *names: str, units: quantities.Units | None = None) -> pd.DataFrame:
        """Returns a table for reading, the unit of each column in its heading: ``rop [m/s]``.

        Args:
            names: columns, of the blows if these have them all, else over time; all of the blows'
                if not given.
            units: a system, or a unit by column, as of `convert`.
        """
        run = self if units is None else self.convert(units)
        table = run.blows if all(name in run.blows for name in names) else run.frame
        if missing := [name for name in names if name not in table]:
            raise UnknownNameError("output of the run", missing[0], map(str, table))
        return quantities.with_units(table[[*names]] if names else table)

    def since(self, impact: float, notes: Mapping[str, float]) -> Run:
        """Returns the run with times counted from an instant (s)."""
        frame = self.frame.set_axis(pd.Index(self.time - impact, name="time"), axis=0)
        frame.attrs = self.frame.attrs
        return replace(self, frame=frame, notes={**self.notes, **notes})

    def summary(self, since: float | str | None = None) -> pd.DataFrame:
        """Mean and spread (standard deviation) over blows, and the range of the rate.

        With the periods ``T``, penetrations ``P``, energies ``W`` of the blows and the works ``R``
        given to the rock between each and the next, all from the engine's own table of blows::

            frequency = n / sum T              tip's gain per time = sum P / sum T
            power of the blows = sum W / sum T     power to the rock = sum R / sum T
            share to the rock = sum R / sum W
            rate of penetration = 4 sum R / (pi D^2 E_v sum T)

        The work of feed and gravity goes to the rock too, so that the share may exceed 1.

        Args:
            since: the first instant that counts, s or text with a unit; the middle of the run if
                not given, so that the way from rest to the settled blow is left out.

        Returns:
            A row a quantity; columns ``mean``, ``low`` and ``high`` (what the specific energy's
            range makes of the rate; none of what does not depend on it), ``spread`` (blow by blow;
            none of a power or a frequency) and ``unit`` (SI).

        Raises:
            TooFewBlowsError: fewer than two complete blow periods.
        """
        si = self.convert("si")
        begin = self.time[-1] / 2 if since is None else quantities.seconds(since, "since")
        return summary(si.blows, begin, factor(self.parameters))

    def readable(self, since: float | str | None = None) -> str:
        """Returns the `summary` as text, in the units of the trade."""
        return readable(self.summary(since))

    def plot(self, *columns: str, ax: Axes | None = None) -> Figure:
        """Plots outputs over time, a panel each, in the units that the run has.

        Args:
            columns: outputs; if none is named, the length drilled, and speed, energy and rate of
                each blow.
            ax: axes of one's own, which all the named outputs are drawn into.
        """
        if columns:
            return answers.over_time(self.time, [self._labelled(n) for n in columns], ax)
        if ax is not None:
            raise DomainError("ax is for named outputs: plot('contact_force', ax=ax)")
        si = self.convert("si")
        return answers.overview(si.frame, si.blows)

    def _labelled(self, name: str) -> tuple[Array, str]:
        """An output's values and its name with the unit."""
        unit = self.units[name] if name in self else ""
        return self[name].to_numpy(float), name if unit in ("", "1") else f"{name} ({unit})"

    def gradient(self, *, elasticities: bool = False, errors: bool = False) -> pd.DataFrame:
        """The derivatives in a run that `simulate` made with ``gradient``, or their errors.

        They are differences of runs, under air with ``air.error`` at its least, 1e-11. An error is
        estimated from differences with other steps and from the rounding of the runs; where events
        change their order at this very point, it is at least half the difference of both sides.

        Args:
            elasticities: ``d ln output / d ln parameter`` instead of the derivatives.
            errors: the estimated errors, in the unit of the derivatives, in place of these.

        Returns:
            The same rows, with columns of two levels: output, and what it is differentiated by.
        """
        by = self.by if elasticities else {}
        return derivatives_in(self.frame, by, errors=errors)

    def in_words(self) -> list[str]:
        """Blows and time, and by how much the mesh errs."""
        counted = f"{len(self.blows)} blows in {self.time[-1]:g} s"
        return [counted, *errors_in_words(self.parameters)]


@typed()
def simulate(
    hammer: Hammerlike = None,
    until: float | str | None = None,
    inputs: Mapping[str, Signal] | None = None,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    step: float | str | None = STEP,
    times: Collection[float | str] | None = None,
    outputs: Iterable[str] | None = None,
    waves: bool = False,
    gradient: Iterable[str] = (),
    control: Callable[[Hammer], None] | None = None,
    progress: bool = False,
) -> Run:
    """Simulates a hammer.

    Args:
        hammer: parameters by dotted name (a number in the declared unit, a label of an
            enumeration, or text with a unit, ``"60 mm"``; what is not given is that of the
            reference hammer), a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        until: seconds to simulate, or text with a unit (``"500 ms"``); what the scene says, or
            0.6 s, if not given.
        inputs: over time: a number, a function of time, or a Series over rising instants
            (held before its first and after its last). Between communication points they
            are straight lines.
        preset: parameter set that a mapping is laid over.
        rock: beside it: a name, a class or a strength, or a file, as `dth_hammer.rock` takes them.
        step: communication step, s, or text with a unit. The physics does not depend on it: it
            only sets how often outputs are read.
        times: instants at which outputs are read, in place of a step.
        outputs: names to read; all outputs and local variables if not given, but the largest forces
            of each step (`contact_force_peak` and so on): `Run.blows` has those of each blow then,
            with its rebound and works, for which a run of named outputs takes no time.
        waves: reads also stress and velocity along piston and bit, as many columns as the
            mesh needs. `dth_hammer.waves` makes a diagram of them.
        gradient: parameters and inputs by which the outputs are differentiated, through every
            event. An input stands for a constant added to it all along. The derivatives are
            columns ``"rop per rock.stiffness"``; `Run.gradient` sorts them out.
        control: called with the hammer at each communication point before the step,
            for instance to set tunable parameters by depth.
        progress: shows a progress bar.

    Example:
        >>> from dth_hammer import simulate
        >>> run = simulate({"rock.stiffness": "200 MN/m"}, until="300 ms")
        >>> blow = run.blows.iloc[-1]
        >>> print(f"{blow.blow_energy:.0f} J, {3600 * blow.rop:.1f} m/h")
        233 J, 11.0 m/h
    """
    scene = scene_of(hammer, rock, preset)
    until = scene.until if until is None else until
    instants = instants_of(until, step, times)
    asked = [*outputs] if outputs else []
    named = [VARIABLES[n] for n in asked]
    scene = replace(scene, inputs={**scene.inputs, **(inputs or {})})
    signals, given = signals_of(scene.inputs), scene.numbers
    start = given | numbers(None, {name: signal(0.0) for name, signal in signals.items()})
    usual = (v for v in VARIABLES.of("output", "local") if v.name not in PER_STEP)
    chosen = {v.name: v for v in named or usual}
    if waves:
        chosen |= {name: VARIABLES[name] for name in _native.wave_names(given)}
    with Hammer(start, record=not asked) as live:
        rows, blows = play(live, instants, signals, [*chosen], control=control, progress=progress)
        if hidden := int(live["blow_count"]) - len(blows):
            warn(f"{hidden} blows are missing: a step had too many, or `control` made one")
        live.check()
        warnings = tuple(live.warnings) + coarse_for(asked, waves, given)
    frame = _frame(rows, [*chosen.values()], instants)
    by = [*dict.fromkeys(gradient)]
    if by:
        again = partial(_again, start, signals, instants, [*chosen], control=control)
        found = derivatives(start, by, again)
        texts = warnings_of(found, rows, {name: whole(start)[name] for name in by})
        for text in texts:
            warn(text)
        warnings += tuple(texts)
        frame = with_derivatives(frame, found, by)
    end = until if times is None else float(instants[-1])
    scene = replace(scene, title=scene.title or "run", until=end)
    table, values = _blows(blows, recorded=not asked), {n: whole(given)[n] for n in by}
    return Run(frame, table, scene, given, warnings, values)


def play(
    hammer: Hammer,
    instants: Array,
    signals: Mapping[str, Function],
    names: Sequence[str],
    *,
    control: Callable[[Hammer], None] | None = None,
    progress: bool = False,
) -> tuple[Array, Array]:
    """Steps a hammer from instant to instant: rows of the names at each, and of all blows.

    Without ``control`` that is one call of the engine, or a few that a progress bar follows.
    """
    size = 1 if control else -(-len(instants) // PARTS) if progress else len(instants)
    found = []
    for first in bar(progress, range(0, len(instants), size), unit="part"):
        part = instants[first : first + size]
        if control and part[0] > 0.0:
            hammer.move(signals, float(part[0]))
            control(hammer)
            found.append(hammer.run(part, names, {}))
        else:
            points = [hammer.time, *part]
            values = {name: np.array([s(t) for t in points]) for name, s in signals.items()}
            found.append(hammer.run(part, names, values))
    rows, blows = zip(*found, strict=True)
    return np.concatenate(rows), np.concatenate(blows)


def _again(
    start: Mapping[str, float],
    signals: Mapping[str, Function],
    instants: Array,
    names: Sequence[str],
    changed: Mapping[str, float],
    *,
    control: Callable[[Hammer], None] | None,
) -> tuple[Array, Hammer]:
    """Repeats a run with one number changed slightly; an input over time is shifted throughout."""

    def shifted(name: str, signal: Function) -> Function:
        by = changed.get(name, start[name]) - start[name]
        return lambda t: signal(t) + by

    hammer = Hammer({**start, **changed}, quiet=True, journal=True)
    moved = {name: shifted(name, signal) for name, signal in signals.items()}
    rows, _ = play(hammer, instants, moved, names, control=deepcopy(control))
    return rows, hammer


def _frame(rows: Array, variables: list[Variable], instants: Array) -> pd.DataFrame:
    columns: dict[str, Any] = {}
    for variable, values in zip(variables, rows.T, strict=True):
        if variable.kind == "Boolean":
            columns[variable.name] = values > 0.5
        elif variable.labels:
            codes = values.astype(int) - 1
            labels = pd.Index([*variable.labels.values()])
            columns[variable.name] = pd.Categorical.from_codes(codes, labels)
        elif variable.counts:
            columns[variable.name] = values.astype(np.int64)
        else:
            columns[variable.name] = values
    frame = pd.DataFrame(columns, index=pd.Index(instants, name="time"))
    frame.attrs = _attributes(variables)
    return frame


def _blows(blows: Array, *, recorded: bool) -> pd.DataFrame:
    """Returns the table of blows."""
    every = zip(OF_BLOW, blows.T, strict=True)
    columns = {name: values for name, values in every if recorded or not OF_BLOW[name][2]}
    index = pd.RangeIndex(1, len(blows) + 1, name="blow")
    table = pd.DataFrame({name: columns[name] for name in (*PER_BLOW, *columns)}, index=index)
    units = {name: OF_BLOW[name][0] for name in columns}
    displayed = {name: unit for name in columns if (unit := OF_BLOW[name][1])}
    table.attrs = {"units": quantities.Fixed(units), "display_units": quantities.Fixed(displayed)}
    return table


def _attributes(variables: Iterable[Variable]) -> dict[Any, Any]:
    listed = [*variables]
    units = {v.name: v.unit for v in listed}
    displayed = {v.name: v.display_unit for v in listed if v.display_unit}
    return {"units": quantities.Fixed(units), "display_units": quantities.Fixed(displayed)}
