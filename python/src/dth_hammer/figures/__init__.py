# ruff: noqa: E402, `need` must run first to report a missing matplotlib
"""Figures of a run of `dth_hammer.simulate`: each returns a matplotlib figure."""

from ..extras import need

need("matplotlib")

from .cycles import convergence, cycle, indicator, rock_cycles, settled_cycle
from .dark import darken
from .diagram import wave_diagram
from .energies import at_blows, ledger
from .marks import BIT as BIT
from .marks import COLOURS as COLOURS
from .marks import DARK as DARK
from .marks import MODES as MODES
from .marks import PISTON as PISTON
from .marks import ROCK as ROCK

__all__ = [
    "at_blows",
    "convergence",
    "cycle",
    "darken",
    "indicator",
    "ledger",
    "rock_cycles",
    "settled_cycle",
    "wave_diagram",
]
