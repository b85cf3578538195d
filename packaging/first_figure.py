"""What a newcomer does: installs the wheel that fits, and draws the first figure.

`python packaging/first_figure.py FOLDER FIGURE` lets pip choose among the wheels in the
folder, in an environment of its own; no compiler is there, none is wanted.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path


def first_figure(wheels: Path, figure: Path) -> str:
    """Draws the figure, and returns the output of the demo."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        venv.create(folder / "venv", with_pip=True)
        programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        pip = [programs / "python", "-m", "pip", "--disable-pip-version-check"]
        local = ["--no-index", "--no-deps", "--find-links", wheels, "--dest", folder]
        call(programs, *pip, "download", "--only-binary", ":all:", *local, "dth-hammer")
        (chosen,) = folder.glob("dth_hammer-*.whl")
        begun = time.monotonic()
        call(programs, *pip, "install", "--only-binary", ":all:", f"{chosen}[plot]")
        installed = time.monotonic()
        print(call(programs, programs / "dth-hammer", "--version"), end="")
        said = call(programs, programs / "dth-hammer", "demo", "-o", figure.resolve())
        install, draw = installed - begun, time.monotonic() - installed
        return f"{said}{chosen.name}: installed in {install:.0f} s, drawn in {draw:.0f} s\n"


def call(programs: Path, *command: str | Path) -> str:
    """Returns the output of a program that finds only these programs, and no checkout."""
    hidden = {"DTH_HAMMER_FMU", "PYTHONPATH", "PYTHONHOME"}
    env = {k: v for k, v in os.environ.items() if k not in hidden}
    if os.name != "nt":
        env["PATH"] = str(programs)
    done = subprocess.run(
        [*map(str, command)], cwd=programs, env=env, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{command[-1]}: {done.stdout}{done.stderr}")
    return done.stdout


if __name__ == "__main__":
    print(first_figure(Path(sys.argv[1]).resolve(), Path(sys.argv[2])), end="")
