"""`dth-hammer system`: writes a hammer and its drive as one SSP file."""

import argparse

from ..fmu.system import write_system
from .options import Call, Written, assignments

NEEDS = ("fmpy",)
CALL = Call(
    write_system,
    partners=Written(
        "--partner",
        assignments,
        help="another FMU and its name in the system, for instance drive=drive.fmu; repeatable",
        action="append",
        metavar="NAME=FILE",
    ),
)


def run(options: argparse.Namespace) -> None:
    """Writes the system and prints its connections and the settings that were chosen."""
    connected = write_system(**CALL.given(options))
    for (giver, output), (taker, taken) in connected:
        print(f"{giver}.{output} -> {taker}.{taken}")
    if connected.chosen:
        print(connected.chosen)
