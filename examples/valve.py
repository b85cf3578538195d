"""A valve outside the hammer: what a host's steps cost, with events and without.

    python examples/valve.py          # a table: calls of the host, blows, error of the last one

The valve reverses a force where the piston reaches the ends of its stroke, as the relay inside the
FMU does; the relay is the measure. A host of FMI 2.0 sees the piston at its own communication
points alone. A host of FMI 3.0 with event mode and early return is there when it passes.
"""

from __future__ import annotations

import argparse
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
from dth_hammer import VARIABLES, Hammer, find
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

UNTIL = 0.25  # s
READ = ("blow_count", "blow_speed", "hole_depth")
FORCE = 2  # drive.source = Force


@dataclass
class Valve:
    """Drives the piston down from the top of its stroke, and up from the bit."""

    stroke: float
    force: float

    def switch(self, position: float) -> None:
        """Reverses the force at either end."""
        at_top = self.force < 0.0 and position <= -self.stroke
        at_bit = self.force > 0.0 and position >= 0.0
        if at_top or at_bit:
            self.force = -self.force


def relay_inside(until: float) -> tuple[Valve, list[float]]:
    """The valve to imitate, as it stands at the start, and what the relay inside comes to."""
    with Hammer() as hammer:
        valve = Valve(VARIABLES["drive.stroke"].start or 0.0, hammer["applied_drive_force"])
        hammer.advance(until)
        return valve, [*hammer.get(READ).values()]


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


def master_of_fmi_2(path: Path, valve: Valve, step: float, until: float) -> tuple[list[float], int]:
    """Steps and looks: it switches at the first communication point past an end."""
    hammer, at = made(FMU2Slave, path)
    hammer.instantiate()
    hammer.setInteger([at["drive.source"]], [FORCE])
    hammer.setReal([at["drive_force"]], [valve.force])
    hammer.setupExperiment()
    hammer.enterInitializationMode()
    hammer.exitInitializationMode()
    calls = round(until / step)
    for count in range(calls):
        hammer.doStep(count * step, step)
        (position,) = hammer.getReal([at["relative_position"]])
        valve.switch(position)
        hammer.setReal([at["drive_force"]], [valve.force])
    found = hammer.getReal([at[name] for name in READ])
    hammer.terminate()
    hammer.freeInstance()
    shutil.rmtree(hammer.unzipDirectory)
    return found, calls


# --8<-- [start:master]
def master_of_fmi_3(path: Path, valve: Valve, step: float, until: float) -> tuple[list[float], int]:
    """Steps to a point or to an event, whichever is first: it switches at the event."""
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
    found = hammer.getFloat64([at[name] for name in READ])
    hammer.terminate()
    hammer.freeInstance()
    shutil.rmtree(hammer.unzipDirectory)
    return found, calls


# --8<-- [end:master]


def table(until: float) -> str:
    """Markdown: a row for each standard and step."""
    two, three = find(), find(fmi=3)
    masters = [(master_of_fmi_2, two, step, "2.0") for step in (1e-3, 1e-4, 2e-5)]
    masters.append((master_of_fmi_3, three, 5e-2, "3.0, events"))
    _, inside = relay_inside(until)
    rows = ["| FMI | step | calls | blows | error of the last speed (m/s) | of the depth (m) |"]
    rows.append("|---|---:|---:|---:|---:|---:|")
    for master, path, step, standard in masters:
        valve, _ = relay_inside(until)
        found, calls = master(path, valve, step, until)
        speed, depth = (abs(a - b) for a, b in zip(found[1:], inside[1:], strict=True))
        size = f"{step * 1e3:g} ms"
        rows.append(
            f"| {standard} | {size} | {calls} | {found[0]:.0f} | {speed:.0e} | {depth:.0e} |"
        )
    rows.append(f"| relay inside | | | {inside[0]:.0f} | | |")
    return "\n".join(rows)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--until", type=float, default=UNTIL, help="seconds")
    print(table(parser.parse_args().until))


if __name__ == "__main__":
    main()
