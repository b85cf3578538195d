"""Settings and helpers that tests of sweeps share."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

#: Duration of a run, s.
UNTIL = 0.15


@contextmanager
def forbidden_runs() -> Iterator[None]:
    """Makes every run in this process fail."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("dth_hammer.study.sweeping.parts_of", None)
        yield


def begun(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Starts a user's program as the leader of its own process group."""
    return subprocess.Popen(
        [sys.executable, *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def written(folder: Path, text: str) -> str:
    (folder / "script.py").write_text(text, encoding="utf-8")
    return "script.py"
