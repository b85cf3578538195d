"""From what a datasheet says to parameters: `from_datasheet`.

The drive is the relay: a constant force ``F`` that throws the piston at the bit, and lifts
it until it is ``D`` above the bit. A piston of mass ``m`` that leaves the bit with the share ``e``
of its impact speed ``v`` turns at the height ``S`` and comes back after the period ``T``:

    W = m v^2 / 2,    W (1 - e^2) = 2 F D
    w^2 = (e v)^2 + 2 (F/m - g) D,    S = D + w^2 / (2 (F/m + g))
    T = (w - e v) / (F/m - g) + (w + v) / (F/m + g)

Only ``e`` is not of the drive but of the blow: how the bit and the rock throw the piston back. It
is taken from runs, until energy and frequency are those of the datasheet.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from . import quantities
from .errors import DomainError, TooFewBlowsError
from .hammer import Hammer
from .variables import VARIABLES, Value, numbers, whole

#: Runs at most, and how close energy and frequency must come.
ROUNDS, CLOSE = 30, 5e-3
#: A run lasts this many blows: from rest, the reference hammer settles in seven.
BLOWS = 25
#: Share of the supply pressure that drives the piston on the mean, unless it is given: losses in
#: ports and the counter-pressure of the exhaust take the rest.
EFFECTIVE = 0.5
#: Bit that the reference rock's parameters are taken for, m: that of a 3 inch hammer.
OWN_BIT = 0.09


@dataclass(frozen=True)
class Datasheet:
    """A hammer made from a datasheet: its parameters, and what had to be assumed."""

    #: For `simulate`, `Hammer` or `sweep`.
    parameters: Mapping[str, float]
    #: Sentences: what the datasheet did not say.
    assumed: tuple[str, ...]
    #: What a run gives with these parameters, and what follows from them: name, number, unit.
    found: tuple[tuple[str, float, str], ...]

    def __str__(self) -> str:
        rows = [*_named(self.parameters), "found:"]
        rows += [f"  {name}: {number:.4g} {unit}" for name, number, unit in self.found]
        return "\n".join([*rows, "assumed:", *(f"  {text}" for text in self.assumed)])

    def _repr_html_(self) -> str:
        cells = [f"<tr><td>{n}</td><td>{x:.4g} {u}</td></tr>" for n, x, u in self.found]
        names = [f"<tr><td><code>{n}</code></td><td>{x:.6g}</td></tr>" for n, x in _items(self)]
        texts = [f"<li>{text}</li>" for text in self.assumed]
        return f"<table>{''.join(names + cells)}</table><ul>{''.join(texts)}</ul>"


def _items(sheet: Datasheet) -> list[tuple[str, float]]:
    return [*sheet.parameters.items()]


def _named(parameters: Mapping[str, float]) -> list[str]:
    return [f"{name} = {number:.6g}" for name, number in parameters.items()]


def from_datasheet(
    *,
    piston_mass: Value,
    blow_energy: Value | None = None,
    frequency: Value | None = None,
    pressure: Value | None = None,
    bore: Value | None = None,
    stroke: Value | None = None,
    effectiveness: float = EFFECTIVE,
    piston_length: Value | None = None,
    bit_mass: Value | None = None,
    bit_diameter: Value | None = None,
    feed_force: Value | None = None,
    preset: str | None = None,
) -> Datasheet:
    """Parameters of a hammer that strikes as a datasheet says.

    Give either ``blow_energy`` and ``frequency``, or ``pressure``, ``bore`` and ``stroke``.
    Numbers are in SI units (kg, J, Hz, Pa, m, N); text may carry any other, for instance
    ``"1800 1/min"`` or ``"250 psi"``.

    Args:
        piston_mass: of the piston.
        blow_energy: of the piston just before it meets the bit.
        frequency: blows per time.
        pressure: of the supply, over that of the exhaust.
        bore: diameter on which the pressure acts.
        stroke: from the bit to where the piston turns.
        effectiveness: mean driving pressure over the supply's, with ``pressure`` only.
        piston_length: if not given, as slender as the reference piston.
        bit_mass: if not given, the bit is as long as the piston.
        bit_diameter: of the hole; scales the rock's parameters by the hole's area.
        feed_force: if not given, the reference's.
        preset: rock to drill; the reference rock if not given.
    """
    sheet = _Sheet(preset)
    mass = _positive(piston_mass, "kg", "piston_mass")
    sheet.bodies(mass, piston_length, bit_mass)
    if feed_force is not None:
        sheet.set("feed_force", VARIABLES["feed_force"].number(feed_force))
    sheet.rock(bit_diameter)
    by_blow, by_air = (blow_energy, frequency), (pressure, bore, stroke)
    if all(x is not None for x in by_blow):
        energy = _positive(blow_energy, "J", "blow_energy")
        period = 1.0 / _positive(frequency, "Hz", "frequency")
        sheet.strike(mass, energy, period)
        if pressure is not None and bore is not None:
            area = math.pi / 4 * _positive(bore, "m", "bore") ** 2
            share = sheet.numbers["drive.amplitude"] / area
            share /= _positive(pressure, "Pa", "pressure")
            sheet.found.append(("mean driving pressure over the supply's", share, ""))
    elif all(x is not None for x in by_air):
        area = math.pi / 4 * _positive(bore, "m", "bore") ** 2
        if not 0.0 < effectiveness <= 1.0:
            raise DomainError(f"effectiveness = {effectiveness:g} is not above 0 and at most 1")
        force = effectiveness * _positive(pressure, "Pa", "pressure") * area
        sheet.assumed.append(
            f"The mean driving pressure is {effectiveness:g} of the supply's (effectiveness)."
        )
        sheet.throw(mass, force, _positive(stroke, "m", "stroke"))
    else:
        raise DomainError(
            "give blow_energy and frequency, or pressure, bore and stroke: there is no hammer else"
        )
    return Datasheet(sheet.numbers, tuple(sheet.assumed), tuple(sheet.found))


class _Sheet:
    """The parameters as they come to be."""

    def __init__(self, preset: str | None) -> None:
        self.numbers = numbers(preset, None)
        self.assumed: list[str] = []
        self.found: list[tuple[str, float, str]] = []
        self.gravity = self.own("gravity")

    def own(self, name: str) -> float:
        """The value so far: what was set, or the reference's."""
        return whole(self.numbers)[name]

    def set(self, name: str, number: float) -> None:
        """Sets one, within its domain."""
        self.numbers[name] = VARIABLES.settable(name).number(number)

    def bodies(self, mass: float, length: Value | None, bit_mass: Value | None) -> None:
        """Section and lengths from masses; a mesh and a penalty alike in proportion."""
        density, own_length = self.own("material.density"), self.own("piston.length")
        own_mass = density * self.own("cross_section") * own_length
        if length is None:
            chosen = own_length * (mass / own_mass) ** (1 / 3)
            self.assumed.append("The piston is as slender as the reference hammer's.")
        else:
            chosen = _positive(length, "m", "piston_length")
        section = mass / (density * chosen)
        if bit_mass is None:
            bit = chosen
            self.assumed.append("The bit is as long and as heavy as the piston.")
        else:
            bit = _positive(bit_mass, "kg", "bit_mass") / (density * section)
        self.assumed.append("Piston and bit have one section, constant along them.")
        per_metre = self.own("piston.elements") / own_length
        stiffness = self.own("contact.stiffness") * section / self.own("cross_section")
        for name in ("piston.segments", "bit.segments"):
            self.set(name, 0.0)
        self.set("piston.length", chosen)
        self.set("bit.length", bit)
        self.set("cross_section", section)
        self.set("contact.stiffness", stiffness)
        most = VARIABLES["bit.elements"].maximum or math.inf
        for name, size in (("piston.elements", chosen), ("bit.elements", bit)):
            self.set(name, min(most, max(1.0, float(round(per_metre * size)))))

    def rock(self, diameter: Value | None) -> None:
        """Stiffness, viscosity and barrier grow with the area of the hole."""
        if diameter is None:
            self.assumed.append(f"The rock is that under a bit of {OWN_BIT * 1e3:g} mm.")
            return
        share = (_positive(diameter, "m", "bit_diameter") / OWN_BIT) ** 2
        for name in ("rock.stiffness", "rock.viscosity", "rock.energy_barrier"):
            self.set(name, self.own(name) * share)
        self.assumed.append(
            f"The rock's stiffness, viscosity and barrier are the preset's, meant for a bit of "
            f"{OWN_BIT * 1e3:g} mm, times {share:.3g}: in proportion to the hole's area."
        )

    def strike(self, mass: float, energy: float, period: float) -> None:
        """Force and stroke of the relay for an energy and a period, from runs."""
        rebound, flight = 0.4, period
        for _ in range(ROUNDS):
            force, lift = _relay(mass, energy, flight, rebound, self.gravity)
            self._drive(force, lift)
            simulated_energy, simulated_period, blow = self._run(period)
            self.found = self._result(mass, force, lift, simulated_energy, simulated_period)
            if max(abs(simulated_energy / energy - 1), abs(simulated_period / period - 1)) < CLOSE:
                return
            lost = 2.0 * force * lift / simulated_energy
            rebound = 0.5 * (rebound + math.sqrt(min(0.98, max(0.0, 1.0 - lost))))
            # The equations know of flight only: the blow itself takes its time too.
            flight *= period / simulated_period
        raise DomainError(
            f"no steady blow of {energy:g} J at {1 / period:g} Hz was found: the last run gave "
            f"{simulated_energy:.4g} J at {1 / simulated_period:.4g} Hz, after {blow:g} blows"
        )

    def throw(self, mass: float, force: float, stroke: float) -> None:
        """Force and stroke of the relay for a force and the height where the piston turns."""
        rebound = 0.4
        for _ in range(ROUNDS):
            lift = _lift(mass, force, stroke, rebound, self.gravity)
            self._drive(force, lift)
            guess = 2.0 * math.sqrt(2.0 * mass * stroke / force)
            energy, period, _ = self._run(guess)
            self.found = self._result(mass, force, lift, energy, period)
            new = math.sqrt(min(0.98, max(0.0, 1.0 - 2.0 * force * lift / energy)))
            if abs(new - rebound) < CLOSE:
                return
            rebound = 0.5 * (rebound + new)
        raise DomainError("no steady blow was found for that pressure, bore and stroke")

    def _drive(self, force: float, lift: float) -> None:
        self.set("drive.amplitude", force)
        self.set("drive.stroke", lift)
        self.set("contact.initial_gap", lift)

    def _run(self, period: float) -> tuple[float, float, float]:
        """Energy and period of the last blow, and how many there were."""
        with Hammer(self.numbers, quiet=True) as hammer:
            hammer.advance(BLOWS * period)
            energy, blow_period, blows = hammer.get(
                ("blow_energy", "blow_period", "blow_count")
            ).values()
        if blows < 3 or not blow_period:
            raise TooFewBlowsError(
                f"the hammer stops after {blows} blows: weaker than what is asked of it"
            )
        return energy, blow_period, blows

    def _result(
        self, mass: float, force: float, lift: float, energy: float, period: float
    ) -> list[tuple[str, float, str]]:
        rebound = math.sqrt(max(0.0, 1.0 - 2.0 * force * lift / energy))
        return [
            ("blow energy", energy, "J"),
            ("frequency", 1.0 / period, "Hz"),
            ("impact speed", math.sqrt(2.0 * energy / mass), "m/s"),
            ("driving force", force, "N"),
            ("height where the piston turns", self._height(mass, force, lift, rebound), "m"),
            ("rebound of the piston over its impact speed", rebound, ""),
        ]

    def _height(self, mass: float, force: float, lift: float, rebound: float) -> float:
        return lift * lift / _lift(mass, force, lift, rebound, self.gravity)


def _relay(
    mass: float, energy: float, period: float, rebound: float, gravity: float
) -> tuple[float, float]:
    """Force and stroke of the relay for an energy and a period, by bisection for the force."""
    speed = math.sqrt(2.0 * energy / mass)
    work = energy * (1.0 - rebound**2)

    def lasts(force: float) -> float:
        up, down = force / mass - gravity, force / mass + gravity
        turn = math.sqrt((rebound * speed) ** 2 + up * work / force)
        return (turn - rebound * speed) / up + (turn + speed) / down

    low, high = mass * abs(gravity) * (1.0 + 1e-9) + 1e-9, 1e9
    if lasts(low) < period:
        slowest = 1.0 / lasts(low)
        raise DomainError(
            f"{1 / period:.3g} Hz is too slow: a piston of {mass:g} kg that strikes with "
            f"{energy:g} J and is lifted against gravity strikes at {slowest:.3g} Hz or more"
        )
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if lasts(middle) > period else (low, middle)
    return low, work / (2.0 * low)


def _lift(mass: float, force: float, stroke: float, rebound: float, gravity: float) -> float:
    """Stroke of the relay for a force and the height ``S`` where the piston turns.

    With ``W = 2 F D / (1 - e^2)`` the height is in proportion to ``D``.
    """
    up, down = force / mass - gravity, force / mass + gravity
    if not up > 0.0:
        raise DomainError(f"{force:.4g} N do not lift a piston of {mass:g} kg")
    carried = rebound**2 / (1.0 - rebound**2)
    # w^2 / D = 4 F/m e^2 / (1 - e^2) + 2 (F/m - g)
    return stroke / (1.0 + (4.0 * force / mass * carried + 2.0 * up) / (2.0 * down))


def _positive(value: object, unit: str, name: str) -> float:
    number = quantities.read(value, unit, name)
    if not (math.isfinite(number) and number > 0.0):
        raise DomainError(f"{name} = {number:g} {unit} is not finite and above 0")
    return number
