"""`dth-hammer info`: lists variables, units, domains and presets."""

from __future__ import annotations

import argparse

from ..errors import FmuNotFoundError
from ..fmu.package import load
from ..scene.variables import PRESETS, VARIABLES, Variable, model
from .options import Call

CALL = Call(load)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the name."""
    parser.add_argument("name", nargs="?", help="one variable only")


def run(options: argparse.Namespace) -> None:
    """Prints all variables, or one."""
    if options.name:
        rows = [VARIABLES[options.name]]
    else:
        print(f"{model()}\n{_fmu(options)}\n")
        for preset in PRESETS.values():
            print(f"preset {preset.name}: {preset.description}")
            print("".join(f"    {k} = {v:g}\n" for k, v in preset.values.items()), end="")
        print()
        rows = list(VARIABLES.values())
    for variable in rows:
        kind = "tunable " if variable.tunable and variable.causality == "parameter" else ""
        print(f"{variable.name}{_start(variable)}")
        domain = f", {variable.domain()}" if variable.settable else ""
        print(f"    {kind}{variable.causality}: {variable.description}{domain}")
    for name, family in () if options.name else VARIABLES.families.items():
        print(f"{name}[i] {family.unit}")
        print(f"    when asked for: {family.description}")


def _fmu(options: argparse.Namespace) -> str:
    try:
        package = load(**CALL.given(options))
        return f"{package.name} {package.version}\n{package.path}"
    except FmuNotFoundError as error:
        return str(error)


def _start(variable: Variable) -> str:
    if variable.start is None:
        return "" if variable.unit in ("", "1") else f" {variable.unit}"
    label = variable.labels.get(int(variable.start))
    return f" = {label or variable.text(variable.start)}"
