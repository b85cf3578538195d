"""The blows of each communication step, as the FMU itself tells them.

Outputs have the last blow only, so a step with two would hide one. The FMU answers for all of a
step at reserved value references, which its description announces in ``VendorAnnotations``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pandas as pd

from . import quantities
from .variables import Variable

#: Where a table of a run keeps its journal, among its attributes: a list per quantity, in SI units.
KEY = "blows"
NODE = "VendorAnnotations/Tool[@name='dth_hammer.blows']/Blows"
PREFIX = "step_"


class Journal(Mapping[str, Variable]):
    """Figures of the first blow of a step, by the output that has the last one's.

    Those of the next blows follow at the next value references. Empty if the FMU tells none.
    """

    def __init__(self, description: Path) -> None:
        node = ET.parse(description).getroot().find(NODE)
        #: How many blows the last step had; None if the FMU does not tell.
        self.count = None if node is None else _variable(node.attrib)
        rows = [] if node is None else [_variable(row.attrib) for row in node.iter("Family")]
        self._table = {variable.name.removeprefix(PREFIX): variable for variable in rows}

    def __getitem__(self, name: str) -> Variable:
        """The first blow's."""
        return self._table[name]

    def __iter__(self) -> Iterator[str]:
        """Names in the order of the description."""
        return iter(self._table)

    def __len__(self) -> int:
        """How many figures a blow has."""
        return len(self._table)

    def of(self, name: str, number: int) -> list[Variable]:
        """One figure of the first blows."""
        first = self[name]
        return [replace(first, reference=first.reference + i) for i in range(number)]

    def attributes(self, kept: Mapping[str, list[float]]) -> dict[str, Any]:
        """What a run's table keeps of its blows."""
        shown = {name: v.display_unit for name, v in self.items() if v.display_unit}
        units = {name: v.unit for name, v in self.items()}
        return {"values": dict(kept), "units": units, "display_units": shown}


def _variable(row: Mapping[str, str]) -> Variable:
    return Variable(
        name=row["name"],
        reference=int(row.get("valueReference") or row["firstValueReference"]),
        kind="Real",
        causality="output",
        variability="discrete",
        description=row["description"],
        unit=row["unit"],
        display_unit=row.get("displayUnit", ""),
    )


def table(frame: pd.DataFrame, order: Iterable[str]) -> pd.DataFrame:
    """The blows of a run's table, or of what is left of it; numbered from the start of the run."""
    told = frame.attrs[KEY]
    rows = pd.DataFrame({name: told["values"][name] for name in order if name in told["values"]})
    rows.index = pd.RangeIndex(1, len(rows) + 1, name="blow")
    first, last = (frame.index[0], frame.index[-1]) if len(frame) else (0.0, -1.0)
    # What falls at the first row belongs to the step before it, if there was one.
    after = rows["blow_time"] > first if first > 0.0 else rows["blow_time"] >= 0.0
    rows = rows[after & (rows["blow_time"] <= last)].copy()
    rows.attrs = {key: value for key, value in frame.attrs.items() if key not in (KEY, "si_units")}
    rows.attrs |= {
        key: {name: told[key][name] for name in rows if name in told[key]}
        for key in ("units", "display_units")
    }
    chosen = {name: unit for name, unit in frame.attrs["units"].items() if name in rows}
    return quantities.convert(rows, chosen)
