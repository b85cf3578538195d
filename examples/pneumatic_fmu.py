"""The pneumatic drive as an FMU of its own, to be coupled with the hammer by any master.

    pythonfmu build --file examples/pneumatic_fmu.py --dest dist

Inputs are the piston's position and velocity over the bit, outputs the two pressures.
"""

from __future__ import annotations

from dth_hammer import Motion
from dth_hammer.models.pneumatic import PneumaticDrive
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class PneumaticHammerDrive(Fmi2Slave):
    """Two air chambers whose ports the piston opens."""

    author = "The dth-hammer developers"
    description = "Air side of a pneumatic down-the-hole hammer"

    def __init__(self, **kwargs: object) -> None:
        super().__init__(**kwargs)
        self.drive = PneumaticDrive()
        self.relative_position = -self.drive.air.stroke / 2
        self.relative_velocity = 0.0
        self.drive_pressure = self.return_pressure = self.drive.air.exhaust_pressure
        for name in ("relative_position", "relative_velocity"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("drive_pressure", "return_pressure"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def exit_initialization_mode(self) -> None:
        """The chambers begin at rest where the piston stands."""
        self.drive.start(self.relative_position)
        self._show()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """One step, the piston held where the master says it is.

        A master may say it of the step's start or of its end, so nothing is extrapolated.
        """
        self.drive.advance(step_size, Motion.held(self.relative_position, self.relative_velocity))
        self._show()
        return True

    def _show(self) -> None:
        pressures = self.drive.outputs()
        self.drive_pressure = pressures["drive_pressure"]
        self.return_pressure = pressures["return_pressure"]
