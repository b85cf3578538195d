"""Measures that a design is judged by: long-run means, and quantities derived from them."""

from collections.abc import Callable, Mapping
from functools import partial

from .. import _native
from ..errors import UnknownNameError
from ..frames import np
from ..scene.mesh import BODIES
from ..scene.quantities import read
from ..scene.variables import whole
from . import longrun
from .fatigue import largest_stress
from .longrun import MEANS, Steady


def _mass(response: Steady, body: str) -> float:
    parts = np.array(_native.bodies(dict(response.parameters))[body]["sections"])
    return float(whole(response.parameters)["material.density"] * np.prod(parts, axis=1).sum())


#: Measures other than the means: unit and function, by name.
OTHERS: Mapping[str, tuple[str, Callable[[Steady], float]]] = {
    "power": ("W", lambda response: response["blow_energy"] * response["blow_frequency"]),
    **{f"{body}_mass": ("kg", partial(_mass, body=body)) for body in BODIES},
    **{f"{body}_stress": ("Pa", partial(largest_stress, body=body)) for body in BODIES},
}


def named(name: str) -> str:
    """Returns the name; raises an `UnknownNameError` if no measure has it."""
    if name not in MEANS and name not in OTHERS:
        raise UnknownNameError("mean", name, (*MEANS, *OTHERS))
    return name


def unit(name: str) -> str:
    """Returns the unit of a measure."""
    return OTHERS[name][0] if name in OTHERS else longrun.unit(name)


def measure(given: str | Callable[[Steady], float]) -> Callable[[Steady], float]:
    """Returns a measure as a function of a `Steady`, from its name or from a user's function.

    The value that a user's function returns is checked to be a number without a unit.
    """
    if callable(given):
        return lambda response: read(given(response), "1", getattr(given, "__name__", "the goal"))
    name = named(given)
    return OTHERS[name][1] if name in OTHERS else lambda response: response[name]
