"""A live hammer: one instance of the FMU, variables by name, states to go back to."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from ctypes import c_double, c_uint
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn

from . import doubts, quantities
from .errors import ClosedError, DomainError
from .gradients import Slopes
from .instance import Instance, warn
from .package import Package, load
from .variables import Value, Variable

#: What a notebook shows of a hammer.
SHOWN = ("blow_count", "blow_energy", "blow_period", "rop", "hole_depth")


class Snapshot:
    """A state of a hammer at an instant; stays valid until it is forgotten or the hammer closed."""

    def __init__(self, hammer: Hammer, state: Any) -> None:
        #: The instant, s.
        self.time = hammer.time
        self._hammer, self._state = hammer, state

    @property
    def state(self) -> Any:
        """The FMU's handle of it."""
        if self._state is None or self._hammer.closed:
            raise ClosedError("this snapshot is gone: its hammer is closed, or it was forgotten")
        return self._state

    def __repr__(self) -> str:
        return f"<Snapshot at {self.time:g} s>"

    def _forget(self) -> None:
        self._state = None


class Reader:
    """Reads the same variables again and again, without naming them again."""

    def __init__(self, instance: Instance, variables: list[Variable]) -> None:
        self._call, self._slave, self.variables = instance.call, instance.slave, variables
        real = [v.reference for v in variables if v.kind == "Real"]
        self._count = len(real)
        self._references = (c_uint * len(real))(*real)
        self._values = (c_double * len(real))()
        self._only_real = len(real) == len(variables)
        self.names = [v.name for v in variables]

    def __call__(self) -> list[float]:
        """Values in the order of the variables, all as numbers."""
        if self._count:
            slave = self._slave
            self._call(
                slave.fmi2GetReal, slave.component, self._references, self._count, self._values
            )
        if self._only_real:
            return list(self._values)
        reals = iter(self._values)
        return [next(reals) if v.kind == "Real" else self._discrete(v) for v in self.variables]

    def named(self) -> dict[str, float]:
        """Values by name; what counts things is an int."""
        numbers = zip(self.variables, self(), strict=True)
        return {v.name: int(number) if v.counts else number for v, number in numbers}

    def _discrete(self, variable: Variable) -> float:
        slave = self._slave
        get = slave.getBoolean if variable.kind == "Boolean" else slave.getInteger
        return float(self._call(get, [variable.reference])[0])


class Hammer:
    """A hammer from its initialisation to its end; use it in a ``with`` block.

    ``messages`` has what the FMU has logged of warnings and errors; ``doubts`` what was
    warned of, by the FMU or by this package.

    Args:
        parameters: by dotted name: a number in the declared unit, a label of an
            enumeration, or text with a unit (``"60 mm"``); inputs too. What is not given is
            the FMU's own start value.
        preset: parameter set to start from.
        fmu: file to use instead of the one found.
        quiet: collects doubts and warns of none.
        gradient: parameters and inputs by which derivatives are carried along, see `slopes`.
        gradient_of: outputs among the energies, impulses and peaks whose derivatives are
            wanted: these are carried for who asks only.
    """

    def __init__(
        self,
        parameters: Mapping[str, Value] | None = None,
        *,
        preset: str | None = None,
        fmu: str | Path | Package | None = None,
        quiet: bool = False,
        gradient: Iterable[str] = (),
        gradient_of: Iterable[str] = (),
    ) -> None:
        self.package = load(fmu)
        self.variables = self.package.variables
        self.time = 0.0
        self.doubts: list[str] = []
        self._quiet = quiet
        self._initial = self.package.values(preset, parameters)
        self._snapshots: list[Snapshot] = []
        self._looked: tuple[Any, dict[str, str], set[str], str] | None = None
        self._ignored: dict[str, str] = {}
        self._needed: set[str] = set()
        self._starving = ""
        self._instance = Instance(self.package, self._doubt)
        self._slave, self._call = self._instance.slave, self._instance.call
        self.messages = self._instance.log.messages
        count = self.package.journal.count
        self._blow_count = Reader(self._instance, [count] if count else [])
        try:
            by, of = [*gradient], [*gradient_of]
            self._slopes = Slopes(self.package, self._instance, by, of) if by else None
            self._begin()
        except BaseException:
            self.close()
            raise

    def set(self, values: Mapping[str, Value] | None = None, /, **inputs: Value) -> None:
        """Sets inputs and tunable parameters, from this communication point on."""
        for name, value in {**(values or {}), **inputs}.items():
            variable = self.variables.settable(name)
            if not variable.tunable:
                raise DomainError(f"{name} is fixed: give it when the hammer is made")
            self._write({name: variable.number(value)})
            if name in self._ignored:
                self._doubt(self._ignored.pop(name))
            if name in self._needed:
                self._starving = ""

    def set_slopes(self, slopes: Mapping[str, float]) -> None:
        """First time derivatives of inputs, for the next step."""
        references = [self.variables.settable(name).reference for name in slopes]
        self._call(
            self._slave.setRealInputDerivatives, references, [1] * len(slopes), [*slopes.values()]
        )

    def get(self, names: Iterable[str]) -> dict[str, float]:
        """Several variables as numbers; what counts things is an int."""
        return self.reader(names).named()

    def step_blows(self) -> dict[str, list[float]]:
        """All blows of the last step: instants, speeds and so on, a list each, in order.

        No list at all if the FMU tells none of them.
        """
        journal = self.package.journal
        number = int(self._blow_count()[0]) if journal else 0
        if not number:
            return {name: [] for name in journal}
        return {name: Reader(self._instance, journal.of(name, number))() for name in journal}

    def __getitem__(self, name: str) -> float:
        """One variable as a number."""
        return self.get([name])[name]

    @property
    def slopes(self) -> Slopes:
        """Exact derivatives since the start, by what ``gradient`` named."""
        if self._slopes is None:
            raise DomainError("no derivatives are carried along: Hammer(..., gradient=[...])")
        return self._slopes

    def rate(self, name: str) -> float:
        """Time derivative of an output, in its unit per s."""
        reference = self.variables[name].reference
        return float(self._call(self._slave.getRealOutputDerivatives, [reference], [1])[0])

    def label(self, name: str) -> str:
        """An enumeration's value by its name."""
        return self.variables[name].labels[int(self[name])]

    def reader(self, names: Iterable[str]) -> Reader:
        """A fast reader of the same variables at every step."""
        return Reader(self._instance, [self.variables[name] for name in names])

    def step(self, size: float | str) -> float:
        """One communication step; returns the new time. Text may carry a unit."""
        size = size if isinstance(size, float) else quantities.seconds(size, "the step")
        self._step(size)
        self.time += size
        return self.time

    def advance(self, to: float | str) -> float:
        """One communication step up to an instant. Text may carry a unit."""
        to = to if isinstance(to, float) else quantities.seconds(to, "the instant")
        self._step(to - self.time)
        self.time = to
        return to

    def save(self) -> Snapshot:
        """The state now, to be restored later in this hammer or forgotten."""
        snapshot = Snapshot(self, self._call(self._slave.getFMUstate))
        self._snapshots.append(snapshot)
        return snapshot

    def restore(self, snapshot: Snapshot) -> None:
        """Goes back to a saved state; the snapshot can be used again."""
        self._call(self._slave.setFMUstate, snapshot.state)
        self.time = snapshot.time

    def forget(self, snapshot: Snapshot) -> None:
        """Frees a snapshot's memory."""
        if snapshot not in self._snapshots:
            raise ClosedError("no snapshot of this hammer, or one that was forgotten before")
        self._snapshots.remove(snapshot)
        self._call(self._slave.freeFMUstate, snapshot.state)
        snapshot._forget()

    def dump(self) -> bytes:
        """The state as bytes, to be loaded in another process."""
        snapshot = self.save()
        try:
            return bytes(self._call(self._slave.serializeFMUstate, snapshot.state))
        finally:
            self.forget(snapshot)

    def load(self, data: bytes, time: float) -> None:
        """Continues from bytes that were dumped at an instant."""
        if not isinstance(data, bytes):
            raise DomainError(f"a state is loaded from bytes, not from {type(data).__name__}")
        state = self._call(self._slave.deSerializeFMUstate, data)
        try:
            self._call(self._slave.setFMUstate, state)
        finally:
            self._call(self._slave.freeFMUstate, state)
        self.time = time

    def reset(self, parameters: Mapping[str, Value] | None = None) -> None:
        """Starts anew at time 0, with the parameters it had and these laid over them."""
        self._initial |= self.package.values(None, parameters)
        self._call(self._slave.reset)
        self._begin()

    def restart(self, numbers: Mapping[str, float]) -> None:
        """Starts anew at time 0 as one just made with these numbers, which were checked before.

        Of what was logged and doubted nothing stays.
        """
        self._initial = dict(numbers)
        self.doubts.clear()
        self.messages.clear()
        self._call(self._slave.reset)
        self._begin()

    def close(self) -> None:
        """Frees the instance; a second call does nothing. Any other use is then an error."""
        self._instance.close([snapshot.state for snapshot in self._snapshots if not self.closed])
        self._snapshots.clear()

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return not self._instance.is_open

    def __repr__(self) -> str:
        state = "closed" if self.closed else f"at {self.time:g} s"
        return f"<Hammer {state}, {len(self._initial)} parameters set, {self.package.path.name}>"

    def _repr_html_(self) -> str:
        """For notebooks: where it is, and what it has drilled."""
        if self.closed:
            return f"<p>{html.escape(repr(self))}</p>"
        rows = [("time", f"{self.time:g} s")]
        rows += [(name, self.variables[name].shown(self[name])) for name in SHOWN]
        cells = "".join(f"<tr><td>{name}</td><td>{value}</td></tr>" for name, value in rows)
        return f"<table>{cells}</table>"

    def __reduce__(self) -> NoReturn:
        """An instance lives in one process, and only once."""
        raise TypeError("a hammer is neither copied nor pickled: carry its state by dump and load")

    def __enter__(self) -> Hammer:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.close()

    def _begin(self) -> None:
        self._call(self._slave.setupExperiment, startTime=0.0)
        self._write(self._initial)
        self._look_for_doubts()
        self._call(self._slave.enterInitializationMode)
        if self._slopes:
            self._slopes.announce()
        self._call(self._slave.exitInitializationMode)
        self.time = 0.0

    def _look_for_doubts(self) -> None:
        # Runs of a sweep differ by numbers that decide nothing here.
        deciding = (tuple(self._initial), *map(self._initial.get, doubts.DECIDING))
        if self._looked is None or self._looked[0] != deciding:
            found = doubts.ignored(self.variables, self._initial)
            needed, starving = doubts.missing(self.variables, self._initial)
            starves = needed and not needed & {*self._initial}
            self._looked = deciding, found, needed, starving if starves else ""
        self._ignored = dict(self._looked[1])
        self._needed, self._starving = self._looked[2:]
        for name in self._initial:
            if name in self._ignored:
                self._doubt(self._ignored.pop(name))

    def _step(self, size: float) -> None:
        if self._starving:
            self._doubt(self._starving)
            self._starving = ""
        self._call(self._slave.doStep, self.time, size)

    def _doubt(self, text: str) -> None:
        if text in self.doubts:
            return
        self.doubts.append(text)
        if not self._quiet:
            warn(text)

    def _write(self, numbers: Mapping[str, float]) -> None:
        """Sets numbers of any kind, with a call a kind."""
        real: list[tuple[int, float]] = []
        whole: list[tuple[int, int]] = []
        for name, number in numbers.items():
            variable = self.variables[name]
            if variable.kind == "Real":
                real.append((variable.reference, number))
            else:
                whole.append((variable.reference, int(number)))
        if real:
            self._call(self._slave.setReal, *zip(*real, strict=True))
        if whole:
            self._call(self._slave.setInteger, *zip(*whole, strict=True))
