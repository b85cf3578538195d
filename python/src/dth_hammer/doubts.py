"""What is accepted but is likely not meant: told once, as a warning.

What the FMU itself finds doubtful it logs, and `instance` passes that on as a warning too. Of
an ignored input, or a drive that gets none, both know: in the same words, so it is told once.
"""

from __future__ import annotations

from collections.abc import Mapping

from .variables import Variables

SOURCE = "drive.source"
#: What only some sources of the drive read.
READ_BY: Mapping[str, tuple[str, ...]] = {
    "drive.amplitude": ("Relay",),
    "drive.stroke": ("Relay",),
    "drive_force": ("Force",),
    "drive_pressure": ("Pressure",),
    "return_pressure": ("Pressure",),
    "drive.area_drive": ("Pressure",),
    "drive.area_return": ("Pressure",),
}


def source(variables: Variables, numbers: Mapping[str, float]) -> str:
    """The label of the drive's source."""
    variable = variables[SOURCE]
    return variable.labels[int(numbers.get(SOURCE, variable.start or 1.0))]


def ignored(variables: Variables, numbers: Mapping[str, float]) -> dict[str, str]:
    """What the chosen source of the drive does not read, and the sentence that says so."""
    chosen = source(variables, numbers)
    return {
        name: f"{name} is ignored: {SOURCE} is {chosen}, and only {' and '.join(readers)} reads it"
        for name, readers in READ_BY.items()
        if chosen not in readers
    }


def missing(variables: Variables, numbers: Mapping[str, float]) -> tuple[set[str], str]:
    """The inputs of which the chosen source needs one, and the sentence if it got none."""
    chosen = source(variables, numbers)
    inputs = {v.name for v in variables.of("input")}
    needed = [name for name, readers in READ_BY.items() if chosen in readers and name in inputs]
    names = " or ".join(needed)
    return set(needed), f"{SOURCE} is {chosen}, but nothing sets {names}: the piston is not driven"
