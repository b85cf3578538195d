"""A pneumatic hammer: two air chambers whose ports the piston opens and closes.

    python examples/pneumatic.py            # one second, a table of blows, a figure

Mass flow through the ports is that of an ideal gas through an orifice (choked or not),
the chambers are adiabatic, and the piston's position opens supply and exhaust. The air
drives the FMU's piston through `drive_pressure` and `return_pressure`.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import pandas as pd
from dth_hammer import Coupling, Hammer, blows
from dth_hammer.figures import BIT, DARK, PISTON, STYLE
from matplotlib.figure import Figure

LOOK = 5e-4  # s: how often pressures are noted, finer than a blow
SHOWN = 0.15  # s: the end of a run that is drawn

GAS, KAPPA = 287.05, 1.4  # J/(kg K) and ratio of heats of air
CHOKED = (2.0 / (KAPPA + 1.0)) ** (KAPPA / (KAPPA - 1.0))  # pressure ratio
# Beside equal pressures the orifice law has an infinite slope: straight from here on.
LAMINAR = 0.995
FLOW = math.sqrt(2.0 * KAPPA / ((KAPPA - 1.0) * GAS))


@dataclass(frozen=True)
class Air:
    """An example hammer's air side; positions are the FMU's `relative_position`."""

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


def mass_flow(area: float, high: float, temperature: float, low: float) -> float:
    """Through an orifice from the higher to the lower pressure, kg/s."""
    ratio = low / high
    scale = 1.0
    if ratio > LAMINAR:
        scale, ratio = (1.0 - ratio) / (1.0 - LAMINAR), LAMINAR
    ratio = max(ratio, CHOKED)
    shape = ratio ** (2.0 / KAPPA) - ratio ** ((KAPPA + 1.0) / KAPPA)
    return scale * area * high * FLOW / math.sqrt(temperature) * math.sqrt(shape)


State = tuple[float, float, float, float]  # pressure and mass: drive, return


class PneumaticDrive:
    """The air's state and its rates; a partner for `dth_hammer.Coupling`."""

    def __init__(self, air: Air | None = None, substep: float = 1e-5) -> None:
        self.air, self.substep = air or Air(), substep
        self.state = self._at_rest(0.0)

    def start(self, position: float) -> None:
        """Both chambers at exhaust pressure, for a piston that stands here."""
        self.state = self._at_rest(position)

    def outputs(self) -> dict[str, float]:
        """Pressures for the FMU."""
        return {"drive_pressure": self.state[0], "return_pressure": self.state[2]}

    def slopes(self, position: float, velocity: float) -> dict[str, float]:
        """Their rates."""
        rates = self._rates(self.state, position, velocity)
        return {"drive_pressure": rates[0], "return_pressure": rates[2]}

    def advance(self, size: float, motion: Callable[[float], tuple[float, float]]) -> None:
        """Classical Runge-Kutta steps, as many as the air needs."""
        count = max(1, math.ceil(size / self.substep - 1e-9))
        h = size / count
        for k in range(count):
            first, middle, last = motion(k * h), motion((k + 0.5) * h), motion((k + 1) * h)
            y = self.state
            a = self._rates(y, *first)
            b = self._rates(_along(y, a, h / 2), *middle)
            c = self._rates(_along(y, b, h / 2), *middle)
            d = self._rates(_along(y, c, h), *last)
            mean = tuple((p + 2 * q + 2 * r + s) / 6 for p, q, r, s in zip(a, b, c, d, strict=True))
            self.state = _along(y, mean, h)

    def save(self) -> State:
        """The state."""
        return self.state

    def restore(self, state: State) -> None:
        """Goes back to a saved state."""
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


def _along(y: State, rate: tuple[float, ...], h: float) -> State:
    return tuple(a + h * b for a, b in zip(y, rate, strict=True))  # type: ignore[return-value]


def parameters(air: Air) -> dict[str, float | str]:
    """What the FMU must know of the air side."""
    return {
        "drive.source": "Pressure",
        "drive.area_drive": air.area,
        "drive.area_return": air.area,
    }


def run(until: float, step: float = 2e-5) -> pd.DataFrame:
    """The coupled hammer's blows, and both pressures every half millisecond."""
    drive, rows = PneumaticDrive(), []
    names = ["relative_position", "blow_count", "blow_time", "blow_period", "blow_speed", "rop"]
    with Hammer(parameters(drive.air)) as hammer:
        drive.start(hammer["relative_position"])
        coupling = Coupling(hammer, drive, step)
        while hammer.time < until:
            coupling.advance(min(until, hammer.time + LOOK))
            rows.append({"time": hammer.time} | drive.outputs() | hammer.get(names))
    return pd.DataFrame(rows).set_index("time")


def draw(frame: pd.DataFrame) -> Figure:
    """Both pressures and the piston's position over the last blows."""
    part = frame[frame.index > frame.index[-1] - SHOWN]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 4.5), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        for name, colour, label in (
            ("drive_pressure", PISTON, "drive"),
            ("return_pressure", BIT, "return"),
        ):
            upper.plot(part.index, part[name] * 1e-5, color=colour, label=label)
        upper.set_ylabel("pressure (bar)")
        figure.legend(loc="outside upper center", ncols=2)
        lower.plot(part.index, part["relative_position"] * 1e3, color=DARK)
        lower.set_ylabel("piston over bit (mm)")
        lower.set_xlabel("time (s)")
    return figure


def main() -> None:
    """Runs it, prints its blows, draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--until", type=float, default=1, help="seconds")
    parser.add_argument("--out", type=Path, default=Path("pneumatic.png"), help="figure to write")
    options = parser.parse_args()
    frame = run(options.until)
    print(blows(frame)[["blow_time", "blow_period", "blow_speed", "rop"]])
    draw(frame).savefig(options.out)


if __name__ == "__main__":
    main()
