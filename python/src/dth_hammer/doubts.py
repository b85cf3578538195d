"""What is accepted but is likely not meant: told once, as a warning.

What the FMU itself finds doubtful it logs, and `instance` passes that on as a warning too. Of
an ignored input, or a drive that gets none, both know: in the same words, so it is told once.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from .variables import Variables

SOURCE = "drive.source"
SECTION = re.compile(r"segment\[(\d+)\]\.\w+")
#: What only some sources of the drive read.
READ_BY: Mapping[str, tuple[str, ...]] = {
    "drive.amplitude": ("Relay",),
    "drive.stroke": ("Relay",),
    "drive_force": ("Force",),
    "drive_pressure": ("Pressure",),
    "return_pressure": ("Pressure",),
    "drive.area_drive": ("Pressure", "Chambers"),
    "drive.area_return": ("Pressure", "Chambers"),
}
#: By whose numbers all of this is decided, beside what is set at all.
DECIDING = (SOURCE, "piston.segments", "bit.segments")
#: How the names of what only chambers read begin.
CHAMBERS = "chambers."


def source(variables: Variables, numbers: Mapping[str, float]) -> str:
    """The label of the drive's source."""
    variable = variables[SOURCE]
    return variable.labels[int(numbers.get(SOURCE, variable.start or 1.0))]


def ignored(variables: Variables, numbers: Mapping[str, float]) -> dict[str, str]:
    """What the drive's source and the bodies do not read, and the sentence that says so."""
    chosen = source(variables, numbers)
    read_by = {**READ_BY, **{n: ("Chambers",) for n in numbers if n.startswith(CHAMBERS)}}
    found = {
        name: f"{name} is ignored: {SOURCE} is {chosen}, and only {_who(readers)} it"
        for name, readers in read_by.items()
        if chosen not in readers
    }
    for name in numbers:
        told = _of_section(variables, numbers, name)
        if told:
            found[name] = told
    return found


def _who(readers: tuple[str, ...]) -> str:
    """The readers as a sentence's subject, with its verb."""
    return " and ".join(readers) + (" reads" if len(readers) == 1 else " read")


def _of_section(variables: Variables, numbers: Mapping[str, float], name: str) -> str:
    """What a body of sections does not read of itself."""
    body, _, rest = name.partition(".")
    count = f"{body}.segments"
    if count not in variables:
        return ""
    sections = int(numbers.get(count, variables[count].start or 0.0))
    match = SECTION.fullmatch(rest)
    if match and int(match[1]) > sections:
        return f"{name} is ignored: {count} is {sections}"
    if rest == "length" and sections:
        return f"{name} is ignored: {count} is {sections}, and each section has its length"
    return ""


def missing(variables: Variables, numbers: Mapping[str, float]) -> tuple[set[str], str]:
    """The inputs of which the chosen source needs one, and the sentence if it got none."""
    chosen = source(variables, numbers)
    inputs = {v.name for v in variables.of("input")}
    needed = [name for name, readers in READ_BY.items() if chosen in readers and name in inputs]
    names = " or ".join(needed)
    return set(needed), f"{SOURCE} is {chosen}, but nothing sets {names}: the piston is not driven"
