"""Run, couple, sweep and test with a down-the-hole percussive drilling hammer.

The physics is a native module, exact in time between events; this package is what Python is for.
"""

import importlib
from importlib import metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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
        MissingError,
        OutputError,
        RefusedError,
        TooFewBlowsError,
        UnitError,
        UnknownNameError,
    )
    from .gradients import gradient
    from .hammer import Hammer, Snapshot
    from .mesh import Mesh, mesh_for
    from .package import Package, find, load
    from .page import report
    from .quantities import convert
    from .records import Record
    from .run import Run, blows, simulate
    from .runs import Case
    from .scene import Scene
    from .sweeping import sweep
    from .system import write_system
    from .variables import PRESETS, VARIABLES, Preset, Variable
    from .variant import configure, write_variant

#: Where each name is; a part is loaded when something of it is used first.
PLACES = {
    "calibration": ("Calibration", "Optimum", "calibrate", "optimise"),
    "couple": ("Coupling", "Motion", "Partner"),
    "cycle": ("Cycle", "Cycles", "stationary"),
    "datasheet": ("Datasheet", "from_datasheet"),
    "diagram": ("Waves", "waves"),
    "errors": (
        "ClosedError",
        "DomainError",
        "DthHammerError",
        "FmuNotFoundError",
        "HammerWarning",
        "InterruptedSweepError",
        "MissingError",
        "OutputError",
        "RefusedError",
        "TooFewBlowsError",
        "UnitError",
        "UnknownNameError",
    ),
    "gradients": ("gradient",),
    "hammer": ("Hammer", "Snapshot"),
    "mesh": ("Mesh", "mesh_for"),
    "package": ("Package", "find", "load"),
    "page": ("report",),
    "quantities": ("convert",),
    "records": ("Record",),
    "run": ("Run", "blows", "simulate"),
    "runs": ("Case",),
    "scene": ("Scene",),
    "sweeping": ("sweep",),
    "system": ("write_system",),
    "variables": ("PRESETS", "VARIABLES", "Preset", "Variable"),
    "variant": ("configure", "write_variant"),
}
LATE = {name: module for module, names in PLACES.items() for name in names}
__all__ = sorted(LATE)  # noqa: PLE0605, names all the same
__version__ = metadata.version("dth-hammer")


def __getattr__(name: str) -> Any:
    """What is loaded late."""
    if name in LATE:
        return getattr(importlib.import_module(f".{LATE[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """All names, for completion."""
    return sorted([*globals(), *LATE])
