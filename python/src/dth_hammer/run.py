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
#: What a table of blows has.
PER_BLOW = (
    *("blow_time", "blow_period", "blow_speed", "blow_energy", "blow_penetration"),
    *("rop", "tip_rate"),
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
    table = pd.DataFrame({name: columns[name] for name in PER_BLOW}, index=index)
    table.attrs = _attributes([VARIABLES[str(name)] for name in table])
    return table, columns["rock_work"]


def _attributes(variables: Iterable[Variable]) -> dict[Any, Any]:
    listed = [*variables]
    return {
        "units": Fixed({v.name: v.unit for v in listed}),
        "display_units": Fixed({v.name: v.display_unit for v in listed if v.display_unit}),
    }
