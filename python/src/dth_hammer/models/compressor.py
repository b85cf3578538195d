"""A compressor with its receiver and a hose, which supplies an air-driven hammer.

The compressor delivers its full flow up to the rated pressure. Above it, the regulator closes the
intake over a band of pressure. The air in receiver and hose stays at ambient temperature and has
one common pressure. At the hammer's end of the hose the pressure is lower because of friction, as
in a long pipe: ``p1^2 - p2^2 = (f L / D) R T (flow / section)^2``. To couple it, set
`drive.source = Air` on the hammer, and connect its input ``supply_pressure`` and its output
``air_mass``.
"""

import math
from dataclasses import dataclass

GAS = 287.05  # J/(kg K), of air
FREE = 101_325.0 / (GAS * 273.15)  # kg/m3, of free air: 0 degC and 1.01325 bar


@dataclass(frozen=True)
class Compressor:
    """An example compressor; pressures are absolute."""

    capacity: float = 20.0 / 60.0  # m3/s of free air
    rated_pressure: float = 25e5  # Pa: up to here it delivers its full capacity
    band: float = 1e5  # Pa, over which the regulator closes the intake
    receiver: float = 0.02  # m3
    temperature: float = 300.0  # K
    hose_length: float = 15.0  # m
    hose_bore: float = 51e-3  # m
    friction_factor: float = 0.02  # Darcy's


class Supply:
    """The air supply's state: the mass of air (kg) held in receiver and hose.

    `delivered` and `taken` are the masses (kg) that came from the compressor and went to the
    hammer since the start.
    """

    def __init__(self, compressor: Compressor | None = None, substep: float = 1e-3) -> None:
        self.compressor, self.substep = compressor or Compressor(), substep
        c = self.compressor
        section = math.pi / 4 * c.hose_bore**2
        heat = GAS * c.temperature  # p V = m R T
        self._per_mass = heat / (c.receiver + section * c.hose_length)
        self._friction = c.friction_factor * c.hose_length / c.hose_bore * heat / section**2
        self.held = c.rated_pressure / self._per_mass
        self.delivered = self.taken = 0.0
        self.pressure = c.rated_pressure  # at the hammer's end of the hose, Pa

    def advance(self, size: float, air_mass: float) -> None:
        """Integrates over a step of ``size`` seconds.

        ``air_mass`` is the total mass of air (kg) that the hammer has taken by the end of the step.
        """
        flow = (air_mass - self.taken) / size
        steps = max(1, math.ceil(size / self.substep - 1e-9))
        h = size / steps
        for _ in range(steps):
            # Heun's method. The same inflow is added to `held` and `delivered`, so that the mass
            # balance closes.
            first = self._delivery(self.held)
            inflow = 0.5 * (first + self._delivery(self.held + h * (first - flow)))
            self.held += h * (inflow - flow)
            self.delivered += h * inflow
        self.taken = air_mass
        square = (self._per_mass * self.held) ** 2 - self._friction * flow * abs(flow)
        self.pressure = math.sqrt(max(0.0, square))

    def _delivery(self, held: float) -> float:
        """Returns the mass flow from the compressor, kg/s, with this mass of air held."""
        c = self.compressor
        opening = (c.rated_pressure + c.band - self._per_mass * held) / c.band
        return FREE * c.capacity * min(1.0, max(0.0, opening))
