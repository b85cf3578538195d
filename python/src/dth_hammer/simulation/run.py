"""From parameters to a run: `simulate`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from .. import _native
from ..contract import typed
from ..errors import DomainError, UnknownNameError, warn
from ..extras import bar
from ..frames import np, pd
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

#: Number of updates of a progress bar in a run.
PARTS = 100
PER_BLOW = (
    *("blow_time", "blow_period", "blow_speed", "blow_energy", "blow_penetration"),
    *("rop", "tip_rate"),
)
#: Columns of a table of blows: unit, display unit, and whether they must be recorded.
OF_BLOW = {name: (unit, display, must) for name, unit, display, must in _native.BLOW}
#: Outputs of a step that take longer than the run itself; `Run.blows` has them for each blow.
PER_STEP = ("contact_force_peak", "rock_force_peak", "chuck_force_peak")


@dataclass(frozen=True, repr=False, eq=False)
class Run(answers.Answer):
    """A run: its outputs over time, its blows, and the scene that was simulated."""

    #: Outputs over time, one column each; ``attrs["units"]`` has their units.
    frame: pd.DataFrame = field(repr=False)
    #: The engine's record of each blow, counted from 1; it does not depend on the step. Of the
    #: impact: `blow_time`, `blow_speed`, `blow_energy`. Since the previous blow (or the start):
    #: `blow_period`, `blow_penetration` and `tip_rate` of the bit's tip, `blow_length` and `rop` of
    #: the hole, `rebound_speed`, largest forces, works (`rock_work` is `crushing_work` plus
    #: `viscous_work`), `free_air`.
    blows: pd.DataFrame = field(repr=False)
    #: The scene that was simulated.
    scene: Scene
    #: Numbers of all parameters and inputs that were set, by name, in SI units.
    parameters: Mapping[str, float] = field(repr=False)
    #: Warnings of the run.
    warnings: tuple[str, ...] = ()
    #: Values of the parameters of the derivatives, if any were requested.
    by: Mapping[str, float] = field(default_factory=dict, repr=False)
    #: Further numbers for figures: the time of an impact (s), a period (s) and so on.
    notes: Mapping[str, float] = field(default_factory=dict, repr=False)
    #: Version of the engine.
    model: str = field(default_factory=model)

    def __getitem__(self, name: str) -> pd.Series:
        """Returns an output over time."""
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
        """Returns the number of outputs that were read."""
        return self.frame.shape[1]

    def keys(self) -> list[str]:
        """Returns the names of the outputs, so that ``dict(run)`` works."""
        return [*self]

    def __eq__(self, other: object) -> bool:
        """Returns whether parameters and results are identical to the last binary digit."""
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
            units: ``"si"``, ``"metric"`` (field units), ``"us"`` (in, ft, lbf, psi), or a unit by
                column, for instance ``{"rop": "m/h"}``.
        """
        own = units
        if not isinstance(units, str):
            own = {n: u for n, u in units.items() if n in self.frame or n not in self.blows}
        blows = quantities.convert(self.blows, units, skip_missing=True)
        return replace(self, frame=quantities.convert(self.frame, own), blows=blows)

    def to_frame(self, *names: str, units: quantities.Units | None = None) -> pd.DataFrame:
        """Returns a table for display, with the unit of each column in its heading: ``rop [m/s]``.

        Args:
            names: columns of the table of blows if it has all of them, otherwise outputs over time;
                by default all columns of the blows.
            units: a system, or units by column, as for `convert`.
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
        """Returns mean and spread (standard deviation) over blows, and the range of the rate.

        ``T``, ``P`` and ``W`` are the blows' periods, penetrations and energies, and ``R`` is the
        work on the rock from a blow to the next, all from the engine's table of blows::

            frequency = n / sum T              tip's gain per time = sum P / sum T
            power of the blows = sum W / sum T     power to the rock = sum R / sum T
            share to the rock = sum R / sum W
            rate of penetration = 4 sum R / (pi D^2 E_v sum T)

        The rock also gets the work of feed and gravity, so the share may exceed 1.

        Args:
            since: the first instant that counts, s or text with a unit; by default the middle of
                the run, so that the transient after the start is left out.

        Returns:
            One row per quantity, with the columns ``mean``, ``low`` and ``high`` (range due to that
            of the specific energy; NaN if there is none), ``spread`` (from blow to blow; NaN for
            powers and frequencies) and ``unit`` (SI).

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
        """Plots outputs over time, one panel each, in the run's units.

        Args:
            columns: outputs; if none is named, the length drilled, and speed, energy and rate of
                each blow.
            ax: axes into which all named outputs are drawn.
        """
        if columns:
            return answers.over_time(self.time, [self._labelled(n) for n in columns], ax)
        if ax is not None:
            raise DomainError("ax is for named outputs: plot('contact_force', ax=ax)")
        si = self.convert("si")
        return answers.overview(si.frame, si.blows)

    def _labelled(self, name: str) -> tuple[Array, str]:
        """Returns an output's values, and its name with the unit."""
        unit = self.units[name] if name in self else ""
        return self[name].to_numpy(float), name if unit in ("", "1") else f"{name} ({unit})"

    def gradient(self, *, elasticities: bool = False, errors: bool = False) -> pd.DataFrame:
        """Returns the derivatives of a run that `simulate` made with ``gradient``, or their errors.

        They are differences of runs; if air drives the hammer, ``air.error`` is 1e-11. Errors are
        estimated from differences with other steps and from the rounding of the runs. Where events
        change their order, the error is at least half the difference of both sides.

        Args:
            elasticities: ``d ln output / d ln parameter`` instead of the derivatives.
            errors: returns the estimated errors instead, in the unit of the derivatives.

        Returns:
            The rows of the run, and columns of two levels: output and parameter.
        """
        by = self.by if elasticities else {}
        return derivatives_in(self.frame, by, errors=errors)

    def in_words(self) -> list[str]:
        """Returns number of blows and time, and the error due to the mesh."""
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
        hammer: parameters by dotted name (a number in the declared unit, a label of an enumeration,
            or text with a unit, ``"60 mm"``; others are those of the reference hammer), a preset's
            name, a `Scene` or its file, a `Datasheet`, a `Run`.
        until: seconds to simulate, or text with a unit (``"500 ms"``); by default that of the
            scene, or 0.6 s.
        inputs: inputs over time: a number, a function of time, or a Series over rising instants
            (constant before its first and after its last). Between communication points they are
            straight lines.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        step: communication step, s, or text with a unit. The physics does not depend on it: it
            only sets how often outputs are read.
        times: instants at which outputs are read, instead of a step.
        outputs: names to read; by default all outputs and local variables, except the largest
            forces of each step (`contact_force_peak` and so on). `Run.blows` then has those of each
            blow, with its rebound and works; to save time, a run of named outputs leaves them out.
        waves: also reads stress and velocity along piston and bit, with as many columns as the mesh
            needs. `dth_hammer.waves` makes a diagram of them.
        gradient: parameters and inputs by which the outputs are differentiated, through every
            event. For an input it is the derivative by a constant that is added to it at all times.
            The derivatives are columns ``"rop per rock.stiffness"``; `Run.gradient` extracts them.
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
        rerun = partial(_rerun, start, signals, instants, [*chosen], control=control)
        found = derivatives(start, by, rerun)
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
    """Steps a hammer from instant to instant. Returns a row of the outputs at each, and all blows.

    Without ``control`` this is one call of the engine, or a few if there is a progress bar.
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


def _rerun(
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
    frame.attrs = _attributes((v.name, v.unit, v.display_unit) for v in variables)
    return frame


def _blows(blows: Array, *, recorded: bool) -> pd.DataFrame:
    """Returns the table of blows."""
    every = zip(OF_BLOW, blows.T, strict=True)
    columns = {name: values for name, values in every if recorded or not OF_BLOW[name][2]}
    index = pd.RangeIndex(1, len(blows) + 1, name="blow")
    table = pd.DataFrame({name: columns[name] for name in (*PER_BLOW, *columns)}, index=index)
    table.attrs = _attributes((name, *OF_BLOW[name][:2]) for name in columns)
    return table


def _attributes(columns: Iterable[tuple[str, str, str | None]]) -> dict[Any, Any]:
    """Returns the units of a table, from the name, unit and display unit of each column."""
    listed = [*columns]
    units = {name: unit for name, unit, _ in listed}
    displayed = {name: display for name, _, display in listed if display}
    return {"units": quantities.Fixed(units), "display_units": quantities.Fixed(displayed)}
