"""A pneumatic hammer: two air chambers whose ports the piston opens and closes.

Mass flow through the ports is that of an ideal gas through an orifice (choked or not),
the chambers are adiabatic, and the piston's position opens supply and exhaust.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from . import Motion, State, driven, runge_kutta

GAS, KAPPA = 287.05, 1.4  # J/(kg K) and ratio of heats of air
CHOKED = (2.0 / (KAPPA + 1.0)) ** (KAPPA / (KAPPA - 1.0))  # pressure ratio
# Beside equal pressures the orifice law has an infinite slope: straight from here on.
LAMINAR = 0.995
FLOW = math.sqrt(2.0 * KAPPA / ((KAPPA - 1.0) * GAS))


@dataclass(frozen=True)
class Air:
    """An example hammer's air side; positions are the hammer's ``relative_position``."""

    supply_pressure: float = 1.5e6  # Pa
    exhaust_pressure: float = 1e5  # Pa
    temperature: float = 300.0  # K, of the supply
    area: float = 1.5e-3  # m2, of either face of the piston
    drive_dead_volume: float = 6e-5  # m3, with the piston at the end of its stroke
    return_dead_volume: float = 5e-5  # m3, with the piston on the bit
    stroke: float = 0.07  # m
    drive_supply: float = -0.030  # m: open above (more negative)
    drive_exhaust: float = -0.020  # m: open below
    return_supply: float = -0.015  # m: open below
    return_exhaust: float = -0.035  # m: open above
    port_height: float = 4e-3  # m of travel from closed to open
    supply_port: float = 5e-5  # m2, open
    exhaust_port: float = 1.2e-4  # m2, open

    def parameters(self) -> dict[str, float | str]:
        """Returns the hammer's parameters that belong to this drive."""
        return driven(self.area, self.area)


def mass_flow(area: float, high: float, temperature: float, low: float) -> float:
    """Of an ideal gas through an orifice from the higher to the lower pressure (Pa), kg/s.

    ``A p sqrt(2 kappa / ((kappa - 1) R T)) sqrt(r**(2/kappa) - r**((kappa + 1)/kappa))`` with
    the ratio ``r`` of pressures, or the critical one if that is greater (choked flow).
    """
    ratio = low / high
    scale = 1.0
    if ratio > LAMINAR:
        scale, ratio = (1.0 - ratio) / (1.0 - LAMINAR), LAMINAR
    ratio = max(ratio, CHOKED)
    shape = ratio ** (2.0 / KAPPA) - ratio ** ((KAPPA + 1.0) / KAPPA)
    return scale * area * high * FLOW / math.sqrt(temperature) * math.sqrt(shape)


class PneumaticDrive:
    """The air's state and its rates; a partner for `dth_hammer.Coupling`.

    State: pressure (Pa) and mass (kg) of the drive chamber, then of the return chamber. A
    chamber is adiabatic: ``dp/dt = kappa (R (m'T)_in - p dV/dt) / V``.
    """

    def __init__(self, air: Air | None = None, substep: float = 1e-5) -> None:
        self.air, self.substep = air or Air(), substep
        self.state = self._at_rest(0.0)

    def start(self, position: float) -> None:
        """Both chambers at exhaust pressure, for a piston that stands here."""
        self.state = self._at_rest(position)

    def outputs(self) -> dict[str, float]:
        """Pressures for the hammer, Pa."""
        return {"drive_pressure": self.state[0], "return_pressure": self.state[2]}

    def slopes(self, position: float, velocity: float) -> dict[str, float]:
        """Their rates, Pa/s."""
        rates = self._rates(self.state, position, velocity)
        return {"drive_pressure": rates[0], "return_pressure": rates[2]}

    def advance(self, size: float, motion: Motion) -> None:
        """Classical Runge-Kutta steps, as many as the air needs."""
        count = max(1, math.ceil(size / self.substep - 1e-9))
        h = size / count
        for k in range(count):
            self.state = runge_kutta(self._rates, self.state, k * h, h, motion)

    def save(self) -> State:
        """Returns the state."""
        return self.state

    def restore(self, state: State) -> None:
        """Restores a saved state."""
        self.state = state

    def volumes(self, position: float) -> tuple[float, float]:
        """Of the drive and the return chamber; kept above their dead volume."""
        air = self.air
        drive = air.drive_dead_volume + air.area * max(0.0, air.stroke + position)
        return drive, air.return_dead_volume + air.area * max(0.0, -position)

    def _at_rest(self, position: float) -> State:
        pressure, temperature = self.air.exhaust_pressure, self.air.temperature
        drive, back = (pressure * v / (GAS * temperature) for v in self.volumes(position))
        return pressure, drive, pressure, back

    def _opening(self, beyond: float) -> float:
        """Open share of a port that the piston has passed by this much."""
        share = min(1.0, max(0.0, beyond / self.air.port_height))
        return share * share * (3.0 - 2.0 * share)

    def _rates(self, state: State, position: float, velocity: float) -> State:
        air, x = self.air, position
        pressure, mass, back_pressure, back_mass = state
        volume, back_volume = self.volumes(position)
        drive = self._chamber(
            (pressure, mass, volume, air.area * velocity),
            air.supply_port * self._opening(air.drive_supply - x),
            air.exhaust_port * self._opening(x - air.drive_exhaust),
        )
        back = self._chamber(
            (back_pressure, back_mass, back_volume, -air.area * velocity),
            air.supply_port * self._opening(x - air.return_supply),
            air.exhaust_port * self._opening(air.return_exhaust - x),
        )
        return *drive, *back

    def _chamber(
        self, chamber: tuple[float, float, float, float], supply: float, exhaust: float
    ) -> tuple[float, float]:
        """Rates of pressure and mass of an adiabatic chamber."""
        air = self.air
        pressure, mass, volume, swelling = chamber
        own = pressure * volume / (GAS * mass)
        gain = heat = 0.0  # kg/s, and kg K/s that flow in
        for area, outside, temperature in (
            (supply, air.supply_pressure, air.temperature),
            (exhaust, air.exhaust_pressure, air.temperature),
        ):
            if area == 0.0:
                continue
            if outside > pressure:
                flow = mass_flow(area, outside, temperature, pressure)
                gain, heat = gain + flow, heat + flow * temperature
            else:
                flow = mass_flow(area, pressure, own, outside)
                gain, heat = gain - flow, heat - flow * own
        return KAPPA * (GAS * heat - pressure * swelling) / volume, gain
