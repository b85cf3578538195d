"""`dth-hammer info`: variables, units, domains and presets."""

from __future__ import annotations

import argparse

from ..package import load
from ..variables import Variable
from . import common

HELP = "variables, units and presets"


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it takes."""
    common.add_fmu(parser)
    parser.add_argument("name", nargs="?", help="one variable only")


def run(options: argparse.Namespace) -> None:
    """Prints all variables, or one."""
    package = load(options.fmu)
    if options.name:
        rows = [package.variables[options.name]]
    else:
        print(f"{package.description.modelName} {package.version}\n{package.path}\n")
        for preset in package.presets.values():
            print(f"preset {preset.name}: {preset.description}")
            print("".join(f"    {k} = {v:g}\n" for k, v in preset.values.items()), end="")
        print()
        rows = list(package.variables.values())
    for variable in rows:
        kind = "tunable " if variable.tunable and variable.causality == "parameter" else ""
        print(f"{variable.name}{_start(variable)}")
        domain = f", {variable.domain()}" if variable.settable else ""
        print(f"    {kind}{variable.causality}: {variable.description}{domain}")
    for name, family in () if options.name else package.variables.families.items():
        print(f"{name}[i] {family.variable(1).unit}")
        print(f"    when asked for: {family.description}")


def _start(variable: Variable) -> str:
    if variable.start is None:
        return "" if variable.unit in ("", "1") else f" {variable.unit}"
    label = variable.labels.get(int(variable.start))
    return f" = {label or variable.shown(variable.start)}"
