"""The hammer and the pneumatic drive as two FMUs, coupled by a master that knows neither.

    python examples/container.py --out dist/coupled.fmu

`pythonfmu` makes the drive's FMU, `fmucontainer` couples both into one FMU, fmpy runs it;
the blows are compared with those of the co-simulation loop in Python.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
from dth_hammer import Coupling, Hammer
from dth_hammer.fmu import load
from dth_hammer.models.pneumatic import Air, PneumaticDrive
from dth_hammer.variables import VARIABLES, numbers
from fmpy.fmi1 import FMICallException

HERE = Path(__file__).resolve().parent
DRIVE, HAMMER = "PneumaticHammerDrive.fmu", "dth_hammer.fmu"
COMPARED = ("blow_count", "blow_period", "blow_speed", "rop")


def build_drive(folder: Path) -> Path:
    """Makes the drive's FMU in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    _program("pythonfmu", "build", "--file", str(HERE / "pneumatic_fmu.py"), "--dest", str(folder))
    return folder / DRIVE


def build(out: Path, step: float) -> None:
    """Makes the drive's FMU beside `out`, and the container of both."""
    folder = out.resolve().parent
    build_drive(folder)
    package = load()
    if package.path != folder / HAMMER:
        shutil.copyfile(package.path, folder / HAMMER)
    values = numbers(None, Air().parameters())
    whole = ("Integer", "Enumeration")
    starts = {n: int(v) if VARIABLES[n].kind in whole else v for n, v in values.items()}
    description = {
        "name": out.name,
        "step_size": step,
        # One after the other: Gauss-Seidel, the hammer first.
        "sequential": True,
        "mt": False,
        "auto_link": True,
        "auto_input": True,
        "auto_output": True,
        "fmu": [HAMMER, DRIVE],
        "start": [[HAMMER, name, value] for name, value in starts.items()],
        "link": [[HAMMER, "relative_position", DRIVE, "relative_position"]],
    }
    plan = out.resolve().with_suffix(".json")
    plan.write_text(json.dumps(description, indent=2), encoding="utf-8")
    _program("fmucontainer", "-fmu-directory", str(folder), "-container", str(plan))


def _program(name: str, *arguments: str) -> None:
    program = shutil.which(name, path=Path(sys.executable).parent) or shutil.which(name)
    if program is None:
        raise SystemExit(f"no {name}: pip install pythonfmu fmu_manipulation_toolbox")
    done = subprocess.run(
        [program, *arguments], check=False, capture_output=True, text=True, cwd=HERE
    )
    if done.returncode:
        raise SystemExit(f"{name} failed:\n{done.stdout}{done.stderr}")


def run_container(container: Path, until: float) -> dict[str, float]:
    """The last blow of the container."""
    # The master logs each start as an error: heard only if there is one.
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            result = fmpy.simulate_fmu(
                str(container),
                stop_time=until,
                step_size=1e-3,
                output_interval=1e-3,
                output=COMPARED,
            )
    except FMICallException as error:
        raise RuntimeError(said.getvalue() + str(error)) from error
    return {name: float(result[name][-1]) for name in COMPARED}


def run_loop(until: float, step: float) -> dict[str, float]:
    """The last blow of the loop in Python, coupled as the container couples."""
    drive = PneumaticDrive()
    with Hammer(drive.air.parameters()) as hammer:
        drive.start(hammer["relative_position"])
        Coupling(hammer, drive, step, slopes=False).advance(until)
        return hammer.get(COMPARED)


def main() -> None:
    """Builds, runs, compares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("dist/coupled.fmu"))
    parser.add_argument("--until", type=float, default=0.5)
    parser.add_argument("--step", type=float, default=1e-5)
    options = parser.parse_args()
    build(options.out, options.step)
    container = run_container(options.out, options.until)
    loop = run_loop(options.until, options.step)
    print(f"{'':14}{'container':>14}{'loop':>14}")
    for name in COMPARED:
        print(f"{name:14}{container[name]:14.6g}{loop[name]:14.6g}")


if __name__ == "__main__":
    main()
