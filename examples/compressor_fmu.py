"""The compressor with its hose as an FMU, which any master can couple with the hammer.

    pythonfmu build --file examples/compressor_fmu.py --dest dist

Its input is the mass of air that the hammer has taken, its output the supply pressure.
"""

from __future__ import annotations

from dth_hammer.models.compressor import Supply
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class AirCompressor(Fmi2Slave):
    """A compressor, its receiver and a hose."""

    author = "The dth-hammer developers"
    description = "Compressor and hose that feed a down-the-hole hammer"

    def __init__(self, **kwargs: object) -> None:
        super().__init__(**kwargs)
        self.supply = Supply()
        self.air_mass, self.supply_pressure = 0.0, self.supply.pressure
        self.register_variable(Real("air_mass", causality=Fmi2Causality.input))
        self.register_variable(Real("supply_pressure", causality=Fmi2Causality.output))

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Makes one step, in which the hose loses the air that the hammer's total has grown by."""
        self.supply.advance(step_size, self.air_mass)
        self.supply_pressure = self.supply.pressure
        return True
