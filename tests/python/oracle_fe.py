"""Independent oracle of the hammer on a finite-element mesh.

Written from the text of the model alone and sharing no code with the engine:
node-wise assembled bars, SciPy's DOP853 for time, events located by
re-integration rather than by any closed form. Slow, and meant to be believed.

    python tests/python/oracle_fe.py       # remakes data/first_blow.json, some minutes

The parameters come from data/reference.json: the published reference
configuration, stated once more on purpose, so that the FMU's own start values
are compared with something that they did not make.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import DOP853

DATA = Path(__file__).parent / "data"
ROCK_MODES = ("FreeFlight", "DissipativeForward", "Forward", "Backward", "Standstill")
# Integrals carried beside the motion.
INTEGRALS = (
    "contact_impulse",
    "rock_impulse",
    "energy_drive",
    "energy_viscous",
    "energy_rock_dissipated",
    "energy_damping",
)
# Guards are looked at this many times inside a step: a step is a fraction of
# the fastest mode's period, so a pair of crossings between looks is a graze.
LOOKS = 8
# Below this (m, m/s, J) a guard's value is rounding of the state at its own event.
RESOLUTION = 1e-12
# While the bit creeps under the feed, long after a blow, its speed dies out, and when its
# sign turns is rounding too: only a coarser look passes such a phase.
COARSE = 1e-7
QUIET = 10e-3


def reference() -> dict[str, float]:
    """The published reference configuration, by the FMU's variable names."""
    return json.loads((DATA / "reference.json").read_text())


@dataclass(frozen=True)
class Mode:
    """Discrete state of the hybrid system, memory of the rock law included."""

    rock: str = "Standstill"
    closed: bool = False
    alpha: int = 1
    lower: float = 0.0  # ul
    upper: float = 0.0  # uu
    gain: float = 0.0  # dp
    spent_before: float = 0.0  # viscous work when the current cycle began


@dataclass
class Event:
    """One transition: when, which event function, and the mode after it."""

    time: float
    guard: str
    rock: str
    closed: bool
    alpha: int
    approach: float  # relative mean velocity then


class Bar:
    """Linear two-node elements with consistent mass.

    The unknowns are the top node and the elements' elongations, not the nodal
    displacements: a piston that has moved 50 mm and is strained by 1 um would
    otherwise lose four digits of its strain to rounding.
    """

    def __init__(self, p: Mapping[str, float], name: str) -> None:
        count, length = int(p[f"{name}.elements"]), p[f"{name}.length"]
        section, size = p["cross_section"], length / count
        element = p["material.density"] * section * size
        self.nodes = count + 1
        self.rigidity = p["material.youngs_modulus"] * section / size
        self.mass = element * count
        mass = np.zeros((count + 1, count + 1))
        for i in range(count):
            mass[i : i + 2, i : i + 2] += element / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
        difference = np.eye(count + 1) - np.eye(count + 1, k=-1)
        self.accelerate = difference @ np.linalg.inv(mass)
        # Tension pulls an element's upper node down and its lower node up.
        self.pull = np.eye(count + 1, count) - np.eye(count + 1, count, k=-1)
        self.displace = np.tril(np.ones((count + 1, count + 1)))
        self.mean = np.ones(count + 1) @ mass @ self.displace / self.mass
        self.inertia = self.displace.T @ mass @ self.displace


class Hammer:
    """The equation of motion and the event functions, mode by mode.

    State vector: unknowns of the piston, of the bit, their rates, integrals. The
    piston's displacement is counted from where it meets the undeformed bit: in contact
    the gap is then a difference of small numbers, and keeps its digits.
    """

    def __init__(self, p: Mapping[str, float]) -> None:
        self.p = dict(p)
        self.piston, self.bit = Bar(p, "piston"), Bar(p, "bit")
        a, b = self.piston.nodes, self.bit.nodes
        self.half, self.size = a + b, 2 * (a + b) + len(INTEGRALS)
        u, v = np.eye(self.size)[: a + b], np.eye(self.size)[a + b : 2 * (a + b)]
        self.up, self.ub, self.vp, self.vb = u[:a], u[a:], v[:a], v[a:]
        self.tip, self.tip_rate = self.ub.sum(axis=0), self.vb.sum(axis=0)
        self.gap_row = self.ub[0] - self.up.sum(axis=0)
        self.mean_piston, self.mean_bit = self.piston.mean @ self.up, self.bit.mean @ self.ub
        self.rate_piston, self.rate_bit = self.piston.mean @ self.vp, self.bit.mean @ self.vb
        self.integral = {n: 2 * self.half + i for i, n in enumerate(INTEGRALS)}

    def start(self) -> np.ndarray:
        """Piston at rest or thrown; bit in equilibrium under its dead loads in SS."""
        p, y = self.p, np.zeros(self.size)
        y[0], y[self.half] = -p["contact.initial_gap"], p["piston.initial_velocity"]
        n, body = self.bit.nodes, self.bit.mass * p["gravity"]
        # Force in each element, from the shoulder down: feed and the weight above it.
        weight = body * (np.arange(1, n) - 0.5) / (n - 1)
        elongation = -(p["feed_force"] + weight) / self.bit.rigidity
        tip = (p["feed_force"] + body) / (p["rock.unloading_ratio"] * p["rock.stiffness"])
        first = self.piston.nodes
        y[first], y[first + 1 : first + n] = tip - elongation.sum(), elongation
        return y

    def drive(self, mode: Mode) -> float:
        return mode.alpha * self.p["drive.amplitude"]

    def contact_force(self, mode: Mode) -> np.ndarray:
        """Row of F_C, linear in the state."""
        return -(self.p["contact.stiffness"] if mode.closed else 0.0) * self.gap_row

    def rock_force(self, mode: Mode) -> tuple[np.ndarray, float]:
        """Row and constant of F_R, affine in the state."""
        stiff, ratio = self.p["rock.stiffness"], self.p["rock.unloading_ratio"]
        if mode.rock == "FreeFlight":
            return np.zeros(self.size), 0.0
        if mode.rock in ("Backward", "Standstill"):
            return ratio * stiff * self.tip, -ratio * stiff * mode.upper
        viscous = self.p["rock.viscosity"] if mode.rock == "DissipativeForward" else 0.0
        return stiff * self.tip + viscous * self.tip_rate, -stiff * mode.lower

    def affine(self, mode: Mode) -> tuple[np.ndarray, np.ndarray]:
        """`y' = matrix y + constant`, but for the quadratic integrals."""
        p, h = self.p, self.half
        contact = self.contact_force(mode)
        rock, rock0 = self.rock_force(mode)
        matrix, constant = np.zeros((self.size, self.size)), np.zeros(self.size)
        matrix[:h] = np.eye(self.size)[h : 2 * h]
        loads = ((self.piston, self.up, self.vp, h), (self.bit, self.ub, self.vb, h + len(self.up)))
        for bar, u, v, row in loads:
            tension = bar.rigidity * (u[1:] + p["material.damping_time"] * v[1:])
            forces, steady = bar.pull @ tension, np.zeros(bar.nodes)
            if bar is self.piston:
                forces[-1] -= contact
            else:
                forces[0] += contact
                steady[0] += p["feed_force"]
                forces[-1] -= rock
                steady[-1] -= rock0
            matrix[row : row + bar.nodes] = bar.accelerate @ forces
            constant[row : row + bar.nodes] = bar.accelerate @ steady
            # Loads spread like the mass move a bar without straining it.
            drive = self.drive(mode) / bar.mass if bar is self.piston else 0.0
            constant[row] += p["gravity"] + drive
        for name, line, steady in (
            ("contact_impulse", contact, 0.0),
            ("rock_impulse", rock, rock0),
            ("energy_drive", self.drive(mode) * self.rate_piston, 0.0),
        ):
            matrix[self.integral[name]], constant[self.integral[name]] = line, steady
        return matrix, constant

    def rate(self, mode: Mode) -> Any:
        """The right-hand side in one mode."""
        matrix, constant = self.affine(mode)
        p, h, a = self.p, self.half, self.piston.nodes
        viscous = p["rock.viscosity"] if mode.rock == "DissipativeForward" else 0.0
        loading = mode.rock in ("DissipativeForward", "Forward")
        crush = (1 - 1 / p["rock.unloading_ratio"]) * p["rock.stiffness"] if loading else 0.0
        i, j, k = (self.integral[n] for n in INTEGRALS[3:])
        beta = p["material.damping_time"]

        def rhs(_: float, y: np.ndarray) -> np.ndarray:
            dy = matrix @ y + constant
            speed = y[h + a : 2 * h].sum()
            dy[i] = viscous * speed * speed
            dy[j] = crush * (y[a:h].sum() - mode.lower) * speed if crush else 0.0
            stretch_p, stretch_b = y[h + 1 : h + a], y[h + a + 1 : 2 * h]
            loss = self.piston.rigidity * (stretch_p @ stretch_p)
            dy[k] = beta * (loss + self.bit.rigidity * (stretch_b @ stretch_b))
            return dy

        return rhs

    def guards(self, mode: Mode) -> list[tuple[str, np.ndarray, float]]:
        """Watched functions, each signed so that its event is a rise through zero.

        In the order in which simultaneous events count: contact, rock, relay.
        """
        p, sign = self.p, 1.0 if mode.closed else -1.0
        watched = [("open" if mode.closed else "close", sign * self.gap_row, 0.0)]
        spent = np.eye(self.size)[self.integral["energy_viscous"]]
        limit = p["rock.standstill_speed"]
        rock = {
            "FreeFlight": [("Q1", self.tip, -mode.lower)],
            "DissipativeForward": [
                ("Q2", -self.tip_rate, 0.0),
                ("Q3", spent, -mode.spent_before - p["rock.energy_barrier"]),
            ],
            "Forward": [("Q4", -self.tip_rate, 0.0)],
            "Backward": [("Q5", -self.tip, mode.upper), ("Q6", self.tip_rate, 0.0)],
            "Standstill": [
                ("lift", -self.tip, mode.upper),
                ("Q7", self.tip_rate, -limit),
                ("Q8", -self.tip_rate, -limit),
            ],
        }
        relative = self.mean_piston - self.mean_bit
        up, down = ("Q9", relative, 0.0), ("Q10", -relative, -p["drive.stroke"])
        return [*watched, *rock[mode.rock], up if mode.alpha > 0 else down]

    def transition(self, guard: str, mode: Mode, y: np.ndarray) -> Mode:
        """The mode after an event."""
        ratio, tip = self.p["rock.unloading_ratio"], float(self.tip @ y)
        spent = float(y[self.integral["energy_viscous"]])
        cycle = replace(
            mode,
            rock="DissipativeForward",
            lower=tip - ratio * (tip - mode.upper),
            spent_before=spent,
        )
        if guard in ("open", "close"):
            return replace(mode, closed=guard == "close")
        if guard in ("Q9", "Q10"):
            return replace(mode, alpha=-mode.alpha)
        if guard == "Q1":
            return replace(cycle, lower=mode.lower)
        if guard in ("Q2", "Q4"):
            upper = tip - (tip - mode.lower) / ratio
            return replace(mode, rock="Backward", upper=upper, gain=upper - mode.upper)
        if guard == "Q3":
            return replace(mode, rock="Forward")
        if guard in ("Q5", "lift"):
            return replace(mode, rock="FreeFlight", lower=mode.upper)
        if guard == "Q6" and mode.gain < self.p["rock.standstill_penetration"]:
            return replace(mode, rock="Standstill")
        return replace(mode, rock="Backward") if guard == "Q8" else cycle

    def sample(self, mode: Mode, y: np.ndarray) -> dict[str, Any]:
        """What the FMU shows at a communication point, under the same names."""
        rock, rock0 = self.rock_force(mode)
        values = {
            "piston_position": self.mean_piston @ y + self.p["contact.initial_gap"],
            "piston_velocity": self.rate_piston @ y,
            "bit_position": self.mean_bit @ y,
            "bit_velocity": self.rate_bit @ y,
            "bit_top_position": self.ub[0] @ y,
            "bit_tip_position": self.tip @ y,
            "bit_tip_velocity": self.tip_rate @ y,
            "contact_gap": self.gap_row @ y,
            "contact_force": self.contact_force(mode) @ y,
            "rock_force": rock @ y + rock0,
            "hole_depth": mode.upper,
        }
        values |= {name: y[self.integral[name]] for name in INTEGRALS}
        values |= self.energies(mode, y)
        return {n: float(v) for n, v in values.items()} | {"rock_mode": mode.rock}

    def energies(self, mode: Mode, y: np.ndarray) -> dict[str, float]:
        """Energies that are functions of the state."""
        p, stored = self.p, 0.0
        kinetic = strain = 0.0
        for bar, u, v in ((self.piston, self.up, self.vp), (self.bit, self.ub, self.vb)):
            kinetic += (v @ y) @ bar.inertia @ (v @ y) / 2
            strain += bar.rigidity * np.sum((u[1:] @ y) ** 2) / 2
        stiff, ratio = p["rock.stiffness"], p["rock.unloading_ratio"]
        tip = self.tip @ y
        if mode.rock in ("DissipativeForward", "Forward"):
            stored = stiff * (tip - mode.lower) ** 2 / (2 * ratio)
        elif mode.rock != "FreeFlight":
            stored = ratio * stiff * (tip - mode.upper) ** 2 / 2
        gap = min(0.0, self.gap_row @ y) if mode.closed else 0.0
        return {
            "energy_kinetic": kinetic,
            "energy_strain": strain,
            "energy_contact": p["contact.stiffness"] * gap**2 / 2,
            "energy_rock_stored": stored,
        }


@dataclass
class Run:
    """A trajectory of the oracle."""

    events: list[Event] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    samples: list[dict[str, Any]] = field(default_factory=list)


class Integrator:
    """DOP853 between events; each event found by re-integrating up to it."""

    def __init__(self, hammer: Hammer, tolerance: float) -> None:
        self.hammer, self.last_contact = hammer, -np.inf
        h, size = hammer.half, hammer.size
        scale = np.full(size, 10.0)
        scale[:h], scale[h : 2 * h], scale[2 * h :] = 1e-6, 1.0, 10.0
        self.settings = {"rtol": tolerance, "atol": tolerance * scale}
        self.mode, self.time, self.state = Mode(), 0.0, hammer.start()
        self.before: dict[str, float] = {}
        self.arm("")

    @property
    def resolution(self) -> float:
        """Below this a guard is on neither side of zero."""
        return COARSE if self.time - self.last_contact > QUIET else RESOLUTION

    def arm(self, fired: str) -> None:
        """Values of the guards on the near side of zero, from which a rise counts.

        One that outlived the event keeps a value from before it, so that its own
        crossing at that same instant is not lost; one that starts at zero has
        just been crossed and must first move away.
        """
        armed = {}
        for name, row, constant in self.hammer.guards(self.mode):
            value = float(row @ self.state + constant)
            if name in self.before and name != fired:
                armed[name] = min(self.before[name], value)
            else:
                armed[name] = value if value < -self.resolution else -np.inf
        self.before = armed

    def land(self, time: float) -> np.ndarray:
        """The state at `time`, integrated from the current instant in this mode."""
        if time <= self.time:
            return self.state
        rhs = self.hammer.rate(self.mode)
        solver = DOP853(
            rhs, self.time, self.state, time, first_step=time - self.time, **self.settings
        )
        while solver.status == "running":
            solver.step()
        return solver.y

    def first_crossing(self, solver: DOP853) -> tuple[str, float] | None:
        """First guard that rises through zero in the step just taken."""
        times = np.linspace(solver.t_old, solver.t, LOOKS + 1)
        states = solver.dense_output()(times[1:])
        found: list[tuple[tuple[float, float], str, np.ndarray, float]] = []
        last = {}
        for name, row, constant in self.hammer.guards(self.mode):
            values = np.concatenate(([self.before[name]], row @ states + constant))
            if np.isinf(values[0]):
                if values[1] >= self.resolution:
                    raise RuntimeError(f"{name} returns within one look, t = {times[0]}")
                # Speed that has crept to nothing: neither side of zero until it shows.
                values[np.abs(values) < self.resolution] = -np.inf
            last[name] = values[-1]
            rising = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
            if rising.size:
                found.append((tuple(times[rising[0] : rising[0] + 2]), name, row, constant))
        if not found:
            self.before = last
            return None
        estimates = [(self.refine(t, row, c), name) for t, name, row, c in found]
        return min(estimates, key=lambda e: e[0])[::-1]

    def refine(self, bracket: tuple[float, float], row: np.ndarray, constant: float) -> float:
        """Newton on the integrated state, kept in its bracket: no interpolant enters."""
        rhs, (low, high) = self.hammer.rate(self.mode), bracket
        time = high
        for _ in range(80):
            state = self.land(time)
            value = row @ state + constant
            low, high = (time, high) if value < 0 else (low, time)
            guess = time - value / (row @ rhs(time, state))
            guess = guess if low <= guess <= high else (low + high) / 2
            if abs(guess - time) < 1e-16:
                break
            time = guess
        return float(time)

    def advance(self, end: float, run: Run) -> None:
        """To `end` exactly, through every event on the way."""
        while self.time < end:
            solver = DOP853(
                self.hammer.rate(self.mode), self.time, self.state, end, **self.settings
            )
            crossing = None
            while solver.status == "running" and crossing is None:
                solver.step()
                crossing = self.first_crossing(solver)
                if crossing is None:
                    self.time, self.state = float(solver.t), solver.y
            if crossing is None:
                return
            name, time = crossing
            self.state, self.time = self.land(time), max(time, self.time)
            self.mode = self.hammer.transition(name, self.mode, self.state)
            self.last_contact = self.time if name in ("open", "close") else self.last_contact
            self.arm(name)
            mode = self.mode
            approach = float((self.hammer.rate_piston - self.hammer.rate_bit) @ self.state)
            run.events.append(Event(self.time, name, mode.rock, mode.closed, mode.alpha, approach))


def simulate(p: Mapping[str, float], instants: Sequence[float], tolerance: float) -> Run:
    """Events and samples of the hammer `p` at the given instants."""
    hammer = Hammer(p)
    integrator, run = Integrator(hammer, tolerance), Run()
    for instant in instants:
        integrator.advance(instant, run)
        run.times.append(instant)
        run.samples.append(hammer.sample(integrator.mode, integrator.state))
    return run


def make_first_blow() -> dict[str, Any]:
    """The reference hammer from rest: to 20 ms in full, and two blows to 60 ms.

    Four tolerances. Below 1e-11 the error is rounding, magnified by the events, and no
    longer falls: the largest difference from the finest run is the stated accuracy.
    """
    blow = np.round(np.arange(13.5, 17.0, 0.05), 9)
    quiet = [*range(14), *np.arange(17.0, 20.5, 0.5)]
    instants = np.unique(np.concatenate((blow, quiet))) * 1e-3
    *rough, fine = (simulate(reference(), instants, t) for t in (1e-11, 1e-12, 1e-13, 3e-14))
    order = [(e.guard, e.rock) for e in fine.events]
    if any([(e.guard, e.rock) for e in run.events] != order for run in rough):
        raise RuntimeError("the order of events is in doubt")
    impacts = [blows(tolerance) for tolerance in (1e-12, 3e-13)]
    names = [n for n in fine.samples[0] if n != "rock_mode"]
    table = {n: [s[n] for s in fine.samples] for n in names}
    spread = {
        n: max(
            abs(b[n] - a[n]) for r in rough for a, b in zip(fine.samples, r.samples, strict=True)
        )
        for n in names
    }
    when = [e.time for e in fine.events]
    shift = max(abs(e.time - t) for r in rough for e, t in zip(r.events, when, strict=True))
    return {
        "made_by": "tests/python/oracle_fe.py",
        "blows": impacts[1].tolist(),
        "blow_accuracy": np.max(np.abs(impacts[1] - impacts[0]), axis=0).tolist(),
        "event_time_accuracy": shift,
        "accuracy": spread,
        "events": [asdict(e) for e in fine.events],
        "time": instants.tolist(),
        "rock_mode": [s["rock_mode"] for s in fine.samples],
        "samples": table,
    }


def blows(tolerance: float) -> np.ndarray:
    """Instants and speeds of the first two impacts, rebounds of the bit left out."""
    events = simulate(reference(), [0.06], tolerance).events
    closings = [(e.time, e.approach) for e in events if e.guard == "close"]
    return np.array([b for a, b in pairwise([(-1, 0), *closings]) if b[0] - a[0] > QUIET])


def readable(value: Any, depth: int = 0) -> str:
    """JSON with a line for every event and variable, so that a change shows in review."""
    if depth < 2 and isinstance(value, dict):
        body = ",\n".join(f"{json.dumps(k)}: {readable(v, depth + 1)}" for k, v in value.items())
        return f"{{\n{body}\n}}"
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(json.dumps(v) for v in value) + "\n]"
    return json.dumps(value)


def main() -> None:
    """Writes the stored numbers and says how good they are."""
    stored = make_first_blow()
    (DATA / "first_blow.json").write_text(readable(stored) + "\n")
    print(f"{len(stored['events'])} events, {len(stored['blows'])} blows")
    print(f"blow times and speeds good to {stored['blow_accuracy']}")
    print(f"event times good to {stored['event_time_accuracy']:.1e} s")
    for name, value in stored["accuracy"].items():
        print(f"{name:24} good to {value:.1e}")


if __name__ == "__main__":
    main()
