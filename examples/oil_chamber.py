"""A trapped chamber of oil and the hammer, as two FMUs, in masters of others.

    python examples/oil_chamber.py

The oil is an FMU in C (`oil_chamber.c`, built by gcc): 20 cm3 at 1500 MPa behind a face of
1000 mm2, against an equal pressure on the other face. On it a rigid piston swings with `v / omega`,
`omega^2 = K A^2 / (V m)`. Prints the largest swing of 20 ms over that, for the hammer as it is and
for one that knows the oil's stiffness (`drive.stiffness`): between exchanges the oil does not
answer, and a stiff one is missed.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

import fmpy
from dth_hammer import VARIABLES
from dth_hammer.fmu import configure

MODULUS, VOLUME, AREA, SPEED = 1.5e9, 2e-5, 1e-3, 1.0
STIFFNESS = MODULUS * AREA**2 / VOLUME
END, STEPS = 0.02, (1e-4, 5e-5, 2e-5)
SHARES = {"0": 0.0, "the oil's": 1.0, "twice that": 2.0}
HAMMER, OIL = "hammer.fmu", "oil_chamber.fmu"
LINKS = [(HAMMER, "drive_volume", OIL), (OIL, "drive_pressure", HAMMER)]
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Oil chamber" guid="oil">
  <CoSimulation modelIdentifier="oil_chamber" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="drive_volume" valueReference="0" causality="input">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="drive_pressure" valueReference="1" causality="output"
      initial="calculated"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies=""/></Outputs>
    <InitialUnknowns><Unknown index="2"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def build_oil(folder: Path) -> Path:
    """The oil's FMU, for this machine."""
    library, file = folder / "oil_chamber.so", folder / OIL
    headers = Path(fmpy.__file__).with_name("c-code")
    source = Path(__file__).with_suffix(".c")
    command = ["gcc", "-O2", "-shared", "-fPIC", f"-I{headers}", str(source), "-o", str(library)]
    subprocess.run(command, check=True)
    with ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, "binaries/linux64/oil_chamber.so")
    return file


def build_hammer(folder: Path, stiffness: float) -> float:
    """A hammer that swings on the oil and strikes nothing; returns the swing of a spring, m."""
    scene = {
        "fidelity": "Rigid",
        "gravity": 0.0,
        "contact.initial_gap": 0.05,
        "piston.initial_velocity": SPEED,
        "drive.source": "Pressure",
        "drive.area_drive": AREA,
        "drive.area_return": AREA,
        "drive.stiffness": stiffness,
        "drive_pressure": 2e7,
        "return_pressure": 2e7,
    }
    configure(folder / HAMMER, scene)
    names = ("material.density", "cross_section", "piston.length")
    mass = math.prod(VARIABLES[name].start for name in names)
    return SPEED * math.sqrt(mass / STIFFNESS)


def by_fmpy(folder: Path, step: float) -> float:
    """A loop over fmpy: the hammer steps, then the oil by where the hammer is."""
    units = {}
    for file in (HAMMER, OIL):
        description = fmpy.read_model_description(str(folder / file))
        slave = fmpy.instantiate_fmu(fmpy.extract(str(folder / file)), description)
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        units[file] = slave, {v.name: v.valueReference for v in description.modelVariables}
    largest = 0.0
    for k in range(round(END / step)):
        for source, name, target in LINKS:
            (giver, given), (taker, taken) = units[source], units[target]
            giver.doStep(k * step, step)
            taker.setReal([taken[name]], giver.getReal([given[name]]))
        slave, reference = units[HAMMER]
        largest = max(largest, abs(slave.getReal([reference["drive_volume"]])[0]))
    for slave, _ in units.values():
        slave.terminate()
        slave.freeInstance()
    return largest / AREA


def by_fmucontainer(folder: Path, step: float) -> float:
    """The container that fmucontainer makes of both."""
    plan = {
        "name": "container.fmu",
        "mt": False,
        "sequential": True,
        "auto_link": False,
        "auto_input": True,
        "auto_output": True,
        "step_size": step,
        "fmu": [HAMMER, OIL],
        "link": [[source, name, target, name] for source, name, target in LINKS],
        "output": [[HAMMER, "drive_volume", "drive_volume"]],
    }
    (folder / "container.json").write_text(json.dumps(plan), encoding="utf-8")
    program = str(Path(sys.executable).with_name("fmucontainer"))
    options = ["-fmu-directory", str(folder), "-container", "container.json"]
    subprocess.run([program, *options], check=True, capture_output=True)
    found = fmpy.simulate_fmu(
        str(folder / "container.fmu"),
        stop_time=END,
        step_size=step,
        output_interval=step,
        output=["drive_volume"],
    )
    return max(abs(float(x)) for x in found["drive_volume"]) / AREA


MASTERS: dict[str, Callable[[Path, float], float]] = {
    "a loop over fmpy": by_fmpy,
    "fmucontainer": by_fmucontainer,
}


def errors(folder: Path, masters: dict[str, Callable[[Path, float], float]]) -> list[list[float]]:
    """The largest swing over a spring's: a row for each master and stiffness, by step."""
    build_oil(folder)
    rows = []
    for master in masters.values():
        for share in SHARES.values():
            swing = build_hammer(folder, share * STIFFNESS)
            rows.append([master(folder, step) / swing for step in STEPS])
    return rows


def table(folder: Path) -> str:
    """The table of the guide."""
    lines = [
        "| master | `drive.stiffness` | "
        + " | ".join(f"{step * 1e6:.0f} µs" for step in STEPS)
        + " |",
        "|---" * (2 + len(STEPS)) + "|",
    ]
    rows = errors(folder, MASTERS)
    names = [(name, share) for name in MASTERS for share in SHARES]
    for (name, share), row in zip(names, rows, strict=True):
        lines.append(f"| {name} | {share} | " + " | ".join(f"{x:.4g}" for x in row) + " |")
    return "\n".join(lines)


def main() -> None:
    """Measures and prints."""
    argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0]).parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        print(table(Path(scratch)))


if __name__ == "__main__":
    main()
