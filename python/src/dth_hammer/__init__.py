"""Run, couple, sweep and test with a down-the-hole percussive drilling hammer.

The physics is an FMI 2.0 FMU, exact in time between events; this package is its handle.
"""

import importlib
from importlib import metadata
from typing import TYPE_CHECKING, Any

from .calibration import Calibration, Optimum, calibrate, optimise
from .couple import Coupling, Motion, Partner
from .cycle import Cycle, Cycles, stationary
from .datasheet import Datasheet, from_datasheet
from .diagram import Waves, waves
from .errors import (
    ClosedError,
    DomainError,
    DthHammerError,
    FmuNotFoundError,
    HammerWarning,
    InterruptedSweepError,
    OutputError,
    RefusedError,
    TooFewBlowsError,
    UnitError,
    UnknownNameError,
)
from .gradients import gradient
from .hammer import Hammer, Snapshot
from .package import Package, find, load
from .quantities import convert
from .records import Record
from .run import blows, simulate
from .scene import Scene
from .system import write_system
from .variables import Variable
from .variant import configure, write_variant

if TYPE_CHECKING:
    from .page import report
    from .runs import Case
    from .sweeping import sweep

__all__ = [
    "Calibration",
    "Case",
    "ClosedError",
    "Coupling",
    "Cycle",
    "Cycles",
    "Datasheet",
    "DomainError",
    "DthHammerError",
    "FmuNotFoundError",
    "Hammer",
    "HammerWarning",
    "InterruptedSweepError",
    "Motion",
    "Optimum",
    "OutputError",
    "Package",
    "Partner",
    "Record",
    "RefusedError",
    "Scene",
    "Snapshot",
    "TooFewBlowsError",
    "UnitError",
    "UnknownNameError",
    "Variable",
    "Waves",
    "blows",
    "calibrate",
    "configure",
    "convert",
    "find",
    "from_datasheet",
    "gradient",
    "load",
    "optimise",
    "report",
    "simulate",
    "stationary",
    "sweep",
    "waves",
    "write_system",
    "write_variant",
]

#: Dask and the figures are loaded by who needs them, not by who runs.
LATE = {"Case": ".runs", "sweep": ".sweeping", "report": ".page"}
__version__ = metadata.version("dth-hammer")


def __getattr__(name: str) -> Any:
    """What is loaded late."""
    if name in LATE:
        return getattr(importlib.import_module(LATE[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
