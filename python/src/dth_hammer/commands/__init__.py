"""The subcommands of `dth-hammer`: a module each.

A module has ``HELP`` (a line), ``arguments(parser)`` and ``run(options)``, and ``NEEDS`` if it
needs optional packages whatever its options are. `dth_hammer.cli` prints errors and handles
interrupts. To add a command, write its module and name it here.
"""

from __future__ import annotations

#: Names in the order in which they are listed; the module is called alike.
COMMANDS = (
    "demo",
    "run",
    "steady",
    "trend",
    "calibrate",
    "optimise",
    "waves",
    "life",
    "sweep",
    "report",
    "configure",
    "system",
    "mesh",
    "datasheet",
    "rock",
    "atlas",
    "info",
)
