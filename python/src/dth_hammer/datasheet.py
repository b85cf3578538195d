"""From what a datasheet says to parameters: `from_datasheet`. The engine solves it, see
`hammer::datasheet`; here are units and tables.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from . import _native, quantities
from .errors import DomainError, warn
from .variables import VARIABLES, Value, numbers


@dataclass(frozen=True)
class Datasheet:
    """A hammer made from a datasheet: its parameters, and what had to be assumed."""

    #: For `simulate`, `Hammer` or `sweep`.
    parameters: Mapping[str, float]
    #: Sentences: what the datasheet did not say.
    assumed: tuple[str, ...]
    #: What simulated blows give with these parameters, and what follows: name, number, unit.
    found: tuple[tuple[str, float, str], ...]
    #: What was given, and what the hammer has: name, given, of the hammer, unit.
    compared: tuple[tuple[str, float, float, str], ...] = ()
    #: Sentences: what was given cannot be had at once, and by how much.
    contradictions: tuple[str, ...] = ()

    def __str__(self) -> str:
        rows = [f"{name} = {number:.6g}" for name, number in self.parameters.items()]
        rows += ["found:", *(f"  {name}: {number:.4g} {unit}" for name, number, unit in self.found)]
        rows += ["given, and of this hammer:"]
        rows += [
            f"  {name}: {given:.4g} {unit}, {own:.4g} {unit} ({100 * (own / given - 1):+.1f} %)"
            for name, given, own, unit in self.compared
        ]
        rows += ["assumed:", *(f"  {text}" for text in self.assumed)]
        if self.contradictions:
            rows += ["contradictions:", *(f"  {text}" for text in self.contradictions)]
        return "\n".join(rows)

    def _repr_html_(self) -> str:
        cells = [f"<tr><td>{n}</td><td>{x:.4g} {u}</td></tr>" for n, x, u in self.found]
        names = [
            f"<tr><td><code>{n}</code></td><td>{x:.6g}</td></tr>"
            for n, x in self.parameters.items()
        ]
        texts = [f"<li>{text}</li>" for text in (*self.contradictions, *self.assumed)]
        return f"<table>{''.join(names + cells)}</table><ul>{''.join(texts)}</ul>"


def from_datasheet(
    *,
    piston_mass: Value | None = None,
    blow_energy: Value | None = None,
    frequency: Value | None = None,
    impact_speed: Value | None = None,
    pressure: Value | None = None,
    bore: Value | None = None,
    stroke: Value | None = None,
    power: Value | None = None,
    air_flow: Value | None = None,
    oil_flow: Value | None = None,
    rop: Value | None = None,
    effectiveness: Value | None = None,
    piston_length: Value | None = None,
    bit_mass: Value | None = None,
    bit_diameter: Value | None = None,
    damping_ratio: Value | None = None,
    feed_force: Value | None = None,
    specific_energy: Value | None = None,
    rock: Mapping[str, Value] | None = None,
    preset: str | None = None,
) -> Datasheet:
    """Parameters of a hammer that strikes as a datasheet says, as nearly as any does.

    Give what is known: energy and frequency, or pressure, bore and stroke, or any mixture, with the
    piston's mass or what it follows from. All of it is fitted at once; what contradicts is told
    (`Datasheet.contradictions`, and a warning). Numbers are in SI units (kg, J, Hz, Pa, m, N,
    m3/s); text may carry any other, for instance ``"1800 bpm"``, ``"350 ft.lbf"`` or ``"250 psi"``.

    Args:
        piston_mass: of the piston.
        blow_energy: of the piston just before it meets the bit.
        frequency: blows per time.
        impact_speed: of the piston just before it meets the bit.
        pressure: of the supply, over that of the exhaust.
        bore: diameter on which the pressure acts.
        stroke: from the bit to where the piston turns.
        power: of the blows: energy times frequency.
        air_flow: of free air; it works at the supply's pressure.
        oil_flow: of oil or water.
        rop: a measured rate of penetration: with ``bit_diameter`` it says the specific energy.
        effectiveness: mean driving pressure over the supply's, if it is known.
        piston_length: if not given, as slender as the reference piston.
        bit_mass: if not given, the bit is as long as the piston.
        bit_diameter: of the hole; scales the preset's rock by the hole's area.
        damping_ratio: of the piston's first elastic mode; half a per cent is assumed.
        feed_force: if not given, the reference's.
        specific_energy: of the rock, J/m3.
        rock: the rock's parameters under this very bit, as `dth_hammer.rock` gives them.
        preset: rock to drill; the reference rock if not given.

    Raises:
        DomainError: a number that no hammer has; too little to find one.
    """
    own = numbers(preset, rock)
    if feed_force is not None:
        own["feed_force"] = VARIABLES["feed_force"].number(feed_force)
    if specific_energy is not None:
        name = "rock.specific_energy"
        own[name] = VARIABLES[name].number(specific_energy)
    arguments = {name: value for name, value in locals().items() if name in UNITS}
    given = {
        name: quantities.read(value, UNITS[name], name)
        for name, value in arguments.items()
        if value is not None
    }
    for name, number in given.items():
        if not math.isfinite(number):
            raise DomainError(f"{name} = {number:g} is not finite")
    solved = _native.datasheet(given, rock is not None, own)
    if solved["contradictions"]:
        warn(" ".join(solved["contradictions"]))
    return Datasheet(
        {**own, **dict(solved["parameters"])},
        tuple(solved["assumed"]),
        tuple(solved["found"]),
        tuple(solved["compared"]),
        tuple(solved["contradictions"]),
    )


#: SI units of what may be given, by name.
UNITS: Mapping[str, str] = dict(_native.datasheet_numbers())
