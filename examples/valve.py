"""A valve outside the hammer: what a host's steps cost, with events and without.

    python examples/valve.py          # a table: calls of the host, blows, error of the last one

The valve reverses a force where the piston reaches the ends of its stroke, as the relay inside the
FMU does; the relay is the reference. A host of FMI 2.0 sees the piston only at its communication
points. A host of FMI 3.0 with event mode and early return stops exactly where the piston passes.
"""

from __future__ import annotations

import argparse
import shutil
from dataclasses import dataclass
from pathlib import Path

from dth_hammer import VARIABLES, Hammer
from dth_hammer.fmu import find
from fmpy.fmi2 import FMU2Slave
from valve_master import FORCE, READ, made, master_of_fmi_3

UNTIL = 0.25  # s


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
    """Returns the valve in its state at the start, and the results of the relay inside."""
    with Hammer() as hammer:
        valve = Valve(VARIABLES["drive.stroke"].start or 0.0, hammer["applied_drive_force"])
        hammer.advance(until)
        return valve, [*hammer.get(READ).values()]


def master_of_fmi_2(path: Path, valve: Valve, step: float, until: float) -> tuple[list[float], int]:
    """Steps, and switches at the first communication point past an end."""
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


def table(until: float) -> str:
    """Returns a table in Markdown, with a row for each standard and step."""
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
