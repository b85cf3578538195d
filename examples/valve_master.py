"""A master of FMI 3.0 for one hammer and one valve: it honours early returns."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi3 import FMU3Slave

READ = ("blow_count", "blow_speed", "tip_depth")
FORCE = 2  # drive.source = Force


def made(kind: Any, path: Path) -> tuple[Any, dict[str, int]]:
    """An instance, and the value references of its variables."""
    description = fmpy.read_model_description(path)
    unzipped = fmpy.extract(path)
    hammer = kind(
        guid=description.guid,
        unzipDirectory=unzipped,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="hammer",
    )
    return hammer, {v.name: v.valueReference for v in description.modelVariables}


def master_of_fmi_3(
    path: Path, valve: Any, step: float, until: float, read: Sequence[str] = READ
) -> tuple[list[float], int]:
    """Steps to a point or to an event, whichever comes first, and switches at the event."""
    hammer, at = made(FMU3Slave, path)
    hammer.instantiate(eventModeUsed=True, earlyReturnAllowed=True)
    hammer.setInt64([at["drive.source"]], [FORCE])
    hammer.setInt32([at["event.positions"]], [2])
    ends = [at["event.position[1]"], at["event.position[2]"]]
    hammer.setFloat64(ends, [-valve.stroke, 0.0])
    hammer.setFloat64([at["drive_force"]], [valve.force])
    hammer.enterInitializationMode()
    hammer.exitInitializationMode()
    hammer.updateDiscreteStates()
    hammer.enterStepMode()
    time, point, calls = 0.0, 1, 0
    while time < until:
        target = min(point * step, until)
        event, _, early, time = hammer.doStep(time, target - time)
        point, calls = point + (not early), calls + 1
        if event:
            hammer.enterEventMode()
            (position,) = hammer.getFloat64([at["relative_position"]])
            valve.switch(position)
            hammer.setFloat64([at["drive_force"]], [valve.force])
            hammer.updateDiscreteStates()
            hammer.enterStepMode()
    found = hammer.getFloat64([at[name] for name in read])
    hammer.terminate()
    hammer.freeInstance()
    shutil.rmtree(hammer.unzipDirectory)
    return found, calls
