"""The fatigue strength of a steel, as tests of its specimens give it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..contract import typed
from ..errors import DomainError
from ..frames import np
from . import quantities
from .variables import Array


@typed()
@dataclass(frozen=True)
class SNCurve:
    """An S-N line: ``N = cycles (strength / S)^slope`` cycles at the stress amplitude ``S``.

    Give numbers in SI units or text with units. There is no default, because the line depends on
    the steel, its surface and its heat treatment, and changes the hours by powers of ten.

    Example:
        >>> from dth_hammer import SNCurve
        >>> print(f"{SNCurve('300 MPa', 1e7, 8).damage(300e6, 0.0):.0e} of the life per cycle")
        1e-07 of the life per cycle
    """

    #: Stress amplitude (half of the range) that the steel survives ``cycles`` times, Pa.
    strength: Any
    cycles: float
    #: Exponent, above 0 and at most 50.
    slope: float
    #: Ultimate strength, Pa. If it is given, a tensile mean stress shortens the life (Goodman):
    #: ``S = amplitude / (1 - mean / ultimate)``.
    ultimate: Any = None

    def __post_init__(self) -> None:
        for name, unit in (("strength", "Pa"), ("ultimate", "Pa"), ("cycles", "1"), ("slope", "1")):
            value = getattr(self, name)
            if value is None:
                continue
            number = quantities.read(value, unit, name)
            high = 50.0 if name == "slope" else math.inf
            if not (math.isfinite(number) and 0.0 < number <= high):
                text = " and at most 50" if name == "slope" else ""
                raise DomainError(f"{name} = {number:g} must be finite, above 0{text}")
            object.__setattr__(self, name, number)

    @classmethod
    def read(cls, text: str) -> SNCurve:
        """Reads text: ``300 MPa,1e7,8``, or with the ultimate strength ``300 MPa,1e7,8,1 GPa``."""
        parts = [part.strip() for part in text.split(",")]
        try:
            cycles, slope = map(float, parts[1:3])
        except ValueError:
            parts = []
        if len(parts) not in (3, 4):
            form = "STRENGTH,CYCLES,SLOPE with or without ULTIMATE, as 300 MPa,1e7,8"
            raise DomainError(f"{text!r} is not {form}")
        return cls(parts[0], cycles, slope, *parts[3:])

    def damage(self, amplitude: Array, mean: Array) -> Array:
        """Returns the share of the life that a cycle with this amplitude and mean (Pa) consumes."""
        stress = np.asarray(amplitude, float)
        if self.ultimate is not None:
            left = 1.0 - np.maximum(mean, 0.0) / self.ultimate
            stress = np.where(left > 0.0, stress / np.where(left > 0.0, left, 1.0), np.inf)
        return np.asarray((stress / self.strength) ** self.slope / self.cycles)
