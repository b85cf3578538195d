"""A benchmark for hosts of FMI 3.0: are events kept, how exactly, at how many points.

    python evidence/hosts/events.py             # a table: every host that is installed here

The units are those of `unit/`; `score.py` beside this file has the closed forms, and scores the
rows of any other host. fmusim is run if it is on the path.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave
from score import END, GAP, READ, SCENES, STEP, cells, input_rows, read_rows

UNITS = Path(__file__).resolve().parent / "unit"
FILES = {2: "thrown_fmi2.fmu", 3: "thrown_fmi3.fmu"}
VALVES = {2: "valve_fmi2.fmu", 3: "valve_fmi3.fmu"}
#: What the valve gives back.
GIVEN = "acceleration"


def run_fmpy(
    folder: Path, fmi: int, scene: str = "thrown", events: bool = False
) -> list[tuple[float, float]]:
    changed = np.genfromtxt(input_rows().splitlines(), delimiter=",", names=True)
    found = fmpy.simulate_fmu(
        str(folder / FILES[fmi]),
        stop_time=SCENES[scene],
        input=changed if scene == "changed" else None,
        step_size=STEP,
        output_interval=STEP,
        output=[READ],
        use_event_mode=events,
        early_return_allowed=events,
    )
    return [(float(time), float(x)) for time, x in zip(found["time"], found[READ], strict=True)]


def run_coupled(folder: Path, events: bool) -> list[tuple[float, float]]:
    """Piston and valve by a master over fmpy, which exchanges wherever the piston's step ends."""
    end, rows = SCENES["coupled"], [(0.0, -GAP)]
    with tempfile.TemporaryDirectory() as place:
        units = []
        for name in ("thrown", "valve"):
            unzipped = fmpy.extract(str(folder / f"{name}_fmi3.fmu"), f"{place}/{name}")
            more = {"guid": name, "modelIdentifier": name, "unzipDirectory": unzipped}
            unit = FMU3Slave(**more, instanceName=name)
            unit.instantiate(eventModeUsed=events, earlyReturnAllowed=events)
            unit.enterInitializationMode()
            unit.exitInitializationMode()
            if events:
                unit.enterStepMode()
            units.append(unit)
        piston, valve = units
        time = 0.0
        while time < end - 1e-9:
            # The next multiple of the step, wherever the last one ended.
            point = (int(time / STEP + 1e-9) + 1) * STEP
            event, _, _, reached = piston.doStep(time, point - time)
            valve.doStep(time, reached - time)
            time = reached
            if event and events:
                piston.enterEventMode()
            (x,) = piston.getFloat64([1])
            valve.setFloat64([1], [x])
            piston.setFloat64([3], valve.getFloat64([3]))
            if event and events:
                piston.updateDiscreteStates()
                piston.enterStepMode()
            rows.append((time, x))
        for unit in units:
            unit.terminate()
            unit.freeInstance()
    return rows


def run_container(folder: Path, fmi: int) -> list[tuple[float, float]]:
    """Piston and valve in one unit, made by fmucontainer, whose master is in C."""
    piston, valve = FILES[fmi], VALVES[fmi]
    plan = {
        "name": "pair.fmu",
        "step_size": STEP,
        "sequential": True,
        "mt": False,
        "auto_link": False,
        "fmu": [piston, valve],
        "link": [[piston, READ, valve, READ], [valve, GIVEN, piston, GIVEN]],
        # What is linked is not put out unless asked for.
        "output": [[piston, READ, READ]],
    }
    (folder / "pair.json").write_text(json.dumps(plan), encoding="utf-8")
    maker = Path(sys.executable).with_name("fmucontainer")
    options = ["-fmi", str(fmi), "-container", "pair.json"]
    run_program(maker, "-fmu-directory", folder, *options)
    end = SCENES["coupled"]
    steps = {"stop_time": end, "step_size": STEP, "output_interval": STEP}
    found = fmpy.simulate_fmu(str(folder / "pair.fmu"), **steps, output=[READ])
    return [(float(time), float(x)) for time, x in zip(found["time"], found[READ], strict=True)]


def run_program(*command: str | Path) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr or done.stdout or f"it ends with {done.returncode}")
    return done.stdout


def run_fmusim(folder: Path, fmi: int, *options: str) -> list[tuple[float, float]]:
    rows = folder / "fmusim.csv"
    times = ["--stop-time", repr(END), "--output-interval", repr(STEP)]
    ports: list[str | Path] = ["--output-variable", READ, "--output-file", rows]
    run_program("fmusim", "--interface-type", "cs", *times, *ports, *options, folder / FILES[fmi])
    return read_rows(rows.read_text(encoding="utf-8").splitlines())


def run_importer(folder: Path, fmi: int) -> list[tuple[float, float]]:
    """The crate fmi-rs, in tests/importer; `cargo suite -k fmi_rs` builds it."""
    root = Path(__file__).resolve().parents[2]
    target = root / os.environ.get("CARGO_TARGET_DIR", "target")
    program, rows = target / "importer" / "debug" / "importer", folder / "fmi_rs.csv"
    run_program(program, folder / FILES[fmi], repr(STEP), repr(END), rows)
    return read_rows(rows.read_text(encoding="utf-8").splitlines())


#: What a host crashes on when it frees it.
ALIVE: list[object] = []


def points(scene: str) -> range:
    """The steps of a scene."""
    return range(1, round(SCENES[scene] / STEP) + 1)


def run_ecos(folder: Path, fmi: int, scene: str = "thrown") -> list[tuple[float, float]]:
    import ctypes  # noqa: PLC0415

    ctypes.CDLL(f"{sys.prefix}/lib/libtbb.so.12", mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: PLC0415

    structure = EcosSimulationStructure()
    # Of FMI 3.0, it frees the attributes `clocks` and `intervalVariability` twice.
    ALIVE.append(structure)
    structure.add_model("hammer", str(folder / FILES[fmi]))
    if scene == "coupled":
        structure.add_model("valve", str(folder / VALVES[fmi]))
        structure.make_real_connection(f"hammer::{READ}", f"valve::{READ}")
        structure.make_real_connection(f"valve::{GIVEN}", f"hammer::{GIVEN}")
    with EcosSimulation(STEP, structure=structure) as simulation:
        simulation.init()
        rows = [(0.0, simulation.get_real(f"hammer::{READ}"))]
        for k in points(scene):
            simulation.step(1)
            rows.append((k * STEP, simulation.get_real(f"hammer::{READ}")))
    return rows


def run_libcosim(folder: Path, fmi: int, scene: str = "thrown") -> list[tuple[float, float]]:
    import ctypes  # noqa: PLC0415

    from libcosimpy._internal import libcosimc  # noqa: PLC0415
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415
    from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415

    execution = CosimExecution.from_step_size(STEP * 1e9)
    slave = CosimLocalSlave(str(folder / FILES[fmi]), "hammer")
    if not slave.ptr():  # It would be followed.
        why = libcosimc().cosim_last_error_message
        why.restype = ctypes.c_char_p
        raise RuntimeError(why().decode())
    hammer = execution.add_local_slave(slave)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)

    def reference(unit: int, name: str) -> int:
        found = execution.slave_variables(unit)
        return next(v.reference for v in found if v.name.decode() == name)

    if scene == "coupled":
        valve = execution.add_local_slave(CosimLocalSlave(str(folder / VALVES[fmi]), "valve"))
        for name, giver, taker in [(READ, hammer, valve), (GIVEN, valve, hammer)]:
            ends = [giver, reference(giver, name), taker, reference(taker, name)]
            execution.connect_real_variables(*ends)
    rows = [(0.0, -GAP)]
    for k in points(scene):
        execution.step(1)
        value = observer.last_real_values(hammer, [reference(hammer, READ)])
        rows.append((k * STEP, value[0]))
    return rows


Run = Callable[[Path], list[tuple[float, float]]]
AGREED = ("--event-mode-used", "--early-return-allowed")
#: What is run: a name, the package or program whose version is shown, FMI, and how.
HOSTS = {
    "fmpy, event mode and early return": ("fmpy", 3, lambda at: run_fmpy(at, 3, events=True)),
    "fmpy, neither": ("fmpy", 3, lambda at: run_fmpy(at, 3)),
    "fmpy, FMI 2.0": ("fmpy", 2, lambda at: run_fmpy(at, 2)),
    "fmusim, event mode and early return": (
        "fmusim",
        3,
        lambda at: run_fmusim(at, 3, *AGREED),
    ),
    "fmusim, neither": ("fmusim", 3, lambda at: run_fmusim(at, 3)),
    "fmusim, FMI 2.0": ("fmusim", 2, lambda at: run_fmusim(at, 2)),
    "the Rust crate fmi-rs, event mode and early return": (
        "0.3.4",
        3,
        lambda at: run_importer(at, 3),
    ),
    "the Rust crate fmi-rs, FMI 2.0": ("0.3.4", 2, lambda at: run_importer(at, 2)),
    "ecos": ("ecospy", 3, lambda at: run_ecos(at, 3)),
    "ecos, FMI 2.0": ("ecospy", 2, lambda at: run_ecos(at, 2)),
    "libcosim": ("libcosimpy", 3, lambda at: run_libcosim(at, 3)),
    "libcosim, FMI 2.0": ("libcosimpy", 2, lambda at: run_libcosim(at, 2)),
}
#: The other scenes, in the same way.
OTHERS = {
    "changed": {
        "fmpy, event mode and early return": (
            "fmpy",
            lambda at: run_fmpy(at, 3, "changed", events=True),
        ),
        "fmpy, neither": ("fmpy", lambda at: run_fmpy(at, 3, "changed")),
    },
    "coupled": {
        "a master over fmpy, event mode and early return": (
            "fmpy",
            lambda at: run_coupled(at, events=True),
        ),
        "a master over fmpy, neither": ("fmpy", lambda at: run_coupled(at, events=False)),
        "fmucontainer": ("fmu_manipulation_toolbox", lambda at: run_container(at, 3)),
        "fmucontainer, FMI 2.0": ("fmu_manipulation_toolbox", lambda at: run_container(at, 2)),
        "ecos": ("ecospy", lambda at: run_ecos(at, 3, "coupled")),
        "ecos, FMI 2.0": ("ecospy", lambda at: run_ecos(at, 2, "coupled")),
        "libcosim, FMI 2.0": ("libcosimpy", lambda at: run_libcosim(at, 2, "coupled")),
    },
}
PROGRAMS = ("fmusim",)


def number(host: str) -> str | None:
    """The version of a package or program; none if it is not installed."""
    if host in PROGRAMS:
        return run_program(host, "--version").split()[1] if shutil.which(host) else None
    try:
        return host if host[0].isdigit() else version(host)
    except PackageNotFoundError:
        return None


def apart(name: str, scene: str = "thrown") -> str:
    """One host in a process of its own: some of them end badly."""
    command = [sys.executable, __file__, "--host", name, "--scene", scene]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    text = next((line for line in done.stdout.splitlines() if line.startswith("[[")), None)
    if text is None:
        words = [line for line in done.stderr.splitlines() if line and "[debug]" not in line]
        why = words[-1] if words else f"it ends with {done.returncode} and says nothing"
        return f"does not run it: {re.sub(r'/.*/', '', why)[:120]} | | |"
    return cells([(time, x) for time, x in json.loads(text)], scene)


def tables() -> str:
    figures = "instants kept | events seen | largest error (s) | points |"
    lines = [f"| host | version | FMI | {figures}", "|---|---|---|---|---|---|---|"]
    for name, (package, fmi, _) in HOSTS.items():
        if (installed := number(package)) is not None:
            lines.append(f"| {name} | {installed} | {fmi}.0 | {apart(name)} |")
    lines += ["", f"| scene | host | version | {figures}", "|---|---|---|---|---|---|---|"]
    for scene, hosts in OTHERS.items():
        for name, (package, _) in hosts.items():
            if (installed := number(package)) is not None:
                lines.append(f"| {scene} | {name} | {installed} | {apart(name, scene)} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--host")
    parser.add_argument("--scene", choices=SCENES, default="thrown")
    options = parser.parse_args()
    if options.host:
        others = OTHERS.get(options.scene)
        run: Run = others[options.host][1] if others else HOSTS[options.host][2]
        with tempfile.TemporaryDirectory() as folder:
            # A host may write beside the unit.
            shutil.copytree(UNITS, folder, dirs_exist_ok=True)
            rows = run(Path(folder))
        print(json.dumps(rows), flush=True)
        os._exit(0)
    print(tables())


if __name__ == "__main__":
    main()
