"""A trapped chamber of oil and the hammer, as two FMUs, in masters of others.

    python examples/oil_chamber.py

The oil is an FMU in C (`oil_chamber.c`, built by gcc): 20 cm3 at 1500 MPa behind a face of 1000 mm2, against
an equal pressure on the other face. On it a rigid piston swings with `v / omega`, `omega^2 = K A^2 / V m`.
Prints how the largest swing of 20 ms differs, for the hammer as it is and for one that is told of the oil
by `drive.stiffness`: what a master exchanges is a step old, and a stiff oil answers to that.
"""

from __future__ import annotations

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
HAMMER, OIL = "hammer.fmu", "oil_chamber.fmu"
PORTS = {"drive_volume": 0, "drive_flow": 1, "drive_pressure": 2}
LINKS = [(HAMMER, "drive_volume", OIL), (HAMMER, "drive_flow", OIL), (OIL, "drive_pressure", HAMMER)]
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Oil chamber" guid="oil">
  <CoSimulation modelIdentifier="oil_chamber" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="drive_volume" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="drive_flow" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="drive_pressure" valueReference="2" causality="output" initial="calculated"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="3" dependencies=""/></Outputs>
    <InitialUnknowns><Unknown index="3"/></InitialUnknowns>
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
    """A loop over fmpy: both step at once, then exchange."""
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
            taker.setReal([taken[name]], giver.getReal([given[name]]))
        for slave, _ in units.values():
            slave.doStep(k * step, step)
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


def by_libcosim(folder: Path, step: float) -> float:
    """The fixed-step algorithm of libcosim."""
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415
    from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415

    execution = CosimExecution.from_step_size(step * 1e9)
    units = {}
    for file in (HAMMER, OIL):
        index = execution.add_local_slave(CosimLocalSlave(str(folder / file), file.split(".")[0]))
        units[file] = index, {v.name.decode(): v.reference for v in execution.slave_variables(index)}
    for source, name, target in LINKS:
        (giver, given), (taker, taken) = units[source], units[target]
        execution.add_connection(giver, given[name], taker, taken[name])
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    hammer, reference = units[HAMMER]
    largest = 0.0
    for _ in range(round(END / step)):
        execution.step(1)
        largest = max(largest, abs(observer.last_real_values(hammer, [reference["drive_volume"]])[0]))
    return largest / AREA


MASTERS: dict[str, Callable[[Path, float], float]] = {
    "a loop over fmpy": by_fmpy,
    "fmucontainer": by_fmucontainer,
    "libcosim": by_libcosim,
}


def errors(folder: Path, masters: dict[str, Callable[[Path, float], float]]) -> list[list[float]]:
    """The largest swing over a spring's, of each master without stiffness and with, by step."""
    build_oil(folder)
    rows = []
    for master in masters.values():
        for stiffness in (0.0, STIFFNESS):
            swing = build_hammer(folder, stiffness)
            rows.append([master(folder, step) / swing for step in STEPS])
    return rows


def table(folder: Path) -> str:
    """The table of the guide."""
    lines = [
        "| master | `drive.stiffness` | " + " | ".join(f"{step * 1e6:.0f} µs" for step in STEPS) + " |",
        "|---" * (2 + len(STEPS)) + "|",
    ]
    rows = errors(folder, MASTERS)
    names = [(name, told) for name in MASTERS for told in ("0", "the oil's")]
    for (name, told), row in zip(names, rows, strict=True):
        lines.append(f"| {name} | {told} | " + " | ".join(f"{x:.3g}" for x in row) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        print(table(Path(scratch)))
