"""Fatigue life of the elastic bodies: stress histories of settled blows, counted by rainflow."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from .. import _native
from ..contract import typed
from ..errors import DomainError, RefusedError
from ..extras import need
from ..run import answers
from ..scene import quantities
from ..scene.hammers import Hammerlike, Rocklike, numbers_of, scene_of
from ..scene.mesh import ELEMENTS, READINGS, mesh_for
from ..scene.variables import Array, whole
from .longrun import Steady
from .response import steady

#: Periods that are left out at the start, and those that are counted of blows that do not repeat.
SETTLED, IRREGULAR = 60, 10
#: Samples while a wave passes an element, and how many are made at a time.
FINE, MOST = 8, 20_000
#: Ranges below this part of a place's largest are not counted: with a slope up to 15, a million of
#: them do 1e-9 of the damage of the largest.
LEAST = 0.01
#: Relative error of the hours for which a mesh is chosen; the stress errs by no more than usual.
LIFE_ERROR = 0.2


@typed()
@dataclass(frozen=True)
class SNCurve:
    """A line in logarithms: ``N = cycles (strength / S)^slope`` for the stress amplitude ``S``.

    Numbers, or text with units. None is known to this package: it is of the steel, its surface and
    its heat treatment, and makes hours shorter or longer by powers of ten.

    Example:
        >>> from dth_hammer import SNCurve
        >>> print(f"{SNCurve('300 MPa', 1e7, 8).damage(300e6, 0.0):.0e} of the life per cycle")
        1e-07 of the life per cycle
    """

    #: Stress amplitude (half of the range) that is borne so many times, Pa.
    strength: Any
    cycles: float
    #: Exponent, 1 to 50.
    slope: float
    #: Ultimate strength, Pa; if it is given, tensile means shorten the life (Goodman):
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
        """From text: ``300 MPa,1e7,8``, or with the ultimate strength ``300 MPa,1e7,8,1 GPa``."""
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
        """Part of the life that a cycle of an amplitude and a mean takes, Pa."""
        stress = np.asarray(amplitude, float)
        if self.ultimate is not None:
            left = 1.0 - np.maximum(mean, 0.0) / self.ultimate
            stress = np.where(left > 0.0, stress / np.where(left > 0.0, left, 1.0), np.inf)
        return np.asarray((stress / self.strength) ** self.slope / self.cycles)


@dataclass(frozen=True, repr=False)
class Life(answers.Answer):
    """Fatigue life of the bodies, place by place."""

    #: A row an element: body, section (from 1, at the top), position (m below the face where the
    #: bodies meet), least and largest stress (Pa, tension positive), largest range (Pa), counted
    #: cycles per blow, damage per blow, hours.
    places: pd.DataFrame = field(repr=False)
    curve: SNCurve
    #: Blows that were counted, and their time, s.
    blows: int
    time: float
    #: ``cycle``, or ``irregular``: then another stretch would give other numbers.
    kind: str
    #: Degree and spans by parameter, and the relative error of stresses that they leave, by the
    #: engine's rule.
    mesh: Mapping[str, int]
    stress_error: float

    @property
    def life_error(self) -> float:
        """The mesh's relative error of the hours: the life goes with a power of stress."""
        return float((1.0 + self.stress_error) ** self.curve.slope - 1.0)

    @property
    def worst(self) -> pd.Series:
        """The place that breaks first, as a row of `places`."""
        return self.places.iloc[int(self.places["hours"].to_numpy().argmin())]

    @property
    def sections(self) -> pd.DataFrame:
        """Returns a table with the worst place of each section."""
        first = self.places.groupby(["body", "section"], sort=False)["hours"].idxmin()
        table = self.places.loc[first].reset_index(drop=True)
        table.attrs = self.places.attrs
        return table

    def in_words(self) -> list[str]:
        """What breaks first, and how well that is known."""
        worst, hours = self.worst, f"{self.worst['hours']:.4g} h"
        head = f"first: {worst['body']} at {worst['position'] * 1e3:.1f} mm after {hours}"
        mesh = ", ".join(f"{name} {value}" for name, value in self.mesh.items())
        error = f"stress within {self.stress_error:.2g}, hours within {self.life_error:.2g} of them"
        counted = f"blows counted: {self.blows} ({self.kind}); worst place of each section:"
        return [head, f"mesh: {mesh}: {error}", counted]

    def to_frame(self) -> pd.DataFrame:
        """Returns the worst place of each section, in mm, MPa and hours."""
        units = {"position": "mm", "least": "MPa", "largest": "MPa", "range": "MPa"}
        return quantities.with_units(quantities.convert(self.sections, units))


@typed()
def life(
    hammer: Hammerlike,
    curve: SNCurve,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    progress: bool = False,
) -> Life:
    """Estimates the hours until piston, bit and an elastic casing break by fatigue.

    The stress at the middle of each element over a settled cycle (or over ten blows, where they do
    not repeat) is sampled eight times while a wave passes the element; turning points lie on the
    parabola through three samples. Ranges are counted by rainflow (ASTM E1049), damages are added
    (Miner): ``hours = time / damage``.

    Unless the hammer's parameters name degree or spans, the mesh is chosen for a stress from which
    the hours err by a fifth at most; `Life.stress_error` says what the mesh leaves.

    The stress is nominal and axial: the effects of notches, splines, bending, contact and
    hardening must be in the curve.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        curve: the S-N line.
        preset: parameter set that a mapping is laid over.
        rock: beside it: a name, a class or a strength, or a file, as `dth_hammer.rock` takes them.
        progress: shows blows and error so far.

    Raises:
        RefusedError: the hammer comes to rest, or its bodies are rigid.
        MissingError: `rainflow` is not installed; the message has the command.

    Example:
        >>> from dth_hammer import SNCurve, life
        >>> mesh = {"mesh.degree": 3, "piston.elements": 8, "bit.elements": 8}
        >>> found = life(mesh, SNCurve("300 MPa", 1e7, 8))
        >>> print(found.worst["body"], f"{found.worst['hours']:.0f} h")
        bit 3654 h
    """
    need("rainflow")
    own = scene_of(hammer, rock, preset).parameters
    given = _meshed(numbers_of(hammer, preset, rock), own, curve)
    names = [name for name in _native.wave_names(given) if "_stress[" in name]
    found = steady(given, progress=progress)
    if found.kind == "stalled":
        raise RefusedError("the hammer comes to rest: it strikes no blows")
    blows = found.blows if found.repeats else IRREGULAR
    period = float(found.mean["period"])
    begin, end = SETTLED * period, (SETTLED + blows) * period
    turns: list[list[Array]] = [[] for _ in names]
    for block in _samples(given, names, begin, end):
        for place, column in zip(turns, block.T, strict=True):
            place.append(turning_points(column))
    rows = [_counted(np.concatenate(place), curve) for place in turns]
    bodies = _elastic(given)
    table = pd.concat([_places(*body) for body in bodies.items()], ignore_index=True)
    table = table.join(pd.DataFrame(rows))
    table[["cycles", "damage"]] /= blows
    with np.errstate(divide="ignore"):
        table["hours"] = period / table["damage"] / 3600.0
    units = {"position": "m", "least": "Pa", "largest": "Pa", "range": "Pa", "hours": "h"}
    table.attrs["units"] = quantities.Fixed(units)
    values = whole(given)
    spans = [name for name in (*ELEMENTS, "casing.elements") if name.split(".")[0] in bodies]
    mesh = {name: int(values[name]) for name in ("mesh.degree", *spans)}
    error = float(_native.force_error(given))
    return Life(table, curve, blows, blows * period, found.kind, mesh, error)


def _meshed(given: dict[str, float], own: Iterable[str], curve: SNCurve) -> dict[str, float]:
    """Adds a mesh for stresses, unless the parameters choose one."""
    if any(name == "mesh.degree" or name.endswith(".elements") for name in own):
        return given
    error = (1.0 + LIFE_ERROR) ** (1.0 / curve.slope) - 1.0
    usual = READINGS["stress"]
    try:
        return {**given, **mesh_for(given, min(error, usual), of="stress").parameters}
    except DomainError:
        # Fronts that no mesh resolves, or a string that needs all there is: its error is told.
        return given


def _elastic(given: Mapping[str, float]) -> dict[str, Any]:
    """The bodies that carry waves, with their sections and nodes."""
    return {name: body for name, body in _native.bodies(dict(given)).items() if body["elastic"]}


def _places(name: str, body: Mapping[str, Any]) -> pd.DataFrame:
    """Returns the positions of a body's stresses and the section of each."""
    nodes = body["nodes"]
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    ends = np.cumsum([length for length, _ in body["sections"]])
    section = np.minimum(np.searchsorted(ends, middles), len(ends) - 1) + 1
    origin = nodes[-1] if name == "piston" else 0.0
    return pd.DataFrame({"body": name, "section": section, "position": middles - origin})


def _samples(
    given: Mapping[str, float], names: list[str], begin: float, end: float
) -> Iterator[Array]:
    """Stresses at equal steps, in blocks that share two rows with the block before."""
    values = whole(given)
    speed = math.sqrt(values["material.youngs_modulus"] / values["material.density"])
    spans = [np.diff(body["nodes"]).min() for body in _elastic(given).values()]
    count = math.ceil((end - begin) * FINE * speed / min(spans))
    times = np.linspace(begin, end, count + 1)
    machine, selection = _native.Machine(dict(given)), _native.Selection(names)
    machine.advance(begin)
    overlap = np.empty((0, len(names)))
    for start in range(1, len(times), MOST):
        rows, _ = machine.run(times[start : start + MOST], selection, {})
        block = np.concatenate((overlap, np.asarray(rows)))
        yield block
        overlap = block[-2:]


def largest_stress(found: Steady, body: str) -> float:
    """Returns the largest axial stress of a body over the blows of a response, Pa, on its mesh."""
    given = dict(found.parameters)
    if body not in _elastic(given):
        raise RefusedError(f"the {body} is rigid: it has no stress")
    names = [name for name in _native.wave_names(given) if name.startswith(f"{body}_stress[")]
    blows, period = found.blows if found.repeats else IRREGULAR, found["period"]
    blocks = _samples(given, names, SETTLED * period, (SETTLED + blows) * period)
    return max(float(np.abs(block).max()) for block in blocks)


def turning_points(samples: Array) -> Array:
    """Values where samples at equal steps turn, on the parabolas through three of them."""
    before, here, after = samples[:-2], samples[1:-1], samples[2:]
    turns = (here - before) * (after - here) < 0.0
    b, h, a = before[turns], here[turns], after[turns]
    return np.asarray(h - (a - b) ** 2 / (8.0 * (a - 2.0 * h + b)))


def ranges(turns: Iterable[float]) -> Array:
    """Range, mean and count (1, or a half) of the cycles of a history, by rainflow (ASTM E1049)."""
    rainflow: Any = need("rainflow")
    found = [row[:3] for row in rainflow.extract_cycles(turns)]
    return np.array(found, dtype=float).reshape(-1, 3)


def _counted(turns: Array, curve: SNCurve) -> dict[str, float]:
    """Returns the damage of a place's history, which repeats: it begins at its largest value."""
    top = int(np.argmax(turns))
    history = _filtered(np.concatenate((turns[top:], turns[: top + 1])))
    counted = ranges(history)
    amplitude, mean, count = counted[:, 0] / 2.0, counted[:, 1], counted[:, 2]
    return {
        "least": turns.min(),
        "largest": turns.max(),
        "range": float(counted[:, 0].max(initial=0.0)),
        "cycles": float(count.sum()),
        "damage": float((count * curve.damage(amplitude, mean)).sum()),
    }


def _filtered(turns: Array) -> Array:
    """Returns the history without the turns that are too close to the one kept before."""
    least, history = LEAST * float(np.ptp(turns)), [float(turns[0])]
    rising = 0.0
    for value in map(float, turns[1:]):
        step = value - history[-1]
        if step * rising > 0.0:
            history[-1] = value
        elif abs(step) >= least:
            history.append(value)
            rising = step
    return np.array(history)
