"""Stress and velocity along piston and bit over time, as in a wave diagram."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .. import _native
from ..contract import typed
from ..errors import DthHammerError, TooFewBlowsError
from ..extras import need
from ..frames import np, pd
from ..scene.hammers import Hammerlike, Rocklike
from ..scene.mesh import BODIES
from ..scene.quantities import Fixed
from ..scene.variables import Array, whole
from . import answers
from .run import Run, simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Outputs that a wave diagram shows beside the stresses.
BESIDE = ("contact_closed", "contact_force", "rock_mode", "rock_force")


@dataclass(frozen=True)
class Bar:
    """Stress and velocity in one body.

    Arrays have one row per instant and one column per element or node, from top to bottom.
    """

    #: Positions of the nodes below the face where piston and bit meet, m.
    nodes: Array
    #: Axial stress in the elements, tension positive, Pa.
    stress: Array
    #: Velocities of the nodes, positive downward, m/s.
    velocity: Array

    @property
    def centres(self) -> Array:
        """Positions of the centres of the elements, m."""
        return 0.5 * (self.nodes[1:] + self.nodes[:-1])


@dataclass(frozen=True, repr=False)
class Waves(answers.Answer):
    """Stress and velocity in space and time; positions are those of the unstrained bars."""

    #: Instants, s, counted from the impact if the run has one.
    time: Array
    piston: Bar
    bit: Bar
    #: State and force of the contact and of the rock at the same instants.
    beside: pd.DataFrame
    #: ``impact``, its instant (s), and ``front``, the stress behind the front in the bit (Pa).
    notes: Mapping[str, float] = field(default_factory=dict)

    caption = "Stress waves of the last blow"

    def in_words(self) -> list[str]:
        """Returns the instant of the impact, and the smallest and largest stress of each body."""
        lines = [f"impact at {self.notes['impact']:.6f} s"] if self.notes else []
        for name, bar in (("piston", self.piston), ("bit", self.bit)):
            low, high = bar.stress.min() * 1e-6, bar.stress.max() * 1e-6
            lines.append(f"{name}: {low:.0f} to {high:.0f} MPa")
        return lines

    def plot(self) -> Figure:
        """Draws the stress over position and time."""
        figure: Figure = need("dth_hammer.figures").wave_diagram(self)
        return figure

    def to_frame(self) -> pd.DataFrame:
        """Returns the stresses in long form: time, body, position and stress in each row."""
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
        table.attrs["units"] = Fixed({"time": "s", "position": "m", "stress": "Pa"})
        return table

    @classmethod
    def of(cls, run: Run) -> Waves:
        """Takes the waves from a run that `simulate` made with ``waves=True``."""
        frame = run.convert("si").frame

        def columns(family: str) -> Array:
            names = [c for c in frame if str(c).startswith(f"{family}[")]
            if not names:
                raise DthHammerError(f"no {family} in the run: simulate with waves=True")
            return frame[names].to_numpy()

        bodies = _native.bodies(run.parameters)

        def bar(body: str) -> Bar:
            nodes = np.array(bodies[body]["nodes"])
            nodes -= nodes[-1] if body == "piston" else 0.0
            return Bar(nodes, columns(f"{body}_stress"), columns(f"{body}_node_velocity"))

        beside = frame[[c for c in BESIDE if c in frame]]
        return cls(run.time, bar("piston"), bar("bit"), beside, run.notes)


@typed()
def waves(
    hammer: Hammerlike = None,
    until: float | str | None = None,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    times: Sequence[float] | Array | None = None,
) -> Waves:
    """Returns stress and velocity along piston and bit after the last impact before ``until``.

    ``notes["impact"]`` is the instant of the impact, s. ``notes["front"]`` is the stress behind the
    first wave front in the bit, Pa: ``E v / c0 Ap / (Ap + Ab)`` (Saint-Venant) with the impact
    speed ``v`` and the areas ``Ap`` of the piston and ``Ab`` of the bit where they meet.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        until: the waves are those of the last impact before this time: s, or text with a unit.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        times: instants of the record, in seconds from the impact. By default it covers four round
            trips of a wave through both bodies, with four instants while a wave passes an element.

    Example:
        >>> from dth_hammer import waves
        >>> found = waves(until="100 ms")
        >>> front, most = found.notes["front"] / 1e6, found.bit.stress.min() / 1e6
        >>> print(f"{most:.0f} MPa, front {front:.0f} MPa")
        -246 MPa, front 217 MPa
    """
    run = simulate(hammer, until, preset=preset, rock=rock, outputs=["blow_count"])
    if not len(run.blows):
        raise TooFewBlowsError(f"no blow in {run.time[-1]:g} s: there is no wave to look at")
    impact, blow_speed = (float(run.blows[c].iloc[-1]) for c in ("blow_time", "blow_speed"))
    given = dict(run.parameters)
    all_numbers = whole(given)
    modulus = all_numbers["material.youngs_modulus"]
    speed = float(np.sqrt(modulus / all_numbers["material.density"]))
    times_from_impact = _times(given, speed) if times is None else np.asarray(times, dtype=float)
    run = simulate(run, times=impact + times_from_impact, outputs=BESIDE, waves=True)
    piston, bit = (_native.bodies(given)[body]["sections"] for body in BODIES)
    above, below = piston[-1][1], bit[0][1]
    front = above / (above + below) * modulus * blow_speed / speed
    return Waves.of(run.since(impact, {"impact": impact, "front": front}))


def _times(given: Mapping[str, float], speed: float) -> Array:
    nodes = [_native.bodies(given)[body]["nodes"] for body in BODIES]
    element = min(float(n[-1]) / (len(n) - 1) for n in nodes)
    # Begin a little before the impact, so that it shows.
    end = 8.0 * sum(float(n[-1]) for n in nodes) / speed
    return np.arange(-0.02 * end, end, 0.25 * element / speed)
