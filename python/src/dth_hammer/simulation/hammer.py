"""A running hammer: variables by name, steps, saved states."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from typing import NoReturn

from .. import _native
from .._native import Snapshot
from ..contract import typed
from ..errors import ClosedError, DomainError, warn
from ..scene import quantities
from ..scene.hammers import Hammerlike, Rocklike, numbers_of
from ..scene.signals import Function
from ..scene.variables import VARIABLES, Array, Value, Variable, numbers

SHOWN = ("blow_count", "blow_energy", "blow_period", "rop", "tip_depth")


class Reader:
    """Reads the same variables at every step without looking up their names."""

    def __init__(self, hammer: Hammer, variables: Iterable[Variable]) -> None:
        self._hammer, self.variables = hammer, [*variables]
        self.names = [v.name for v in self.variables]
        self._selection = _native.Selection(self.names)

    def __call__(self) -> list[float]:
        """Returns the values in the order of the variables, all as numbers."""
        return self._hammer.machine.read(self._selection)

    def named(self) -> dict[str, float]:
        """Returns values by name; counters are ints."""
        found = zip(self.variables, self(), strict=True)
        return {v.name: int(number) if v.counts else number for v, number in found}


@typed()
class Hammer:
    """A running hammer; use it in a ``with`` block, which closes it.

    Several threads may use it; their calls take turns. ``warnings`` lists the warnings so far, also
    about energy created by the exchange with an outside model (``energy_exchange``).

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        quiet: collects warnings without raising them.
        journal: stores all events, for derivatives.
        record: completes each blow's record: rebound, largest forces and works in `step_blows`.

    Example:
        >>> from dth_hammer import Hammer
        >>> with Hammer({"feed_force": "6 kN"}, rock="granite") as hammer:
        ...     hammer.advance("200 ms")
        ...     hammer.set({"feed_force": "8 kN"})
        ...     hammer.advance("300 ms")
        ...     print(hammer["blow_count"], "blows")
        0.2
        0.3
        7 blows
    """

    def __init__(
        self,
        hammer: Hammerlike = None,
        *,
        preset: str | None = None,
        rock: Rocklike = None,
        quiet: bool = False,
        journal: bool = False,
        record: bool = False,
    ) -> None:
        self.warnings: list[str] = []
        self._quiet, self._journal, self._record = quiet, journal, record
        self._machine: _native.Machine | None = None
        self._start(numbers_of(hammer, preset, rock))

    @property
    def machine(self) -> _native.Machine:
        """Returns the engine of a hammer that is not closed."""
        if self._machine is None:
            raise ClosedError("this hammer is closed: read its values before, or make another")
        return self._machine

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers that were set at the start, by name, in SI units."""
        return dict(self._initial)

    @property
    def time(self) -> float:
        """Present time, s."""
        return self.machine.time

    def set(self, values: Mapping[str, Value] | None = None, /, **inputs: Value) -> None:
        """Sets inputs and tunable parameters, from this communication point on."""
        checked = {}
        for name, value in {**(values or {}), **inputs}.items():
            variable = VARIABLES.settable(name)
            if not variable.tunable:
                raise DomainError(f"{name} is fixed: give it when the hammer is made")
            checked[name] = variable.number(value)
        self.machine.set(checked)
        self._note_first(checked)

    def set_slopes(self, slopes: Mapping[str, float | Sequence[float]]) -> None:
        """Sets time derivatives of inputs from now on: the first, or up to the first four."""
        for name, slope in slopes.items():
            derivatives = [slope] if isinstance(slope, (int, float)) else slope
            self.machine.set_derivatives(VARIABLES.settable(name).name, [*map(float, derivatives)])

    def move(self, signals: Mapping[str, Function], to: float) -> None:
        """Sets inputs over time for one step that ends at an instant."""
        now, values = self.time, {name: signal(self.time) for name, signal in signals.items()}
        self.set(values)
        ports = [n for n in signals if VARIABLES[n].causality == "input"]
        if to > now:
            self.set_slopes({n: (signals[n](to) - values[n]) / (to - now) for n in ports})

    def get(self, names: Iterable[str]) -> dict[str, float]:
        """Returns several variables as numbers; counters are ints."""
        return self.reader(names).named()

    def __getitem__(self, name: str) -> float:
        """Returns a variable as a number."""
        return self.get([name])[name]

    def reader(self, names: Iterable[str]) -> Reader:
        """Returns a function that reads the same variables quickly at every step."""
        return Reader(self, [VARIABLES[name] for name in names])

    def rate(self, name: str) -> float:
        """Returns the time derivative of an output, in its unit per second."""
        return self.machine.rate(VARIABLES[name].name)

    def label(self, name: str) -> str:
        """Returns the label of an enumeration's present value."""
        return VARIABLES[name].labels[int(self[name])]

    def step_blows(self) -> dict[str, list[float]]:
        """Returns all blows of the last step in order: a list of times, of speeds and so on."""
        columns = self.machine.step_blows().T.tolist()
        names = [name for name, *_ in _native.BLOW]
        return dict(zip(names, columns or [[] for _ in names], strict=True))

    def step(self, size: float | str) -> float:
        """Makes one communication step and returns the new time; text may carry a unit.

        The new time is earlier than asked for if `stop_at` ends the step.
        """
        size = size if isinstance(size, float) else quantities.seconds(size, "the step")
        return self.advance(self.time + size)

    def advance(self, to: float | str) -> float:
        """Makes one communication step to a given time; text may carry a unit."""
        to = to if isinstance(to, float) else quantities.seconds(to, "the instant")
        self._note_first(stepped=to > self.time)
        reached = self.machine.advance(to)
        self._note_news()
        return reached

    def stop_at(self, positions: Iterable[float | str] = (), *, blows: bool = False) -> None:
        """From now on, ends each step where the piston passes a position in either direction.

        The instant is exact to rounding: ``relative_position`` is then that position or just
        beyond. The stops do not change the motion, not even in the last binary digit.

        Args:
            positions: positions of the piston above the bit, m, or text with a unit; none for whole
                steps.
            blows: also ends a step at each blow, exactly at ``blow_time``.
        """
        position = VARIABLES["relative_position"]
        self.machine.stop_at([position.number(at) for at in positions], blows)

    def run(
        self, times: Array, names: Sequence[str], signals: Mapping[str, Array]
    ) -> tuple[Array, Array]:
        """Steps through a list of instants; returns rows of the named outputs, and all blows.

        A signal is the name of an input or tunable parameter, with its values now and at each
        instant. Other threads run meanwhile; Ctrl-C ends the run.
        """
        self._note_first(signals, stepped=True)
        found = self.machine.run(times, _native.Selection([*names]), dict(signals))
        self._note_news()
        return found

    def save(self) -> Snapshot:
        """Returns the present state, for any hammer with the same parameters; it can be pickled."""
        return self.machine.snapshot()

    def restore(self, snapshot: Snapshot) -> None:
        """Restores a saved state; the snapshot can be used again.

        A snapshot from another process comes as bytes: ``Snapshot.from_bytes(data)``.
        """
        if not isinstance(snapshot, Snapshot):
            raise DomainError(f"a state to restore is a Snapshot, not {type(snapshot).__name__}")
        self.machine.restore(snapshot)

    def reset(self, parameters: Mapping[str, Value] | None = None) -> None:
        """Restarts at time 0, with the given parameters changed."""
        _ = self.machine
        self._start(self._initial | numbers(None, parameters))

    def _start(self, checked: Mapping[str, float]) -> None:
        self._machine = _native.Machine(dict(checked), self._journal, self._record)
        self._initial, self._set, self._stepped = dict(checked), set[str](), False
        self._note(self._machine.warnings())
        self._note_first(checked)

    def check(self) -> None:
        """Adds present warnings to ``warnings``, for instance of a blow that is too fast."""
        self._note(self.machine.warnings())

    def close(self) -> None:
        """Frees the engine; a second call does nothing. Any other use is then an error."""
        self._machine = None

    @property
    def closed(self) -> bool:
        """Whether the hammer has been closed."""
        return self._machine is None

    def _note_first(self, names: Iterable[str] = (), *, stepped: bool = False) -> None:
        """Warns of doubtful settings when something is set, or a step made, for the first time."""
        if not self._set.issuperset(names) or stepped > self._stepped:
            self._set.update(names)
            self._stepped |= stepped
            self._note(_native.diagnostics(self._initial, [*self._set], self._stepped))

    def _note_news(self) -> None:
        """Warns if the exchange with an outside model now creates more energy than before."""
        if news := self.machine.news():
            self._note([news])

    def _note(self, found: Iterable[str]) -> None:
        for text in found:
            if text not in self.warnings:
                self.warnings.append(text)
                if not self._quiet:
                    warn(text)

    def __repr__(self) -> str:
        state = "closed" if self.closed else f"at {self.time:g} s"
        return f"<Hammer {state}, {len(self._initial)} parameters set>"

    def _repr_html_(self) -> str:
        """Returns HTML for notebooks: time, blows and hole."""
        if self.closed:
            return f"<p>{html.escape(repr(self))}</p>"
        rows = [("time", f"{self.time:g} s")]
        rows += [(name, VARIABLES[name].text(self[name])) for name in SHOWN]
        cells = "".join(f"<tr><td>{name}</td><td>{value}</td></tr>" for name, value in rows)
        return f"<table>{cells}</table>"

    def __reduce__(self) -> NoReturn:
        """Raises an error: an engine can be neither copied nor moved to another process."""
        raise TypeError("a hammer cannot be copied or pickled: use its methods save and restore")

    def __enter__(self) -> Hammer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
