"""Writes hashes.txt: of every pinned package, the SHA-256 of each file that the index has of it.

    pip install uv && python requirements/hashes.py

Nothing is resolved: the pins are those of the other files, complete as they are. Of versions for
some Pythons only, both the oldest and the newest Python's are taken.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
HASHES = FOLDER / "hashes.txt"
PYTHONS = ("3.10", "3.13")


def hashed(pins: str, python: str) -> set[str]:
    """A line for each package: its version and its hashes, as pip reads them."""
    options = ["--no-deps", "--generate-hashes", "--no-header", "--no-annotate", "--quiet"]
    where = ["--python-version", python, "--python-platform", "x86_64-unknown-linux-gnu"]
    command = [sys.executable, "-m", "uv", "pip", "compile", *options, *where, "-"]
    done = subprocess.run(command, input=pins, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    joined = re.sub(r" \\\n\s+", " ", done.stdout)
    return {line.lower() for line in joined.splitlines() if "==" in line}


def main() -> None:
    """Reads the pins, asks the index, writes the file."""
    files = sorted(f for f in FOLDER.glob("*.txt") if f != HASHES)
    lines = {line for f in files for line in f.read_text("utf-8").splitlines()}
    pins = "\n".join(sorted(line for line in lines if "==" in line))
    found = set().union(*(hashed(pins, python) for python in PYTHONS))
    head = "# Written by requirements/hashes.py from the pins beside it.\n"
    HASHES.write_text(head + "\n".join(sorted(found)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
