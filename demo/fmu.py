"""An instance of the FMU, its variables by name."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import TracebackType

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.model_description import ModelDescription, ScalarVariable
from fmpy.simulation import instantiate_fmu

Value = float | int | bool | str
Logger = Callable[..., None]

# fmpy hands C one logger for the whole process: a logger must outlive its instance, also
# one that was refused (then the error's traceback holds it).
_ALIVE: list[object] = []


class Package:
    """An .fmu file unpacked to a temporary folder; as many instances as wanted."""

    def __init__(self, path: Path | str) -> None:
        self.description: ModelDescription = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.variables = {v.name: v for v in self.description.modelVariables}

    def names(self, causality: str) -> list[str]:
        """Names of all variables of one causality."""
        return [n for n, v in self.variables.items() if v.causality == causality]

    def start(self, name: str) -> float:
        """Start value of a number, as the model description gives it."""
        return float(self.variables[name].start)

    def labels(self, name: str) -> dict[int, str]:
        """Names of an enumeration's values."""
        items = self.variables[name].declaredType.items
        return {int(item.value): item.name for item in items}

    def __enter__(self) -> Package:
        return self

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)


class Instance:
    """One hammer, from its initialisation to its end; use it in a `with` block."""

    def __init__(
        self,
        package: Package,
        values: Mapping[str, Value] | None = None,
        *,
        logger: Logger | None = None,
    ) -> None:
        self.package, self.time = package, 0.0
        try:
            self.slave: FMU2Slave = instantiate_fmu(
                package.folder,
                package.description,
                "CoSimulation",
                logger=logger,
                debug_logging=logger is not None,
            )
        except Exception as error:
            _ALIVE.append(error)
            raise
        _ALIVE.append(self.slave.callbacks)
        try:
            self.begin(values or {})
        except FMICallException:
            self.slave.freeInstance()
            raise

    def begin(self, values: Mapping[str, Value]) -> None:
        """From instantiated (or reset) to the first communication point, 0."""
        self.slave.setupExperiment(startTime=0.0)
        for name, value in values.items():
            self.set(name, value)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.time = 0.0

    def set(self, name: str, value: Value) -> None:
        """Sets a parameter or an input; an enumeration by the name of its value."""
        variable = self.package.variables[name]
        reference = [variable.valueReference]
        if variable.type == "Real":
            self.slave.setReal(reference, [float(value)])
        elif variable.type == "Boolean":
            self.slave.setBoolean(reference, [bool(value)])
        else:
            if isinstance(value, str):
                labels = self.package.labels(name)
                value = next(v for v, label in labels.items() if label == value)
            self.slave.setInteger(reference, [int(value)])

    def get(self, name: str) -> float:
        """One variable as a number."""
        return self.read([name])[0]

    def read(self, names: Iterable[str]) -> list[float]:
        """Several variables, as numbers."""
        variables = [self.package.variables[name] for name in names]
        real = [v.valueReference for v in variables if v.type == "Real"]
        reals = iter(self.slave.getReal(real))
        return [next(reals) if v.type == "Real" else self._discrete(v) for v in variables]

    def _discrete(self, variable: ScalarVariable) -> float:
        get = self.slave.getBoolean if variable.type == "Boolean" else self.slave.getInteger
        return float(get([variable.valueReference])[0])

    def advance(self, to: float) -> None:
        """One communication step, up to the given time."""
        self.slave.doStep(self.time, to - self.time)
        self.time = to

    def __enter__(self) -> Instance:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        # Only a run that went well may be terminated; any may be freed.
        if kind is None:
            self.slave.terminate()
        self.slave.freeInstance()
