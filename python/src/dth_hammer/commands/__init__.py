"""The subcommands of `dth-hammer`: a module each.

A module has ``HELP`` (a line), ``arguments(parser)`` and ``run(options)``; errors of this
package and interrupts are told by `dth_hammer.cli`. To add one: write it, and name it here.
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
