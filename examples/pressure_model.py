"""A pressure model and the hammer as two FMUs in several masters: what the exchange costs.

    python examples/pressure_model.py --out table.md

The models are FMUs in C (`pressure_model.c`, built by gcc):

* trapped oil; gas in two chambers; water behind a valve;
* a hose with a valve at its far end, as a transmission line that gives its pressure or its wave
  (`drive.impedance`);
* a compressor that supplies a hammer with its own air.

Each runs with the hammer in a loop in Python, in fmucontainer (one unit after the other), and in
libcosim and ecos (both at once), with held values (`coupling.delay` 0) and with the right delay.
The reference is the same pair with steps of 0.5 us. The program prints the errors of impact speed
and frequency (for oil, of the swing), and the energy that the exchange created over the drive's
work: the hammer's output `energy_exchange`, and the true value.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZipFile

import fmpy
import numpy as np
from dth_hammer.fmu import configure

HAMMER, MODEL, UNUSED = "hammer.fmu", "pressure_model.fmu", "unused"
READ = [
    *("blow_count", "blow_time", "blow_speed", "energy_exchange", "energy_drive"),
    "relative_position",
]
STEPS, TRUE_STEP = (1e-3, 1e-4, 2e-5, 5e-6), 5e-7
#: Delay of a host's values, in steps: one unit after the other, or both at once.
AFTER, AT_ONCE = 0.5, 1.5
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Pressure model" guid="pressure">
  <CoSimulation modelIdentifier="pressure_model" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="{taken}" valueReference="0" causality="input">
      <Real start="{begin}"/></ScalarVariable>
    <ScalarVariable name="{given[0]}" valueReference="1" causality="output"
      initial="calculated"><Real/></ScalarVariable>
    <ScalarVariable name="{given[1]}" valueReference="2" causality="output"
      initial="calculated"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies=""/><Unknown index="3" dependencies=""/></Outputs>
    <InitialUnknowns>
      <Unknown index="2" dependencies=""/><Unknown index="3" dependencies=""/>
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


@dataclass(frozen=True)
class Case:
    """A model, the hammer that it drives, and how long they run."""

    number: int
    scene: dict[str, float | str]
    end: float
    begin: float = -0.05
    #: By how many steps a value belongs to an instant before its communication point, if one unit
    #: steps after the other; None if the hammer does not extrapolate such a value.
    late: float | None = 0.0
    taken: str = "relative_position"
    given: tuple[str, str] = ("drive_pressure", "return_pressure")
    options: tuple[str, ...] = ()
    preset: str | None = None

    def links(self) -> list[tuple[str, str, str]]:
        """Unit, variable, unit."""
        given = [port for port in self.given if port != UNUSED]
        return [(HAMMER, self.taken, MODEL), *((MODEL, port, HAMMER) for port in given)]

    def every(self, step: float) -> int:
        """Returns the steps between two readings of the hammer, which is read a thousand times."""
        return max(1, round(self.end / step / 1000))

    def delays(self, host: float) -> list[float]:
        """Returns the delay of held values and the right one of a host; one, if they are equal."""
        return sorted({0.0, 0.0 if self.late is None else host + self.late})


def _areas(down: float, up: float) -> dict[str, float | str]:
    return {"drive.area_drive": down, "drive.area_return": up, "drive.source": "Pressure"}


CASES = {
    "oil": Case(1, _areas(1e-3, 1e-3) | {"gravity": 0.0, "piston.initial_velocity": 1.0}, end=0.02),
    "gas": Case(2, _areas(6e-3, 5e-3) | {"piston.length": 0.35, "cross_section": 4.5e-3}, end=0.3),
    "water with a valve": Case(3, _areas(3.6e-4, 1.8e-4), end=0.3, begin=-0.02),
    # The pressure is the mean of the step before: half a step late. The wave is that of the next.
    "hose, its pressure": Case(
        4, _areas(3.6e-4, 1.8e-4), end=0.3, begin=-0.02, late=0.5, options=("-DPRESSURE=1",)
    ),
    "hose, its wave": Case(
        4,
        _areas(3.6e-4, 1.8e-4) | {"drive.impedance": 9e8 * 3.6e-4**2},
        end=0.3,
        begin=-0.02,
        late=-0.5,
    ),
    "compressor": Case(
        5,
        {},
        end=0.2,
        begin=0.0,
        late=None,
        taken="air_mass",
        given=("supply_pressure", UNUSED),
        preset="air_4_inch",
    ),
}
Rows = dict[str, np.ndarray]


def build(folder: Path, case: Case, delay: float) -> None:
    """Builds the FMUs of both for this machine."""
    library = folder / "pressure_model.so"
    headers = Path(fmpy.__file__).with_name("c-code")
    source = Path(__file__).with_suffix(".c")
    options = [f"-DCASE={case.number}", f"-DBEGIN={case.begin}", "-O2", "-shared", "-fPIC"]
    command = ["gcc", *options, *case.options, f"-I{headers}", source, "-o", library, "-lm"]
    subprocess.run(command, check=True)
    with ZipFile(folder / MODEL, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION.format_map(vars(case)))
        archive.write(library, "binaries/linux64/pressure_model.so")
    own: dict[str, float | str] = {"fidelity": "Rigid", "coupling.delay": delay}
    if case.preset is None:
        own["contact.initial_gap"] = -case.begin
    configure(own | case.scene, folder / HAMMER, preset=case.preset)


def by_loop(folder: Path, case: Case, step: float) -> Rows:
    """Runs a loop over fmpy: the hammer steps, then the model follows its motion."""
    units = {}
    for file in (MODEL, HAMMER):
        description = fmpy.read_model_description(str(folder / file))
        slave = fmpy.instantiate_fmu(fmpy.extract(str(folder / file)), description)
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        units[file] = slave, {v.name: v.valueReference for v in description.modelVariables}
    (model, own), (hammer, names) = units[MODEL], units[HAMMER]
    ports = [port for _, port, target in case.links() if target == HAMMER]
    given, taken = [own[port] for port in ports], [names[port] for port in ports]
    read, place, follows = [names[n] for n in READ], [names[case.taken]], [own[case.taken]]
    hammer.setReal(taken, model.getReal(given))
    hammer.exitInitializationMode()
    model.setReal(follows, hammer.getReal(place))
    model.exitInitializationMode()
    rows, every = [], case.every(step)
    for k in range(round(case.end / step)):
        hammer.setReal(taken, model.getReal(given))
        hammer.doStep(k * step, step)
        model.setReal(follows, hammer.getReal(place))
        model.doStep(k * step, step)
        if (k + 1) % every == 0:
            rows.append(hammer.getReal(read))
    for slave, _ in units.values():
        slave.terminate()
        slave.freeInstance()
    return dict(zip(READ, np.array(rows).T, strict=True))


def by_fmucontainer(folder: Path, case: Case, step: float) -> Rows:
    """Runs the container that fmucontainer makes of both, the hammer first."""
    plan = {
        "name": "container.fmu",
        "mt": False,
        "sequential": True,
        "auto_link": False,
        "auto_input": True,
        "auto_output": True,
        "step_size": step,
        # An air hammer cannot start without pressure, so the unit that gives it is listed first.
        "fmu": [HAMMER, MODEL] if case.late is not None else [MODEL, HAMMER],
        "link": [[source, name, target, name] for source, name, target in case.links()],
        "output": [[HAMMER, name, name] for name in READ],
    }
    (folder / "container.json").write_text(json.dumps(plan), encoding="utf-8")
    program = str(Path(sys.executable).with_name("fmucontainer"))
    options = ["-fmu-directory", str(folder), "-container", "container.json"]
    subprocess.run([program, *options], check=True, capture_output=True)
    file, look = str(folder / "container.fmu"), case.every(step) * step
    found = fmpy.simulate_fmu(
        file, stop_time=case.end, step_size=step, output_interval=look, output=READ
    )
    return {name: np.asarray(found[name][1:], float) for name in READ}


def by_libcosim(folder: Path, case: Case, step: float) -> Rows:
    """Runs libcosim, the library of the Open Simulation Platform: both at once."""
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415
    from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_step_size(step * 1e9)
    units, names = {}, {}
    for file in (HAMMER, MODEL):
        label = Path(file).stem
        units[file] = execution.add_local_slave(CosimLocalSlave(str(folder / file), label))
        variables = execution.slave_variables(units[file])
        names[file] = {v.name.decode(): v.reference for v in variables}
    for source, name, target in case.links():
        execution.connect_real_variables(
            units[source], names[source][name], units[target], names[target][name]
        )
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    read, rows, every = [names[HAMMER][name] for name in READ], [], case.every(step)
    for _ in range(round(case.end / step / every)):
        execution.step(every)
        rows.append(observer.last_real_values(units[HAMMER], read))
    return dict(zip(READ, np.array(rows).T, strict=True))


def by_ecos(folder: Path, case: Case, step: float) -> Rows:
    """Runs ecos: both at once."""
    ctypes.CDLL(f"{sys.prefix}/lib/libtbb.so.12", mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: PLC0415

    structure = EcosSimulationStructure()
    for file in (HAMMER, MODEL):
        structure.add_model(Path(file).stem, str(folder / file))
    for source, name, target in case.links():
        structure.make_real_connection(
            f"{Path(source).stem}::{name}", f"{Path(target).stem}::{name}"
        )
    rows, every = [], case.every(step)
    with EcosSimulation(step, structure=structure) as simulation:
        simulation.init()
        for _ in range(round(case.end / step / every)):
            simulation.step(every)
            rows.append([simulation.get_real(f"hammer::{name}") for name in READ])
    return dict(zip(READ, np.array(rows).T, strict=True))


Host = Callable[[Path, Case, float], Rows]
HOSTS: dict[str, tuple[Host, float]] = {
    "own loop": (by_loop, AFTER),
    "fmucontainer": (by_fmucontainer, AFTER),
    "libcosim": (by_libcosim, AT_ONCE),
    "ecos": (by_ecos, AT_ONCE),
}


def figures(rows: Rows) -> tuple[float, float, float]:
    """Returns impact speed and frequency of the last blows, or the swing; the exchange's energy.

    The energy is `energy_exchange` over the work of the drive, or its largest value.
    """
    count, made, work = rows["blow_count"], rows["energy_exchange"], rows["energy_drive"]
    part = made[-1] / max(abs(work[-1]), np.abs(work).max())
    if count[-1] < 1:
        place = rows["relative_position"]
        return float(np.abs(place - place[0]).max()), 1.0, float(part)
    at = [int(np.searchsorted(count, k)) for k in range(1, int(count[-1]) + 1)]
    last = [k for k in at if k < len(count)][-6:]
    times, speeds = rows["blow_time"][last], rows["blow_speed"][last]
    if len(last) < 2:
        return math.nan, math.nan, float(part)
    return float(speeds[1:].mean()), float((len(last) - 1) / (times[-1] - times[0])), float(part)


def measure(
    cases: Sequence[str] = tuple(CASES),
    hosts: Sequence[str] = tuple(HOSTS),
    steps: Sequence[float] = STEPS,
    true_step: float = TRUE_STEP,
) -> list[tuple[str, str, float, float, float, float, float]]:
    """Returns rows: case, host, step, delay, errors of speed and frequency, share of energy."""
    table = []
    for name in cases:
        case = CASES[name]
        with tempfile.TemporaryDirectory() as scratch:
            build(Path(scratch), case, case.delays(AFTER)[-1])
            speed, rate, _ = figures(by_loop(Path(scratch), case, true_step))
        for host in hosts:
            run, delay = HOSTS[host]
            for step in steps:
                for given in case.delays(delay):
                    with tempfile.TemporaryDirectory() as scratch:
                        build(Path(scratch), case, given)
                        try:
                            own, often, part = figures(run(Path(scratch), case, step))
                        except Exception:  # whatever a host makes of it
                            own = often = part = math.nan
                    table.append((name, host, step, given, own / speed - 1, often / rate - 1, part))
                    print(*table[-1], flush=True)
    return table


def text(table: Sequence[tuple[str, str, float, float, float, float, float]]) -> str:
    """Returns the table of the guide, in per cent."""
    lines = [
        "| model | host | step | `coupling.delay` | speed | frequency | made | energy |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for case, host, step, delay, speed, *others in table:
        errors = [speed, *others, (1.0 + speed) ** 2 - 1.0]
        cells = ["fails" if math.isnan(x) else f"{100 * x:+.3g} %" for x in errors]
        lines.append(
            f"| {case} | {host} | {step * 1e6:.0f} µs | {delay:g} | " + " | ".join(cells) + " |"
        )
    return "\n".join(lines)


def main() -> None:
    """Measures, and writes the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("pressure_model.md"))
    options = parser.parse_args()
    options.out.write_text(text(measure()) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
