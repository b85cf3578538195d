"""`dth-hammer info`: lists variables, units, domains and presets."""

import argparse
import re

from ..fmu.package import load, provenance
from ..scene.variables import PRESETS, VARIABLES, Variable, model
from .options import Call, Written

CALL = Call(load)


ALSO = (Written("name", nargs="?", help="a variable, or a group: rock, air, outputs"),)


def run(options: argparse.Namespace) -> None:
    """Prints all presets and groups, or the variables of one group, or one variable."""
    if not options.name:
        print(f"{model()}\n{provenance(**CALL.given(options))}\n")
        for preset in PRESETS.values():
            print(f"preset {preset.name}: {preset.description}")
            print("".join(f"    {k} = {v:g}\n" for k, v in preset.values.items()), end="")
        print()
        for group, variables in _groups().items():
            names = (variable.name.removeprefix(f"{group}.") for variable in variables)
            print(f"{group}: {', '.join(dict.fromkeys(re.sub(r'[0-9]+', 'i', n) for n in names))}")
        families = ", ".join(f"{name}[i]" for name in VARIABLES.families)
        print(
            f"along the bodies: {families}\n`dth-hammer info NAME` tells of a group or a variable"
        )
        return
    for variable in _groups().get(options.name) or [VARIABLES[options.name]]:
        kind = "tunable " if variable.tunable and variable.causality == "parameter" else ""
        print(f"{variable.name}{_start(variable)}")
        domain = f", {variable.domain()}" if variable.settable else ""
        print(f"    {kind}{variable.causality}: {variable.description}{domain}")


def _groups() -> dict[str, list[Variable]]:
    """Returns the variables by group.

    The group of a name with a dot is the part before it; of any other name, its causality.
    """
    groups: dict[str, list[Variable]] = {}
    for variable in VARIABLES.values():
        group, dot, _ = variable.name.partition(".")
        groups.setdefault(group if dot else f"{variable.causality}s", []).append(variable)
    return groups


def _start(variable: Variable) -> str:
    if variable.start is None:
        return "" if variable.unit in ("", "1") else f" {variable.unit}"
    return f" = {variable.text(variable.start)}"
