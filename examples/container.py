"""The hammer and its compressor as two FMUs, coupled by a master that knows neither.

    python examples/container.py --out dist/coupled.fmu

`pythonfmu` makes the compressor's FMU, `fmucontainer` couples both into one FMU, and fmpy runs it.
The blows are compared with those of a loop in Python.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import fmpy
from dth_hammer import Hammer
from dth_hammer.fmu import configure
from dth_hammer.models.compressor import Supply
from fmpy.fmi1 import FMICallException

HERE = Path(__file__).resolve().parent
COMPRESSOR, HAMMER = "AirCompressor.fmu", "hammer.fmu"
#: The reference hammer with its own air, so exact that the rounded instants of hosts do not show.
#: It has few parameters, because libcosim names a folder by all of them.
SCENE = {"drive.source": "Air", "air.error": 1e-11}
COMPARED = ("blow_count", "blow_speed", "rop", "air_flow")


def build_compressor(folder: Path) -> Path:
    """Makes the compressor's FMU in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    _program("pythonfmu", "build", "--file", str(HERE / "compressor_fmu.py"), "--dest", str(folder))
    return folder / COMPRESSOR


def build(out: Path, step: float) -> None:
    """Makes both FMUs in the folder of `out`, and their container."""
    folder = out.resolve().parent
    build_compressor(folder)
    configure(SCENE, folder / HAMMER)
    description = {
        "name": out.name,
        "step_size": step,
        # One after the other, the compressor first, because it has a pressure at the start.
        "sequential": True,
        "mt": False,
        "auto_link": True,
        "auto_input": True,
        "auto_output": True,
        "fmu": [COMPRESSOR, HAMMER],
        "link": [[HAMMER, "air_mass", COMPRESSOR, "air_mass"]],
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
    """Returns the last blow of the container."""
    # The master logs each start as an error, so its log is shown only if there is a real one.
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


def run_loop(
    until: float, step: float, *, at_once: bool = False, names: Sequence[str] = COMPARED
) -> dict[str, float]:
    """Returns the last blow of a loop in Python: the compressor first, or both at once."""
    supply = Supply()
    with Hammer({**SCENE, "supply_pressure": supply.pressure}) as hammer:
        for k in range(round(until / step)):
            before = supply.pressure
            supply.advance(step, hammer["air_mass"])
            hammer.set(supply_pressure=before if at_once else supply.pressure)
            hammer.advance((k + 1) * step)
        return hammer.get(names)


def main() -> None:
    """Builds, runs and compares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("dist/coupled.fmu"))
    parser.add_argument("--until", type=float, default=0.5)
    parser.add_argument("--step", type=float, default=1e-3)
    options = parser.parse_args()
    build(options.out, options.step)
    container = run_container(options.out, options.until)
    loop = run_loop(options.until, options.step)
    print(f"{'':14}{'container':>14}{'loop':>14}")
    for name in COMPARED:
        print(f"{name:14}{container[name]:14.6g}{loop[name]:14.6g}")


if __name__ == "__main__":
    main()
