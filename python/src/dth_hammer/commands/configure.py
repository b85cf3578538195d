"""`dth-hammer configure`: writes an FMU that starts with your parameters, for any host."""

import argparse

from ..fmu.variant import configure
from ..scene.variables import PRESETS
from .options import Call

CALL = Call(configure)


def run(options: argparse.Namespace) -> None:
    """Writes the FMU and prints the number of its start values."""
    given = CALL.given(options)
    added = configure(**given)
    scene = given["hammer"]
    started = {*scene.parameters, *(PRESETS[scene.preset].values if scene.preset else ())}
    outputs_text = f", {added} more outputs" if added else ""
    print(f"{options.out}: {len(started)} start values{outputs_text}")
