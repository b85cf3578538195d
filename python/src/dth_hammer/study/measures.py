"""What a hammer is judged by: means of its long-run response, and what follows from these."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from .. import _native
from ..errors import UnknownNameError
from ..scene.mesh import BODIES
from ..scene.quantities import read
from ..scene.variables import whole
from . import longrun
from .fatigue import largest_stress
from .longrun import MEANS, Steady


def _mass(found: Steady, body: str) -> float:
    parts = np.array(_native.bodies(dict(found.parameters))[body]["sections"])
    return float(whole(found.parameters)["material.density"] * np.prod(parts, axis=1).sum())


#: Beside the means, by name: unit and value.
OTHERS: Mapping[str, tuple[str, Callable[[Steady], float]]] = {
    "power": ("W", lambda found: found["blow_energy"] * found["blow_frequency"]),
    **{f"{body}_mass": ("kg", partial(_mass, body=body)) for body in BODIES},
    **{f"{body}_stress": ("Pa", partial(largest_stress, body=body)) for body in BODIES},
}


def named(name: str) -> str:
    """Returns the name of a measure; raises if there is none."""
    if name not in MEANS and name not in OTHERS:
        raise UnknownNameError("mean", name, (*MEANS, *OTHERS))
    return name


def unit(name: str) -> str:
    """Unit of a measure."""
    return OTHERS[name][0] if name in OTHERS else longrun.unit(name)


def measure(given: str | Callable[[Steady], float]) -> Callable[[Steady], float]:
    """Returns the function that a name stands for, or one that reads what a function returns."""
    if callable(given):
        return lambda found: read(given(found), "1", getattr(given, "__name__", "the goal"))
    name = named(given)
    return OTHERS[name][1] if name in OTHERS else lambda found: found[name]
