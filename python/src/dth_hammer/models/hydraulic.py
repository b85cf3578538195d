"""The drive of a water hammer: pump, hose with line dynamics, and a valve that follows the piston.

The return chamber always has the pressure of the hose's end. A valve connects the drive chamber
with the hose or with the outlet. It switches at two positions of the piston (hysteresis), and its
spool moves with a lag. The hose is a chain of compliances and inertances with friction, between a
pump of constant pressure and the hammer. Water is stiff, so this coupling is harder than with air.
"""

import math
from dataclasses import dataclass

from . import Motion, State, runge_kutta


@dataclass(frozen=True)
class Water:
    """Parameters of an example water drive; positions are the hammer's ``relative_position``."""

    pump_pressure: float = 1.4e7  # Pa
    outlet_pressure: float = 2e5  # Pa
    bulk_modulus: float = 2.1e9  # Pa
    density: float = 1000.0  # kg/m3
    area_drive: float = 3.6e-4  # m2
    area_return: float = 1.8e-4  # m2
    chamber_volume: float = 1e-4  # m3, drive chamber with the piston on the bit
    hose_length: float = 4.0  # m
    hose_bore: float = 25e-3  # m
    hose_friction: float = 2e8  # Pa s/m3, whole hose
    hose_parts: int = 3
    accumulator: float = 4e-12  # m3/Pa at the hammer, its gas linearised
    port: float = 1.2e-4  # m2, valve fully open
    discharge: float = 0.65
    laminar: float = 5e5  # Pa: below this drop, flow is proportional to it
    valve_time: float = 5e-4  # s, first-order lag of the spool
    to_return: float = -8e-3  # m: with the piston below, the valve turns to the outlet
    to_drive: float = -30e-3  # m: with the piston above, it turns to the hose

    def parameters(self) -> dict[str, float | str]:
        """Returns the hammer's parameters that belong to this drive."""
        return {
            "drive.source": "Pressure",
            "drive.area_drive": self.area_drive,
            "drive.area_return": self.area_return,
        }


class WaterDrive:
    """The water drive as a partner for `dth_hammer.Coupling`.

    Its state has the drive chamber's pressure, the spool's position (-1 outlet, 1 hose), then
    pressure and flow of each part of the hose from the hammer to the pump. The valve's command
    (-1 or 1) is stored separately.
    """

    def __init__(self, water: Water | None = None, substep: float = 4e-6) -> None:
        self.water, self.substep = water or Water(), substep
        parameters, parts = self.water, self.water.hose_parts
        bore = math.pi / 4 * parameters.hose_bore**2
        self.compliance = bore * parameters.hose_length / parts / parameters.bulk_modulus
        self.inertance = parameters.density * parameters.hose_length / parts / bore
        self.friction = parameters.hose_friction / parts
        self.orifice = parameters.discharge * parameters.port * math.sqrt(2.0 / parameters.density)
        self.start()

    def start(self, _position: float = 0.0) -> None:
        """Starts with the drive chamber at the outlet's pressure and the valve open to the hose."""
        self.command = 1.0
        hose = (self.water.pump_pressure, 0.0) * self.water.hose_parts
        self.state = (self.water.outlet_pressure, 1.0, *hose)

    def outputs(self) -> dict[str, float]:
        """Returns the pressures that act on the hammer, Pa."""
        return {"drive_pressure": self.state[0], "return_pressure": self.state[2]}

    def advance(self, size: float, motion: Motion) -> None:
        """Integrates over ``size`` seconds by Runge-Kutta substeps, split where the valve turns."""
        steps = max(1, math.ceil(size / self.substep - 1e-9))
        for k in range(steps):
            start, end = size * k / steps, size * (k + 1) / steps
            turn = start + self._until_turn(motion(start)[0], motion(end)[0]) * (end - start)
            first = min(turn, end) - start
            self.state = runge_kutta(self._rates, self.state, start, first, motion)
            if turn < end:
                self.command = -self.command
                self.state = runge_kutta(self._rates, self.state, turn, end - turn, motion)

    def save(self) -> tuple[float, State]:
        """Returns the valve's command and the state."""
        return self.command, self.state

    def restore(self, state: tuple[float, State]) -> None:
        """Restores a saved state."""
        self.command, self.state = state

    def _until_turn(self, position: float, later: float) -> float:
        """Returns the share of a step after which the valve turns; infinity if it does not."""
        switch_position = self.water.to_return if self.command > 0.0 else self.water.to_drive
        before, after = (self.command * (place - switch_position) for place in (position, later))
        if before > 0.0:
            return 0.0
        return before / (before - after) if after > 0.0 else math.inf

    def _flow(self, share: float, drop: float) -> float:
        """Returns the flow through the valve, m3/s; turbulent, but laminar for small drops."""
        laminar = self.water.laminar
        return self.orifice * share * drop / math.sqrt(math.hypot(drop, laminar))

    def _rates(self, y: State, position: float, velocity: float) -> State:
        water, drive, spool, hose = self.water, y[0], y[1], y[2]
        inflow = self._flow(max(0.0, spool), hose - drive)
        outflow = self._flow(max(0.0, -spool), drive - water.outlet_pressure)
        volume = water.chamber_volume + water.area_drive * position
        rates = [
            water.bulk_modulus / volume * (inflow - outflow - water.area_drive * velocity),
            (self.command - spool) / water.valve_time,
        ]
        # Flow out of the hose's end: flow through the valve minus flow from the return chamber.
        drawn = inflow - water.area_return * velocity
        compliance = self.compliance + water.accumulator
        for k in range(2, len(y), 2):
            pressure, flow = y[k], y[k + 1]
            source = y[k + 2] if k + 2 < len(y) else water.pump_pressure
            rates.append((flow - drawn) / compliance)
            rates.append((source - pressure - self.friction * flow) / self.inertance)
            drawn, compliance = flow, self.compliance
        return tuple(rates)
