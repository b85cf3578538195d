"""Stress and velocity along piston and bit, over time: what a wave diagram shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from . import bodies, journal
from .errors import DthHammerError, TooFewBlowsError
from .package import Package, load
from .quantities import convert
from .run import simulate
from .variables import Array, Value

#: Outputs that tell what happens meanwhile.
NEEDED = ("blow_time", "blow_count", "blow_speed")
BESIDE = ("contact_closed", "contact_force", "rock_mode", "rock_force")


@dataclass(frozen=True)
class Bar:
    """One body: a row an instant, a column an element or a node, top to bottom."""

    #: Positions of the nodes below the face where piston and bit meet, m.
    nodes: Array
    #: Axial stress in the elements, tension positive, Pa.
    stress: Array
    #: Velocities of the nodes, positive downward, m/s.
    velocity: Array

    @property
    def centres(self) -> Array:
        """Positions of the middles of the elements, m."""
        return 0.5 * (self.nodes[1:] + self.nodes[:-1])


@dataclass(frozen=True)
class Waves:
    """Stress and velocity in space and time; positions are those of the unstrained bars."""

    #: Instants, s, from the impact if there is one.
    time: Array
    piston: Bar
    bit: Bar
    #: Contact and rock at the same instants.
    beside: pd.DataFrame
    attrs: dict[str, Any] = field(default_factory=dict)

    def table(self) -> pd.DataFrame:
        """The stresses in long form: time, body, position and stress in each row."""
        parts = []
        for body, bar in (("piston", self.piston), ("bit", self.bit)):
            size = len(bar.centres)
            columns = {
                "time": np.repeat(self.time, size),
                "body": body,
                "position": np.tile(bar.centres, len(self.time)),
                "stress": bar.stress.ravel(),
            }
            parts.append(pd.DataFrame(columns))
        table = pd.concat(parts, ignore_index=True)
        table.attrs.update(self.attrs, units={"time": "s", "position": "m", "stress": "Pa"})
        return table

    @classmethod
    def of(cls, frame: pd.DataFrame, fmu: str | Path | Package | None = None) -> Waves:
        """The waves in a table that `simulate` made with ``waves=True``."""
        package, frame = load(fmu), convert(frame, "si")

        numbers = {v.name: v.start or 0.0 for v in package.variables.of("parameter")}
        numbers |= frame.attrs["parameters"]

        def columns(family: str) -> Array:
            names = [c for c in frame if str(c).startswith(f"{family}[")]
            if not names:
                raise DthHammerError(f"no {family} in the table: simulate with waves=True")
            return frame[names].to_numpy()

        def bar(body: str, top: float) -> Bar:
            nodes = top + bodies.nodes(numbers, body)
            return Bar(nodes, columns(f"{body}_stress"), columns(f"{body}_node_velocity"))

        return cls(
            time=frame.index.to_numpy(float),
            piston=bar("piston", -bodies.length(numbers, "piston")),
            bit=bar("bit", 0.0),
            beside=frame[[c for c in BESIDE if c in frame]],
            attrs={str(name): value for name, value in frame.attrs.items()},
        )


def waves(
    parameters: Mapping[str, Value] | None = None,
    until: float | str | None = None,
    *,
    preset: str | None = None,
    times: Sequence[float] | Array | None = None,
    fmu: str | Path | Package | None = None,
) -> Waves:
    """Stress and velocity along piston and bit after the last impact before ``until``.

    ``attrs["front"]`` has the stress that the blow's speed ``v`` makes behind the front in the
    bit, ``E v / c0 Ap / (Ap + Ab)`` with the areas that meet (Saint-Venant), Pa;
    ``attrs["impact"]`` the instant of the impact, s.

    Args:
        parameters: as of `simulate`.
        until: the last impact before this many seconds is looked at.
        preset: parameter set to start from.
        times: instants to look at, in seconds from the impact. If not given: four times a
            wave's way through both bodies and back, four instants an element passed.
        fmu: file to use instead of the one found.
    """
    package = load(fmu)
    run = simulate(parameters, until, preset=preset, outputs=NEEDED, fmu=package)
    if not run["blow_count"].iloc[-1]:
        raise TooFewBlowsError(f"no blow in {run.index[-1]:g} s: there is no wave to look at")
    impact = float(run["blow_time"].iloc[-1])
    numbers = {v.name: v.start or 0.0 for v in package.variables.of("parameter")}
    numbers |= package.values(preset, parameters)
    since = _times(numbers) if times is None else np.asarray(times, dtype=float)
    frame = simulate(
        parameters, preset=preset, times=impact + since, outputs=BESIDE, waves=True, fmu=package
    )
    frame.index = pd.Index(since, name="time")
    # Blows are told by the run's own time.
    frame.attrs.pop(journal.KEY, None)
    speed = float(run["blow_speed"].iloc[-1])
    above, below = bodies.sections(numbers, "piston")[-1], bodies.sections(numbers, "bit")[0]
    share = above.area / (above.area + below.area)
    front = share * numbers["material.youngs_modulus"] * speed / _wave_speed(numbers)
    frame.attrs |= {"impact": impact, "front": front}
    return Waves.of(frame, package)


def _wave_speed(numbers: Mapping[str, float]) -> float:
    return float(np.sqrt(numbers["material.youngs_modulus"] / numbers["material.density"]))


def _times(numbers: Mapping[str, float]) -> Array:
    speed = _wave_speed(numbers)
    both = (bodies.PISTON, bodies.BIT)
    element = min(bodies.length(numbers, b) / bodies.elements(numbers, b) for b in both)
    step = 0.25 * element / speed
    # A little of what is before, so that the impact is seen.
    end = 8.0 * sum(bodies.length(numbers, b) for b in both) / speed
    return np.arange(-0.02 * end, end, step)
