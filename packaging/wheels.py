"""The wheel of the Python package for this machine: its native module, and the .fmu files.

`python packaging/wheels.py FMU FOLDER` makes it: `cargo wheel`. maturin compiles for the machine
that it runs on, so the wheels of a release are made on each system.
"""

from __future__ import annotations

import json
import os
import platform as platforms
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "python"
#: Folder in which the packager of the FMU lists the components of the wheel.
NOTES = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "wheel"
#: Makes a wheel for Python 3.10 and newer. maturin determines the oldest system on which the
#: libraries run.
BUILD = ("maturin", "build", "--locked")
#: The earliest time in an archive, 1980, in Unix seconds.
EPOCH = "315532800"
#: The beginning of a bill of materials.
STANDARD: dict[str, Any] = {"bomFormat": "CycloneDX", "specVersion": "1.6", "version": 1}
#: Platforms in the names of the .fmu files, with pip's names for them.
TAGS = {
    "linux-x86_64": r"manylinux.*_x86_64|linux_x86_64",
    "linux-aarch64": r"manylinux.*_aarch64|linux_aarch64",
    "windows-x86_64": "win_amd64",
    "macos-universal2": r"macosx_.*",
}


def wheel(fmu: Path, folder: Path, profile: str = "fmu") -> Path:
    """Makes the wheel with this FMU, its native module compiled with a profile of cargo."""
    with tempfile.TemporaryDirectory() as temporary:
        made, packed = Path(temporary, "made"), Path(temporary, "packed")
        # The engine of the tests is already compiled, with paths of this machine in it.
        own = {} if profile == "native" else {"CARGO_ENCODED_RUSTFLAGS": flags()}
        run(*BUILD, "--profile", profile, "--out", made, folder=PACKAGE, environment=own)
        (plain,) = made.glob("*.whl")
        run("wheel", "unpack", "--dest", made, plain)
        (inside,) = (p for p in made.iterdir() if p.is_dir())
        # A used checkout has compiled Python files beside the sources.
        for compiled in [*inside.rglob("__pycache__")]:
            shutil.rmtree(compiled)
        if own:
            anonymous(inside)
        data = inside / "dth_hammer" / "data"
        data.mkdir(exist_ok=True)
        (data / ".gitignore").unlink(missing_ok=True)
        for ending in (".fmu", "_fmi3.fmu"):
            shutil.copy(fmu.with_name(fmu.stem + ending), data / f"dth_hammer{ending}")
        state_contents(inside / f"{inside.name}.dist-info")
        packed.mkdir()
        # A fixed time makes the same bytes at any time and place.
        run("wheel", "pack", "--dest-dir", packed, inside, environment={"SOURCE_DATE_EPOCH": EPOCH})
        (whole,) = packed.glob("*.whl")
        folder.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(whole, folder))


def flags() -> str:
    """Returns the compiler flags that keep this machine's folders out of the compiled code."""
    return (NOTES / "rustflags.txt").read_text(encoding="utf-8")


def anonymous(folder: Path) -> None:
    """Fails if a file names a folder of the machine that built it."""
    for path in (path for path in folder.rglob("*") if path.is_file()):
        content = path.read_bytes()
        for place in (Path.home(), ROOT):
            if f"{place}{os.sep}".encode() in content:
                sys.exit(f"{path.relative_to(folder)} names {place}")


def state_contents(info: Path) -> None:
    """Adds the licences, and a bill of materials of the compiled code (CycloneDX)."""
    licenses = info / "licenses"
    licenses.mkdir(exist_ok=True)
    for text in (ROOT / "LICENSE-MIT", ROOT / "LICENSE-APACHE", NOTES / "licenses.txt"):
        shutil.copy(text, licenses)
    names = "".join(f"License-File: {path.name}\n" for path in sorted(licenses.iterdir()))
    metadata = (info / "METADATA").read_text(encoding="utf-8")
    head, line, rest = metadata.partition("License-Expression: ")
    own, _, rest = rest.partition("\n")
    (info / "METADATA").write_text(f"{head}{line}{own}\n{names}{rest}", encoding="utf-8")
    parts = json.loads((NOTES / "contents.json").read_text(encoding="utf-8"))
    (info / "sboms").mkdir(exist_ok=True)
    text = json.dumps(STANDARD | {"components": [component(part) for part in parts]}, indent=1)
    (info / "sboms" / "dth-hammer.cyclonedx.json").write_text(text, encoding="utf-8")


def component(part: dict[str, str]) -> dict[str, Any]:
    """Returns a crate, or another linked component, for a bill of materials."""
    name, _, version = part["name"].rpartition(" ")
    found: dict[str, Any] = {"type": "library", "licenses": [{"expression": part["terms"]}]}
    if not version[:1].isdigit():
        return found | {"name": part["name"]}
    found |= {"name": name, "version": version}
    own = name in ("dth-hammer", "dth-fmu", "dth-native")
    return found if own else found | {"purl": f"pkg:cargo/{name}@{version}"}


def platform(wheel: Path) -> str:
    """Returns the platform of a wheel, as in the names of the .fmu files."""
    tag = wheel.stem.rpartition("-")[2]
    return next(name for name, pattern in TAGS.items() if re.fullmatch(pattern, tag))


def here() -> str:
    """Returns the platform of this machine."""
    machine = platforms.machine().lower().replace("amd64", "x86_64").replace("arm64", "aarch64")
    names = {"darwin": "macos-universal2", "win32": f"windows-{machine}"}
    return names.get(sys.platform, f"linux-{machine}")


def run(
    *arguments: str | Path, folder: Path | None = None, environment: dict[str, str] | None = None
) -> None:
    """Runs a module of this Python, and shows its output only if it fails."""
    command = [sys.executable, "-m", *map(str, arguments)]
    own = os.environ | (environment or {})
    done = subprocess.run(command, cwd=folder, env=own, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    print(wheel(Path(sys.argv[1]), Path(sys.argv[2])))
