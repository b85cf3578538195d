"""Other programs that tests run."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path


def ran(
    command: Sequence[str | Path] | str,
    where: Path | None = None,
    env: Mapping[str, str] | None = None,
) -> str:
    """Returns the output of a program, which must succeed."""
    done = subprocess.run(
        command,
        shell=isinstance(command, str),
        cwd=where,
        env=env,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}"
    return done.stdout
