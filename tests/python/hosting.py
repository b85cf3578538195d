"""The scene of the tests of hosts, and the comparison of two trajectories."""

from __future__ import annotations

import sys
import sysconfig
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

# This time includes the first blow, its collisions and the bit's drilling cycles.
END, STEP = 0.06, 1e-3
# Not the defaults, so that a host that drops a start value is noticed.
SCENE = {"rock.stiffness": 1.6e8, "drive.amplitude": 2.8e3, "feed_force": 6e3}
# Peaks over the last communication step depend on the host's communication points.
PEAKS = ("contact_force_peak", "rock_force_peak")

Trajectory = Mapping[str, Sequence[float]]

in_python = pytest.mark.skipif(
    sys.platform != "win32" and not sysconfig.get_config_var("Py_ENABLE_SHARED"),
    reason="the drive is an FMU in Python, which needs Python as a shared library",
)


def simulated(
    fmu: Path, outputs: Sequence[str], *, step: float = STEP, **more: Any
) -> Mapping[str, np.ndarray]:
    """Returns fmpy's time and outputs for an FMU, in the scene or with other values."""
    ways: dict[str, Any] = {"stop_time": END, "start_values": SCENE, "output": outputs, **more}
    result = fmpy.simulate_fmu(str(fmu), step_size=step, output_interval=step, **ways)
    return {name: result[name] for name in ("time", *outputs)}


def assert_same(found: Trajectory, expected: Trajectory) -> None:
    """Each variable, at every point, to 1e-9 of its largest magnitude.

    Hosts differ in how they round a communication point: n * step, or a sum of steps that
    after n of them is off by n units of its last place, here 60 * 7e-18 s = 4e-16 s. The
    fastest variable, a collision's force, takes 1e-5 s to its peak: 4e-11 of it.
    """
    largest = {name: np.abs(values).max() for name, values in expected.items()}
    # The residual is itself a rounding error, so its scale is the work done.
    if "energy_residual" in largest:
        largest["energy_residual"] = largest["energy_drive"]
    for name, values in expected.items():
        assert len(found[name]) == len(values), name
        np.testing.assert_allclose(
            found[name], values, rtol=0.0, atol=1e-9 * largest[name], err_msg=name
        )
