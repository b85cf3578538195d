"""From parameters to a run: `simulate`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native, quantities
from .errors import DomainError, DthHammerError, warn
from .extras import need
from .fixed import Fixed
from .gradients import derivatives, smooth, with_derivatives
from .hammer import Hammer
from .variables import STEP, UNTIL, VARIABLES, Array, Value, Variable, model, numbers, whole

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from .scene import Scene

#: An input over time: a number, a function of time, or a Series that is interpolated.
Signal = Any
#: The same, looked at: its value at an instant.
Function = Callable[[float], float]
#: Most points that a run may have: beyond, a unit is likely wrong.
POINTS = 1e8
#: Parts of a run between which a progress bar moves.
PARTS = 100
#: The rate of the hole, by specific energy.
RATE = "rop_energy"
#: What a table of blows has; the last one where hole and specific energy are given.
PER_BLOW = (
    *("blow_time", "blow_period", "blow_speed", "blow_energy", "blow_penetration", "rop"),
    RATE,
)


@dataclass(frozen=True)
class Run:
    """A run: its outputs over time, its blows, and what it was made from."""

    #: Outputs over time, a column each; ``attrs["units"]`` says in which units.
    frame: pd.DataFrame = field(repr=False)
    #: One row a blow, counted from 1, however often one looked.
    blows: pd.DataFrame = field(repr=False)
    #: What was asked for.
    scene: Scene
    #: Numbers of all that was set, by name, in SI units.
    parameters: Mapping[str, float] = field(repr=False)
    #: Work given to the rock since the blow before, J, by blow.
    rock_work: Array = field(repr=False)
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
        return self.frame[name]

    def __contains__(self, name: object) -> bool:
        """Whether it was read."""
        return name in self.frame

    def __iter__(self) -> Iterator[str]:
        """Names of what was read."""
        return map(str, self.frame)

    def __len__(self) -> int:
        """How often one looked."""
        return len(self.frame)

    @property
    def time(self) -> Array:
        """The instants, s."""
        return self.frame.index.to_numpy(float)

    @property
    def units(self) -> Mapping[str, str]:
        """Units of the columns."""
        return {"time": "s", **self.frame.attrs["units"]}

    def convert(self, units: str | Mapping[str, str]) -> Run:
        """The same in other units, as `dth_hammer.convert` takes them."""
        if isinstance(units, str):
            return replace(
                self,
                frame=quantities.convert(self.frame, units),
                blows=quantities.convert(self.blows, units),
            )
        own = {n: u for n, u in units.items() if n in self.blows}
        rest = {n: u for n, u in units.items() if n in self.frame or n not in own}
        return replace(
            self,
            frame=quantities.convert(self.frame, rest),
            blows=quantities.convert(self.blows, own),
        )

    def since(self, impact: float, notes: Mapping[str, float]) -> Run:
        """The same with times that count from an instant, s."""
        import pandas as pd  # noqa: PLC0415

        frame = self.frame.set_axis(pd.Index(self.time - impact, name="time"), axis=0)
        frame.attrs = self.frame.attrs
        return replace(self, frame=frame, notes={**self.notes, **notes})

    def summary(self, since: float | str | None = None) -> pd.DataFrame:
        """Mean and spread over blows: `dth_hammer.summary.summary`.

        Args:
            since: the first instant that counts, s or text with a unit; the middle of the run if
                not given, so that the way from rest to the settled blow is left out.
        """
        from .summary import summary  # noqa: PLC0415, it names what a run is

        return summary(self, since)

    def plot(self) -> Figure:
        """Depth, and the blows one by one."""
        from .figures import overview  # noqa: PLC0415, loaded by who draws

        return overview(self)

    def _repr_html_(self) -> str:
        summary = f"{len(self.blows)} blows in {self.time[-1]:g} s"
        return f"<p>{summary}</p>{self.frame.to_html(max_rows=10)}"


def simulate(
    parameters: Mapping[str, Value] | None = None,
    until: float | str | None = None,
    inputs: Mapping[str, Signal] | None = None,
    *,
    preset: str | None = None,
    step: float | str | None = None,
    times: Sequence[float | str] | Array | None = None,
    outputs: Iterable[str] | None = None,
    waves: bool = False,
    gradient: Iterable[str] = (),
    control: Callable[[Hammer], None] | None = None,
    progress: bool = False,
) -> Run:
    """Runs a hammer.

    Args:
        parameters: by dotted name: a number in the declared unit, a label of an
            enumeration, or text with a unit (``"60 mm"``). What is not given is that of the
            reference hammer.
        until: seconds to simulate, or text with a unit (``"500 ms"``); 0.6 s if not given.
        inputs: over time: a number, a function of time, or a Series over rising instants
            (held before its first and after its last). Between communication points they
            are straight lines.
        preset: parameter set to start from, see `dth-hammer info`.
        step: communication step, as ``until``; 1 ms if not given. The physics does not depend
            on it: it is how often one looks.
        times: instants to look at instead of a step.
        outputs: names to read; all outputs and local variables if not given.
        waves: reads also stress and velocity along piston and bit, as many columns as the
            mesh needs; `dth_hammer.waves` makes a diagram of them.
        gradient: parameters and inputs by which the outputs are differentiated, through every
            event; an input stands for a constant added to it all along. The derivatives are
            columns ``"rop per rock.stiffness"``; `dth_hammer.gradient` sorts them out.
        control: called with the hammer at each communication point before the step,
            for instance to set tunable parameters by depth.
        progress: shows a progress bar.
    """
    from .scene import Scene  # noqa: PLC0415, it names what a signal is

    instants = instants_of(until, step, times)
    named = [VARIABLES[n] for n in outputs] if outputs else []
    signals = signals_of(inputs)
    given = numbers(preset, parameters)
    start = given | numbers(None, {name: signal(0.0) for name, signal in signals.items()})
    chosen = {v.name: v for v in named or VARIABLES.of("output", "local")}
    if waves:
        chosen |= {name: VARIABLES[name] for name in _native.wave_names(given)}
    with Hammer(start) as hammer:
        rows, blows = play(hammer, instants, signals, [*chosen], control=control, progress=progress)
        if hidden := int(hammer["blow_count"]) - len(blows):
            warn(f"{hidden} blows are missing: a step had too many, or `control` made one")
        warnings = tuple(hammer.warnings)
    frame = _frame(rows, [*chosen.values()], instants)
    by = [*dict.fromkeys(gradient)]
    if by:

        def again(changed: Mapping[str, float]) -> tuple[Array, Hammer]:
            return _again(start, signals, instants, [*chosen], control=control, changed=changed)

        found = derivatives(start, by, again)
        found, texts = smooth(found, rows, {name: whole(start)[name] for name in by})
        for text in texts:
            warn(text)
        warnings += tuple(texts)
        frame = with_derivatives(frame, found, by)
    scene = Scene("run", "", preset, dict(parameters or {}), dict(inputs or {}), until)
    table, work = _blows(blows)
    return Run(frame, table, scene, given, work, warnings, {n: whole(given)[n] for n in by})


def blows(run: Run | pd.DataFrame) -> pd.DataFrame:
    """One row a blow of a run, in the units that the run has.

    A table of another origin, of a host or of one's own loop, needs the output ``blow_count``:
    where it rises by more than 1 from row to row the last blow is all that is known, and a
    warning says so.
    """
    if isinstance(run, Run):
        return run.blows
    if "blow_count" not in run:
        raise DthHammerError("no blow_count in the table: blows are told from it")
    risen = run["blow_count"].diff()
    last = risen.fillna(run["blow_count"]) > 0
    if hidden := int((risen[risen > 1] - 1).sum()):
        warn(f"{hidden} blows are missing: between two rows only the last one is known")
    # A period and a penetration belong to the blow that completes them.
    table = run.loc[last, [c for c in PER_BLOW if c in run]]
    table = _without_zeros(table)
    table = table.set_axis(run.loc[last, "blow_count"].astype(int).rename("blow"), axis=0)
    table.attrs = _attributes(VARIABLES[str(name)] for name in table)
    return table


def unit(frame: pd.DataFrame, column: str) -> str:
    """Unit of a column."""
    return str(frame.attrs.get("units", {}).get(column, ""))


def instants_of(
    until: float | str | None,
    step: float | str | None,
    times: Sequence[float | str] | Array | None = None,
) -> Array:
    """The communication points of a run, s."""
    if times is not None:
        return _rising(times, "times", twice=True)
    end = UNTIL if until is None else quantities.duration(until, "until")
    size = STEP if step is None else quantities.duration(step, "step")
    if end / size > POINTS:
        raise DomainError(f"{end:g} s in steps of {size:g} s are more than {POINTS:.0e} points")
    # Points k * step, the last one exactly at the end.
    count = max(1, int(np.ceil(end / size - 1e-9)))
    return np.append(np.arange(count) * size, end)


def _rising(times: Iterable[Any], name: str, twice: bool = False) -> Array:
    """Instants in seconds, from numbers, text with units, or timedeltas."""
    import pandas as pd  # noqa: PLC0415, takes longer than all else here

    index = pd.Index(times)
    if isinstance(index, pd.TimedeltaIndex):
        instants = index.total_seconds().to_numpy()
    elif isinstance(index, pd.DatetimeIndex):
        raise DomainError(f"{name} must be seconds since the start, not dates")
    else:
        instants = np.array([quantities.seconds(t, f"{name}[{i}]") for i, t in enumerate(index)])
    if not len(instants):
        raise DomainError(f"{name} has no instant")
    if twice and instants[0] < 0.0:
        raise DomainError(f"{name} begins at {instants[0]:g} s, before the start")
    steps = np.diff(instants)
    falls = np.flatnonzero((steps < 0.0) if twice else (steps <= 0.0))
    if len(falls):
        here, there = instants[falls[0]], instants[falls[0] + 1]
        raise DomainError(f"{name} must rise, but {here:g} s is followed by {there:g} s")
    return np.asarray(instants, dtype=float)


def signals_of(inputs: Mapping[str, Signal] | None) -> dict[str, Function]:
    """Inputs as functions of time, looked at."""
    return {name: _signal(name, signal) for name, signal in (inputs or {}).items()}


def _signal(name: str, signal: Signal) -> Function:
    variable = VARIABLES.settable(name)
    if not variable.tunable:
        raise DomainError(f"{name} is fixed: it can be no input over time")
    if hasattr(signal, "index") and hasattr(signal, "to_numpy"):
        instants = _rising(signal.index, f"the index of {name}")
        values = np.array([variable.number(value) for value in signal])
        return lambda t: float(np.interp(t, instants, values))
    if callable(signal):
        return lambda t: variable.number(signal(t))
    number = variable.number(signal)
    return lambda _: number


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
    parts: Any = range(0, len(instants), size)
    if progress:
        parts = need("tqdm", "sweep").tqdm(parts, unit="part", leave=False)
    found = []
    for first in parts:
        part = instants[first : first + size]
        if control and part[0] > 0.0:
            move(hammer, signals, float(part[0]))
            control(hammer)
            found.append(hammer.run(part, names, {}))
        else:
            points = [hammer.time, *part]
            values = {name: np.array([s(t) for t in points]) for name, s in signals.items()}
            found.append(hammer.run(part, names, values))
    rows, blows = zip(*found, strict=True)
    return np.concatenate(rows), np.concatenate(blows)


def move(hammer: Hammer, signals: Mapping[str, Function], to: float) -> None:
    """Sets signals for one step, up to an instant."""
    now, values = hammer.time, {name: signal(hammer.time) for name, signal in signals.items()}
    hammer.set(values)
    ports = [n for n in signals if VARIABLES[n].causality == "input"]
    if to > now:
        hammer.set_slopes({n: (signals[n](to) - values[n]) / (to - now) for n in ports})


def _again(
    start: Mapping[str, float],
    signals: Mapping[str, Function],
    instants: Array,
    names: Sequence[str],
    *,
    control: Callable[[Hammer], None] | None,
    changed: Mapping[str, float],
) -> tuple[Array, Hammer]:
    """The same run of a hammer that is changed a little; inputs over time change all along."""

    def shifted(name: str, signal: Function) -> Function:
        by = changed.get(name, start[name]) - start[name]
        return lambda t: signal(t) + by

    hammer = Hammer({**start, **changed}, quiet=True, journal=True)
    moved = {name: shifted(name, signal) for name, signal in signals.items()}
    rows, _ = play(hammer, instants, moved, names, control=deepcopy(control))
    return rows, hammer


def _frame(rows: Array, variables: list[Variable], instants: Array) -> pd.DataFrame:
    import pandas as pd  # noqa: PLC0415

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


def _blows(blows: Array) -> tuple[pd.DataFrame, Array]:
    """The table of blows, and the work given to the rock before each."""
    import pandas as pd  # noqa: PLC0415

    columns = dict(zip(_native.blow_names(), blows.T, strict=True))
    index = pd.RangeIndex(1, len(blows) + 1, name="blow")
    table = _without_zeros(pd.DataFrame({name: columns[name] for name in PER_BLOW}, index=index))
    table.attrs = _attributes([VARIABLES[str(name)] for name in table])
    return table, columns["rock_work"]


def _without_zeros(table: pd.DataFrame) -> pd.DataFrame:
    """Without the rate by specific energy where hole or specific energy are not given."""
    if RATE in table and not table[RATE].any():
        return table.drop(columns=RATE)
    return table


def _attributes(variables: Iterable[Variable]) -> dict[Any, Any]:
    listed = [*variables]
    return {
        "units": Fixed({v.name: v.unit for v in listed}),
        "display_units": Fixed({v.name: v.display_unit for v in listed if v.display_unit}),
    }
