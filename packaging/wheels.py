"""Wheels of the Python package with an .fmu in them, one for each platform.

`python packaging/wheels.py FMU FOLDER` makes the one for this machine: `cargo wheel`.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "python"
#: What pip calls the platforms that the names of the .fmu files end in.
TAGS = {
    "linux-x86_64": "manylinux2014_x86_64",
    "linux-aarch64": "manylinux2014_aarch64",
    "windows-x86_64": "win_amd64",
    "macos-universal2": "macosx_11_0_universal2",
}


def wheel(fmu: Path, tag: str, folder: Path) -> Path:
    """Writes the wheel of the package with this FMU, for the platform that runs it."""
    with tempfile.TemporaryDirectory() as temporary:
        sources, made = Path(temporary, "sources"), Path(temporary, "made")
        ignored = shutil.ignore_patterns("*.fmu", "__pycache__", "*.egg-info")
        shutil.copytree(PACKAGE, sources, ignore=ignored)
        shutil.copy(fmu, sources / "src" / "dth_hammer" / "data" / "dth_hammer.fmu")
        pip = ("pip", "--disable-pip-version-check", "--quiet")
        run(*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", made, sources)
        (plain,) = made.glob("*.whl")
        run("wheel", "tags", "--platform-tag", tag, "--remove", plain)
        (tagged,) = made.glob("*.whl")
        folder.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(tagged, folder))


def of_this_machine() -> str:
    """The tag of a library that is compiled here, for here."""
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


def run(*arguments: str | Path) -> None:
    """A module of this Python; what it says is told only if it fails."""
    command = [sys.executable, "-m", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    print(wheel(Path(sys.argv[1]), of_this_machine(), Path(sys.argv[2])))
