"""What every test run of this checkout shares: in CI nothing is skipped that can be installed."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Generator

import pytest

# Tests start some hundred interpreters, each of which would compile what it imports.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
# A test process for each core: more threads of NumPy's would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# The words by which a test says how what it lacks is had.
INSTALLABLE = re.compile("apt install|cargo lab")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Fails with CI set what is skipped only because something is not installed."""
    report = yield
    if os.environ.get("CI") and report.skipped and INSTALLABLE.search(str(report.longrepr)):
        report.outcome = "failed"
    return report
