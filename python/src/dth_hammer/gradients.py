"""Exact derivatives, as the FMU carries them through every event.

What has derivatives, and by what, the FMU says in ``VendorAnnotations``; nothing of it is
written here. Derivatives since the start are asked for before it, and cost nothing otherwise.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd

from .errors import DthHammerError, UnknownNameError
from .variables import Array

if TYPE_CHECKING:
    from .instance import Instance
    from .package import Package

#: Between an output and what it is differentiated by, in the name of a table's column.
PER = " per "


@dataclass(frozen=True)
class Announced:
    """What an FMU says of its derivatives and of its stationary cycle: names and references."""

    numbers: Mapping[str, int]
    #: Constants added to inputs, since the start.
    offsets: Mapping[str, int]
    outputs: tuple[str, ...]
    #: Those of them whose derivatives are carried only if they are asked for by name.
    on_demand: tuple[str, ...]
    parameters: tuple[str, ...]
    cycle: Mapping[str, int]
    #: Numbers of the cycle that have derivatives.
    smooth: tuple[str, ...]
    settings: Mapping[str, int]
    #: Numbers of a branch's last point.
    branch: Mapping[str, int]
    #: Reference of the first multiplier's real part.
    multipliers: int

    def seed(self, package: Package, name: str) -> int:
        """The reference of a parameter, or of an input's offset."""
        if name in self.offsets:
            return self.offsets[name]
        if name not in self.parameters:
            known = [*self.parameters, *self.offsets]
            raise UnknownNameError("parameter or input with derivatives", name, known)
        return package.variables[name].reference


@lru_cache(maxsize=8)
def announced(package: Package) -> Announced:
    """What this FMU says."""
    root = ET.parse(Path(package.folder, "modelDescription.xml")).getroot()
    tool = "VendorAnnotations/Tool[@name='dth_hammer.{}']/{}"
    derivatives = root.find(tool.format("derivatives", "Derivatives"))
    cycle = root.find(tool.format("cycle", "Cycle"))
    if derivatives is None or cycle is None:
        raise DthHammerError(f"{package.path.name} knows no derivatives: it is of an older make")

    def references(node: ET.Element, kind: str) -> dict[str, int]:
        return {row.attrib["name"]: int(row.attrib["valueReference"]) for row in node.iter(kind)}

    return Announced(
        numbers=references(derivatives, "Number"),
        offsets=references(derivatives, "Offset"),
        outputs=tuple(row.attrib["name"] for row in derivatives.iter("Output")),
        on_demand=tuple(
            row.attrib["name"] for row in derivatives.iter("Output") if "onDemand" in row.attrib
        ),
        parameters=tuple(row.attrib["name"] for row in derivatives.iter("Parameter")),
        cycle=references(cycle, "Number"),
        smooth=tuple(
            row.attrib["name"]
            for row in cycle.iter("Number")
            if row.attrib["differentiable"] == "true"
        ),
        settings=references(cycle, "Setting"),
        branch=references(cycle, "Branch"),
        multipliers=int(cycle.attrib["multipliers"]),
    )


class Slopes:
    """Derivatives of some outputs by some parameters and inputs, since the start of a run."""

    def __init__(
        self,
        package: Package,
        instance: Instance,
        by: Iterable[str],
        outputs: Iterable[str] = (),
    ) -> None:
        self._told = announced(package)
        self._package, self._instance = package, instance
        #: By what, in order.
        self.by = tuple(dict.fromkeys(by))
        self._seeds = [self._told.seed(package, name) for name in self.by]
        #: Outputs that are carried because they are asked for here.
        self._asked = [self._reference(n) for n in outputs if n in self._told.on_demand]

    def announce(self) -> None:
        """Asks the FMU to carry them along; before initialization mode ends."""
        if self.by:
            unknown = [self._told.numbers["reach"], *self._asked]
            self._directional(unknown, self._seeds, [0.0] * len(self.by))

    def of(self, outputs: Iterable[str]) -> Array:
        """The derivatives now, a row an output."""
        references = [self._reference(name) for name in outputs]
        columns = [self._directional(references, [seed], [1.0]) for seed in self._seeds]
        return np.array(columns, dtype=float).reshape(len(self.by), len(references)).T

    def reach(self) -> pd.Series:
        """How far each may change before events change their order, to first order."""
        reach = [self._told.numbers["reach"]]
        found = [self._directional(reach, [seed], [1.0])[0] for seed in self._seeds]
        return pd.Series(found, index=pd.Index(self.by), name="reach", dtype=float)

    def differentiable(self, outputs: Iterable[str]) -> list[str]:
        """Those outputs that have derivatives here."""
        lost = {n for n in self._told.on_demand if self._reference(n) not in self._asked}
        return [name for name in outputs if name in self._told.outputs and name not in lost]

    def _reference(self, name: str) -> int:
        if name not in self._told.outputs:
            raise UnknownNameError("output with derivatives", name, self._told.outputs)
        return self._package.variables[name].reference

    def _directional(self, unknown: list[int], known: list[int], by: list[float]) -> list[float]:
        slave = self._instance.slave
        return list(self._instance.call(slave.getDirectionalDerivative, unknown, known, by))


def column(output: str, by: str) -> str:
    """Name of the column of a derivative."""
    return f"{output}{PER}{by}"


def gradient(frame: pd.DataFrame, *, elasticities: bool = False) -> pd.DataFrame:
    """The derivatives in a table that `simulate` made with ``gradient``.

    Args:
        frame: the table.
        elasticities: ``d ln output / d ln parameter`` instead of the derivatives.

    Returns:
        The same rows, with columns of two levels: output, and what it is differentiated by.
    """
    pairs = [tuple(str(c).split(PER)) for c in frame if PER in str(c)]
    if not pairs:
        raise DthHammerError("no derivatives in this table: simulate(..., gradient=[...])")
    table = frame[[column(*pair) for pair in pairs]].copy()
    table.columns = pd.MultiIndex.from_tuples(pairs, names=["output", "by"])
    if elasticities:
        values: Mapping[str, float] = frame.attrs["gradient"]
        for output, by in pairs:
            table[output, by] *= values[by] / frame[output]
    return table
