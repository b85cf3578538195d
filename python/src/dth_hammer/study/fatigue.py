"""Fatigue life of the elastic bodies, from the stresses of settled blows and rainflow counting."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from .. import _native
from ..contract import typed
from ..errors import DomainError, RefusedError
from ..extras import need
from ..frames import np, pd
from ..scene import quantities
from ..scene.hammers import Hammerlike, Rocklike, numbers_of, scene_of
from ..scene.mesh import ELEMENTS, READINGS, mesh_for
from ..scene.steel import SNCurve
from ..scene.variables import Array, whole
from ..simulation import answers
from .longrun import Steady
from .response import steady

#: Number of blows that are skipped at the start, and of those that are counted if they do not
#: repeat.
SETTLED, IRREGULAR = 60, 10
#: Samples while a wave passes an element, and samples that are computed in one block.
FINE, BLOCK = 8, 20_000
#: Stress ranges are ignored below a share of the largest range at a place: below `LEAST`, and below
#: the share of which `MANY` cycles do `LOST` of the damage of the largest cycle.
LEAST, MANY, LOST = 0.01, 1e6, 1e-4
#: Relative error of the hours for which a mesh is chosen, unless the default error of a stress is
#: stricter.
LIFE_ERROR = 0.2


@dataclass(frozen=True, repr=False)
class Life(answers.Answer):
    """Fatigue life of the bodies at every element."""

    #: One row per element: body, section (1 is the top one), position (m below the face where the
    #: bodies meet), least and largest stress (Pa, tension positive), largest range (Pa), counted
    #: cycles per blow, damage per blow, hours.
    places: pd.DataFrame = field(repr=False)
    curve: SNCurve
    #: Number of blows that were counted.
    blows: int
    #: Duration of these blows, s.
    time: float
    #: ``cycle`` or ``irregular``. If irregular, counting other blows would give other numbers.
    kind: str
    #: Degree and number of spans, by the names of the parameters that set them.
    mesh: Mapping[str, int]
    #: Relative error of stresses on this mesh, by the engine's rule.
    stress_error: float

    @property
    def life_error(self) -> float:
        """Relative error of the hours due to the mesh: ``(1 + stress_error)^slope - 1``."""
        return float((1.0 + self.stress_error) ** self.curve.slope - 1.0)

    @property
    def worst(self) -> pd.Series:
        """The element that breaks first, as a row of `places`."""
        return self.places.iloc[int(self.places["hours"].to_numpy().argmin())]

    @property
    def sections(self) -> pd.DataFrame:
        """The worst element of each section."""
        first = self.places.groupby(["body", "section"], sort=False)["hours"].idxmin()
        table = self.places.loc[first].reset_index(drop=True)
        table.attrs = self.places.attrs
        return table

    def in_words(self) -> list[str]:
        """Returns what breaks first and when, the errors, and the blows that were counted."""
        worst, hours = self.worst, f"{self.worst['hours']:.4g} h"
        head = f"first: {worst['body']} at {worst['position'] * 1e3:.1f} mm after {hours}"
        mesh = ", ".join(f"{name} {value}" for name, value in self.mesh.items())
        error = f"stress within {self.stress_error:.2g}, hours within {self.life_error:.2g} of them"
        counted = f"blows counted: {self.blows} ({self.kind}); worst place of each section:"
        return [head, f"mesh: {mesh}: {error}", counted]

    def to_frame(self) -> pd.DataFrame:
        """Returns the worst element of each section, in mm, MPa and hours."""
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

    The stress at the centre of each element is sampled over a settled cycle, or over ten blows if
    they do not repeat. There are eight samples while a wave passes an element, and each turning
    point is taken from the parabola through three samples. Stress ranges are counted by rainflow
    (ASTM E1049) and their damages are added (Miner): ``hours = time / damage``.

    Unless the hammer's parameters give degree or spans, the mesh is chosen so fine that the hours
    err by a fifth at most. `Life.stress_error` is the error that remains on the mesh used.

    The stress is nominal and axial: the S-N line must include the effects of notches, splines,
    bending, contact and hardening.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        curve: the S-N line.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        progress: shows blows and error so far.

    Raises:
        RefusedError: the hammer comes to rest, or its bodies are rigid.
        MissingError: `rainflow` is not installed; the message has the command that installs it.

    Example:
        >>> from dth_hammer import SNCurve, life
        >>> mesh = {"mesh.degree": 3, "piston.elements": 8, "bit.elements": 8}
        >>> found = life(mesh, SNCurve("300 MPa", 1e7, 8))
        >>> print(found.worst["body"], f"{found.worst['hours']:.0f} h")
        bit 3654 h
    """
    need("rainflow")
    parameters = scene_of(hammer, rock, preset).parameters
    given = _meshed(numbers_of(hammer, preset, rock), parameters, curve)
    names = [name for name in _native.wave_names(given) if "_stress[" in name]
    response = steady(given, progress=progress)
    if response.kind == "stalled":
        raise RefusedError("the hammer comes to rest: it strikes no blows")
    blows = response.blows if response.repeats else IRREGULAR
    period = float(response.mean["period"])
    begin, end = SETTLED * period, (SETTLED + blows) * period
    turning_places: list[list[Array]] = [[] for _ in names]
    for block in _samples(given, names, begin, end):
        for place, column in zip(turning_places, block.T, strict=True):
            place.append(turning_points(column))
    rows = [_counted(np.concatenate(place), curve) for place in turning_places]
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
    error = _native.mesh_errors(given)[1]
    return Life(table, curve, blows, blows * period, response.kind, mesh, error)


def _meshed(given: dict[str, float], own: Iterable[str], curve: SNCurve) -> dict[str, float]:
    """Adds a mesh for stresses, unless the parameters choose one."""
    if any(name == "mesh.degree" or name.endswith(".elements") for name in own):
        return given
    error = (1.0 + LIFE_ERROR) ** (1.0 / curve.slope) - 1.0
    default_error = READINGS["stress"]
    try:
        return {**given, **mesh_for(given, min(error, default_error), of="stress").parameters}
    except DomainError:
        # The wave fronts are too sharp for any allowed mesh. `Life.stress_error` reports the error.
        return given


def _elastic(given: Mapping[str, float]) -> dict[str, Any]:
    """Returns the elastic bodies by name, with their sections and nodes."""
    return {name: body for name, body in _native.bodies(dict(given)).items() if body["elastic"]}


def _places(name: str, body: Mapping[str, Any]) -> pd.DataFrame:
    """Returns the section and the position of each element of a body."""
    nodes = np.array(body["nodes"])
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    ends = np.cumsum([length for length, _ in body["sections"]])
    section = np.minimum(np.searchsorted(ends, middles), len(ends) - 1) + 1
    face = nodes[-1] if name == "piston" else 0.0
    return pd.DataFrame({"body": name, "section": section, "position": middles - face})


def _samples(
    given: Mapping[str, float], names: list[str], begin: float, end: float
) -> Iterator[Array]:
    """Yields stresses at equal time steps, in blocks of rows.

    Each block begins with the last two rows of the block before, so that no turning point between
    two blocks is missed.
    """
    values = whole(given)
    speed = math.sqrt(values["material.youngs_modulus"] / values["material.density"])
    spans = [np.diff(body["nodes"]).min() for body in _elastic(given).values()]
    count = math.ceil((end - begin) * FINE * speed / min(spans))
    times = np.linspace(begin, end, count + 1)
    machine, selection = _native.Machine(dict(given)), _native.Selection(names)
    machine.advance(begin)
    overlap = np.empty((0, len(names)))
    for start in range(1, len(times), BLOCK):
        rows, _ = machine.run(times[start : start + BLOCK], selection, {})
        block = np.concatenate((overlap, np.asarray(rows)))
        yield block
        overlap = block[-2:]


def largest_stress(response: Steady, body: str) -> float:
    """Returns the largest axial stress (Pa) of a body over the settled blows of a response."""
    given = dict(response.parameters)
    if body not in _elastic(given):
        raise RefusedError(f"the {body} is rigid: it has no stress")
    names = [name for name in _native.wave_names(given) if name.startswith(f"{body}_stress[")]
    blows, period = response.blows if response.repeats else IRREGULAR, response["period"]
    blocks = _samples(given, names, SETTLED * period, (SETTLED + blows) * period)
    return max(float(np.abs(block).max()) for block in blocks)


def turning_points(samples: Array) -> Array:
    """Returns the extremes of samples at equal steps, from parabolas through three samples."""
    before, here, after = samples[:-2], samples[1:-1], samples[2:]
    turns = (here - before) * (after - here) < 0.0
    left, centre, right = before[turns], here[turns], after[turns]
    return np.asarray(centre - (right - left) ** 2 / (8.0 * (right - 2.0 * centre + left)))


def ranges(turns: Iterable[float]) -> Array:
    """Returns the cycles of a history by rainflow counting (ASTM E1049).

    Each row has the range, the mean and the count, which is 1 or 0.5.
    """
    rainflow: Any = need("rainflow")
    rows = [row[:3] for row in rainflow.extract_cycles(turns)]
    return np.array(rows, dtype=float).reshape(-1, 3)


def _counted(turns: Array, curve: SNCurve) -> dict[str, float]:
    """Returns extreme stresses, cycles and damage at one place.

    The history repeats, so it is rotated to begin and end at its largest value: rainflow counting
    then closes every cycle.
    """
    top = int(np.argmax(turns))
    share = min(LEAST, (LOST / MANY) ** (1.0 / curve.slope))
    history = _filtered(np.concatenate((turns[top:], turns[: top + 1])), share)
    counted = ranges(history)
    amplitude, mean, count = counted[:, 0] / 2.0, counted[:, 1], counted[:, 2]
    return {
        "least": turns.min(),
        "largest": turns.max(),
        "range": float(counted[:, 0].max(initial=0.0)),
        "cycles": float(count.sum()),
        "damage": float((count * curve.damage(amplitude, mean)).sum()),
    }


def _filtered(turns: Array, share: float) -> Array:
    """Returns the turning points without those of ranges below a share of the largest."""
    least, history = share * float(np.ptp(turns)), [float(turns[0])]
    rising = 0.0
    for value in map(float, turns[1:]):
        step = value - history[-1]
        if step * rising > 0.0:
            history[-1] = value
        elif abs(step) >= least:
            history.append(value)
            rising = step
    return np.array(history)
