"""Parameters from a datasheet or a catalogue page: `from_datasheet`.

The engine finds the hammers (`hammer::datasheet`); this module adds units and tables.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from .. import _native
from ..contract import typed
from ..errors import DomainError, warn
from ..frames import pd
from . import quantities, rocks
from .band import ranged, to_digits
from .variables import VARIABLES, Value, numbers


@dataclass(frozen=True)
class Datasheet:
    """A hammer that was found from a datasheet: its parameters, and the assumptions."""

    #: For `simulate`, `Hammer` or `sweep`. The blows agree with `found` to half a per cent.
    parameters: Mapping[str, float]
    #: The assumptions for numbers that the datasheet does not give, one sentence each.
    assumed: tuple[str, ...]
    #: Results of simulated blows with these parameters: name, number, unit.
    found: tuple[tuple[str, float, str], ...]
    #: For each result, the range of 80 % of the hammers that fit the datasheet.
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    #: Each number in all these hammers, by name; ``weight`` is a hammer's statistical weight.
    sample: Mapping[str, Sequence[float]] = field(default_factory=dict, repr=False)
    #: Given numbers and those of the hammers: name, given, of the hammers, unit, and for a row of a
    #: table its pressure.
    compared: tuple[tuple[str, float, float, str, float | None], ...] = ()
    #: Given numbers that contradict each other, with the size of the contradiction: sentences.
    contradictions: tuple[str, ...] = ()
    #: The arguments of `from_datasheet`.
    given: Mapping[str, Any] = field(default_factory=dict, repr=False)

    def but(self, **changes: Any) -> Datasheet:
        """Returns the sheet with other numbers, ``sheet.but(at="30 bar")``; None removes one.

        Raises:
            DomainError: ``pressure``, ``od`` or ``piston_mass`` changes, but numbers that were
                printed for the old value stay.
        """
        after = {**self.given, **changes}
        if why := _native.refused_change(_read(self.given), _read(after)):
            raise DomainError(why)
        return from_datasheet(**after)

    @cached_property
    def members(self) -> pd.DataFrame:
        """Returns the hammers of the sample, one row each, with a column for each number."""
        return pd.DataFrame(self.sample)

    @property
    def ground(self) -> dict[str, float]:
        """Returns the parameters with the rock's own range; `parameters` also has the hammer's."""
        low, high = self.ranges["specific energy"]
        return {**self.parameters, "rock.specific_energy_factor": (high / low) ** 0.5}

    def compared_as(self) -> _native.Compared:
        """Returns the datasheet as the engine's comparison takes it."""
        rock = repr((self.given.get("rock"), self.given.get("specific_energy")))
        columns = [(name, [*numbers]) for name, numbers in self.sample.items()]
        return _read(self.given), rock, columns, [*self.sample["weight"]], (0.0, 0.0)

    def __str__(self) -> str:
        rows = [
            f"{name} = {VARIABLES[name].text(number)}" for name, number in self.parameters.items()
        ]
        rows = [f"{name}: {text}" for name, text in self.readable().items()] + [""] + rows
        rows += ["given, and of this hammer:"]
        for name, given, own, unit, off in self.readings():
            rows.append(f"  {name}: {given} {unit}, {own} {unit} ({off})")
        rows += ["assumed:", *(f"  {text}" for text in self.assumed)]
        if self.contradictions:
            rows += ["contradictions:", *(f"  {text}" for text in self.contradictions)]
        return "\n".join(rows)

    def readings(self) -> Iterator[tuple[str, str, str, str, str]]:
        """Yields name, given number, the hammers' number, the trade's unit, and the difference."""
        for name, given, own, _, at in self.compared:
            unit, size = TRADE[name]
            # Adding zero makes -0.0 positive.
            off = round(100 * (own / given - 1), 1) + 0.0
            where = f" at {1e-5 * at:.3g} bar" if at else ""
            yield name + where, f"{given / size:.4g}", f"{own / size:.4g}", unit, f"{off:+.1f} %"

    def readable(self) -> dict[str, str]:
        """Returns the results in field units with their ranges, the rate first."""
        rows = []
        for name, number, si in self.found:
            turns = name.startswith("rotation")
            factor, unit = (60.0, "turns/min") if turns else quantities.displayed(name, si)
            unit = f"{unit} of normal air (0 degC, 1.013 bar)" if name in FREE else unit
            low, high = (factor * side for side in self.ranges[name])
            sides = ranged(low, high)
            wide = f" ({sides})" if sides else ""
            digits = to_digits(factor * number, low, high)
            rows.append((name, f"{digits} {unit}".rstrip() + wide))
        return dict(sorted(rows, key=lambda row: "rate" not in row[0]))

    def to_frame(self) -> pd.DataFrame:
        """Returns each result with its range, in SI units, one row each."""
        rows = {name: (number, *self.ranges[name], unit) for name, number, unit in self.found}
        heads = ["value", "low", "high", "unit"]
        return pd.DataFrame.from_dict(rows, orient="index", columns=heads)

    def _repr_html_(self) -> str:
        cells = [
            f"<tr><td>{name}</td><td>{text}</td></tr>" for name, text in self.readable().items()
        ]
        names = [
            f"<tr><td><code>{n}</code></td><td>{VARIABLES[n].text(x)}</td></tr>"
            for n, x in self.parameters.items()
        ]
        texts = [f"<li>{text}</li>" for text in (*self.contradictions, *self.assumed)]
        return f"<table>{''.join(cells + names)}</table><ul>{''.join(texts)}</ul>"


@typed()
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
    air_flow: Value | Mapping[Value, Value] | None = None,
    flow: Value | None = None,
    rop: Value | None = None,
    effectiveness: Value | None = None,
    piston_length: Value | None = None,
    bit_mass: Value | None = None,
    od: Value | None = None,
    length: Value | None = None,
    hole: Value | None = None,
    feed: Value | None = None,
    pipe: Value | None = None,
    rotation: Value | None = None,
    altitude: Value | None = None,
    inlet: Value | None = None,
    damping_ratio: Value | None = None,
    specific_energy: Value | None = None,
    at: Value | None = None,
    rock: str | Mapping[str, Value] | None = None,
) -> Datasheet:
    """Finds the hammers that match a datasheet or a page of a catalogue.

    Give all numbers that are printed. The result is a sample of hammers that fit all of them.
    Missing numbers are drawn at random around usual values (`Datasheet.assumed`), and each result
    has the range of 80 % of the sample (`Datasheet.ranges`); if the rate cannot be determined at
    all, an error is raised. Contradictions and impossible results are listed in `contradictions`
    and cause a warning. Numbers are in SI units (kg, J, Hz, Pa, m, N, m3/s); text may have any
    other unit, for instance ``"1800 bpm"``, ``"350 ft.lbf"`` or ``"250 psi"``.

    Args:
        piston_mass: mass of the piston.
        blow_energy: energy of the piston just before it meets the bit.
        frequency: number of blows per time.
        impact_speed: speed of the piston just before it meets the bit.
        pressure: pressure of the supply above that of the exhaust (gauge).
        bore: diameter of the face on which the pressure acts.
        stroke: distance from the bit to the point where the piston turns.
        power: power of the blows: energy times frequency.
        air_flow: flow of free air; by pressure if a catalogue prints several, ``{"17 bar": "13
            m3/min", "24 bar": "19 m3/min"}``.
        flow: flow of oil or water.
        rop: a measured rate of penetration, from which the rock's specific energy follows.
        effectiveness: mean driving pressure over the supply pressure, if it is known.
        piston_length: length of the piston; by default it is as slender as the reference piston.
        bit_mass: mass of the bit; by default the bit is as long as the piston.
        od: outside diameter of the hammer.
        length: length of the hammer.
        hole: diameter of the hole; the rock's stiffness grows with it.
        feed: feed force; by default the usual one for the size, or that of the reference hammer.
        pipe: outside diameter of the drill pipe; with ``air_flow`` it gives the up-hole velocity.
        rotation: turns of the bit per time, for the advance per turn.
        altitude: altitude of the compressor; the result then has the air that it takes in there.
        inlet: temperature of this air, K or text (``"15 degC"``).
        damping_ratio: damping ratio of the piston's first elastic mode; the default is 0.5 %.
        specific_energy: specific energy of the rock, J/m3.
        at: the working pressure, if the datasheet's numbers belong to another pressure.
        rock: the rock: a name, a class, a strength or a file, as for `dth_hammer.rock`, or
            parameters under this bit; by default the reference rock.

    Raises:
        DomainError: a number outside the range of real hammers; too few numbers.

    Example:
        >>> from dth_hammer import from_datasheet
        >>> sheet = from_datasheet(power="11 kW", frequency="1500 bpm", hole="115 mm")
        >>> low, high = (3600 * rate for rate in sheet.ranges["rate of penetration"])
        >>> print(f"{low:.0f} to {high:.0f} m/h")
        9 to 23 m/h
    """
    written = {name: value for name, value in locals().items() if value is not None}
    named: list[str] = []
    if isinstance(rock, str):
        if hole is None and od is None:
            raise DomainError(f"rock {rock!r} depends on the bit: give hole or od")
        usual = None if od is None else _native.usual_hole(quantities.read(od, "m", "od"))
        rock = rocks.rock(rock, hole=usual if hole is None else hole)
        known = rop is not None or specific_energy is not None
        named = [text for text in rock.assumed if not (known and "pecific energy" in text)]
    own = numbers(None, rock)
    if specific_energy is not None:
        name = "rock.specific_energy"
        own[name] = VARIABLES[name].number(specific_energy)
    solved = _native.datasheet(_read(written), rock is not None, own)
    if solved["contradictions"]:
        warn(" ".join(solved["contradictions"]))
    return Datasheet(
        {**own, **dict(solved["parameters"])},
        (*solved["assumed"], *named),
        tuple((name, number, unit) for name, number, _, _, unit, _ in solved["found"]),
        {name: (low, high) for name, _, low, high, _, _ in solved["found"]},
        {row[0]: row[5] for row in solved["found"]} | {"weight": solved["weights"]},
        tuple(solved["compared"]),
        tuple(solved["contradictions"]),
        written,
    )


def _read(given: Mapping[str, Any]) -> _native.Given:
    """Returns the numbers for the engine: SI numbers by name, free air by pressure, ``at``."""
    arguments = {name: given.get(name) for name in UNITS}
    table: list[tuple[float, float]] = []
    if isinstance(air := given.get("air_flow"), Mapping):
        if not air:
            raise DomainError("air_flow is empty: give a flow for at least one pressure")
        unit = UNITS["air_flow"]
        pairs = ((quantities.read(p, "Pa", "pressure"), q) for p, q in air.items())
        table = sorted((p, quantities.read(q, unit, "air_flow")) for p, q in pairs)
        highest = table[-1][0]
        arguments |= {"air_flow": None, "pressure": given.get("pressure", highest)}
    numbers = {
        name: quantities.read(value, UNITS[name], name)
        for name, value in arguments.items()
        if value is not None
    }
    at = given.get("at")
    return numbers, table, None if at is None else quantities.read(at, "Pa", "at")


#: SI units of the numbers that may be given, by name.
UNITS: Mapping[str, str] = {row[0]: row[1] for row in _native.datasheet_numbers()}
#: The units of the trade, and their sizes in the SI unit.
TRADE: Mapping[str, tuple[str, float]] = {
    row[0]: (row[2], row[3]) for row in _native.datasheet_numbers()
}
#: Names of the results that are flows of free air.
FREE = ("free air", "free air, casing held", _native.THROUGH)
