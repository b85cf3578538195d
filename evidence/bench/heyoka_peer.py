"""heyoka (Taylor series compiled by LLVM, certified events) on the rigid air hammer of a `Case`.

    python heyoka_peer.py case.json tolerance repeats

One integrator is compiled for each discrete mode that occurs, of its formulas and its guards
alone. That is set-up. The time that counts is the least of the repeats that passes inside the
integrators: transitions in Python are left out. Prints an `Answer` as JSON.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import heyoka as hy

CASE: dict[str, Any] = json.loads(Path(sys.argv[1]).read_text("utf-8"))
TOLERANCE, REPEATS = float(sys.argv[2]), int(sys.argv[3])
# Units of displacement, mass and energy in which the tolerance is absolute.
LENGTH, MASS, ENERGY = 1e-2, 1e-2, 1e3
FF, DFC, FC, BC, SS = range(5)
SHUT, PARTIAL, WHOLE = range(3)
STRAIGHT, SUBSONIC, CHOKED = range(3)
GAS, KAPPA, EDGE = 287.05, 1.4, 0.995
CRITICAL = (2 / (KAPPA + 1)) ** (KAPPA / (KAPPA - 1))
# How far beyond its bound a ratio of pressures changes the formula.
PASSED = 1e-12
# Sides of the flow paths (supply, exhaust, both chambers); direction of x that opens each port.
ENDS = [(0, 2), (2, 1), (0, 3), (3, 1), (2, 3)]
WAY = [-1, 1, 1, -1]

NEAR, SLOW = CASE["position_resolution"], CASE["velocity_resolution"]
AIR = CASE["air"]
AREA, DEAD, CYLINDER, EDGES, HEIGHT = AIR[0:2], AIR[2:4], AIR[4], AIR[5:9], AIR[9]
PORT, DISCHARGE, LEAK, DRAG, WARM, OUTSIDE = (
    AIR[10:12],
    AIR[12],
    AIR[13],
    AIR[14],
    AIR[15],
    AIR[16:],
)
U = hy.make_vars("u0", "u1")
V = hy.make_vars("v0", "v1")
PSI = hy.make_vars("psi")
CONTENT = hy.make_vars("md", "ed", "mr", "er")
NAMES = [*U, *V, PSI, *CONTENT]


def jet(ratio: float) -> float:
    """Returns the shape of a flow at this ratio of pressures."""
    return math.sqrt(ratio ** (2 / KAPPA) - ratio ** ((KAPPA + 1) / KAPPA))


def gas(x: Any, content: Any) -> list[tuple[Any, Any]]:
    """Returns pressure and temperature of supply, exhaust and both chambers."""
    rooms = [DEAD[0] + AREA[0] * (CYLINDER + x), DEAD[1] - AREA[1] * x]
    sides = [(OUTSIDE[0], WARM), (OUTSIDE[1], WARM)]
    for i, room in enumerate(rooms):
        mass, energy = content[2 * i] * MASS, content[2 * i + 1] * ENERGY
        sides.append(((KAPPA - 1) * energy / room, (KAPPA - 1) * energy / (GAS * mass)))
    return sides


class Mode:
    """The rock's mode, the contact, the ports' openings, the flows' formulas and directions."""

    def __init__(self) -> None:
        self.rock, self.closed = SS, 0
        self.open, self.flows, self.back = [SHUT] * 4, [0] * 5, [0] * 5

    def key(self) -> tuple[Any, ...]:
        """Returns the mode as a key."""
        return (self.rock, self.closed, *self.open, *self.flows, *self.back)

    def classify(self, path: int, sides: list[tuple[Any, Any]]) -> None:
        """Gives a flow the formula of the present pressures."""
        one, other = (sides[i][0] for i in ENDS[path])
        ratio = min(one, other) / max(one, other)
        self.flows[path] = STRAIGHT if ratio > EDGE else SUBSONIC if ratio > CRITICAL else CHOKED
        self.back[path] = int(other > one)

    def integrator(self, state: list[float]) -> tuple[Any, list[tuple[Any, ...]]]:
        """Compiles equations with guards; returns them with what each guard means."""
        u = [c * LENGTH for c in U]
        x = sum(r * c for r, c in zip(CASE["relative"], u, strict=True)) - CASE["gap"]
        speed = sum(r * c for r, c in zip(CASE["relative"], V, strict=True))
        guards: list[Any] = []
        meanings: list[tuple[Any, ...]] = []

        def guard(rises: Any, *meaning: Any) -> None:
            guards.append(hy.t_event(rises, direction=hy.event_direction.positive))
            meanings.append(meaning)

        sides = gas(x, CONTENT)
        rates = self.flow(x, sides, guard)
        self.ports(x, guard)
        drive, back = sides[2][0], sides[3][0]
        rest = (back - OUTSIDE[1]) * AREA[1]
        pushes = [(drive - OUTSIDE[1]) * AREA[0] - rest - DRAG * speed, rest]
        rates[1] -= drive * AREA[0] * speed / ENERGY
        rates[3] += back * AREA[1] * speed / ENERGY
        self.bodies(u, guard)
        lost = CASE["viscosity"] * V[1] * V[1] if self.rock == DFC else hy.expression(0.0)
        speeds = [v / LENGTH for v in V]
        equations = [*speeds, *self.accelerations(u, pushes), lost, *rates]
        system = list(zip(NAMES, equations, strict=True))
        return hy.taylor_adaptive(system, state, tol=TOLERANCE, t_events=guards), meanings

    def flow(self, x: Any, sides: Any, guard: Callable[..., None]) -> list[Any]:
        """Returns the rates of both chambers' mass and energy, without the works."""
        rates = [hy.expression(0.0)] * 4
        for path, ends in enumerate(ENDS):
            size = DISCHARGE * (LEAK if path == 4 else PORT[path % 2])
            if path < 4 and self.open[path] == PARTIAL:
                size = size * WAY[path] / HEIGHT * (x - EDGES[path])
            if (path < 4 and self.open[path] == SHUT) or (path == 4 and LEAK == 0.0):
                continue
            (high, hot), (low, _) = sides[ends[self.back[path]]], sides[ends[1 - self.back[path]]]
            ratio, law = low / high, self.flows[path]
            if law == STRAIGHT:
                shape = jet(EDGE) / (1 - EDGE) * (high - low)
                guard(EDGE - ratio - PASSED, "flow", path, 0)
                guard(ratio - 1.0 - PASSED, "flow", path, 1)
            elif law == SUBSONIC:
                root = ratio ** (5 / 7)
                shape = hy.sqrt(root * (root - ratio)) * high
                guard(CRITICAL - ratio - PASSED, "flow", path, 0)
                guard(ratio - EDGE - PASSED, "flow", path, 1)
            else:
                shape = jet(CRITICAL) * high
                guard(ratio - CRITICAL - PASSED, "flow", path, 1)
            nozzle = 2 * KAPPA / ((KAPPA - 1) * GAS) / hot
            root = math.sqrt(nozzle) if isinstance(nozzle, float) else hy.sqrt(nozzle)
            mass = (-1.0 if self.back[path] else 1.0) * size * root * shape
            heat = KAPPA * GAS / (KAPPA - 1) * mass * hot
            for end, sign in zip(ends, (-1.0, 1.0), strict=True):
                if end >= 2:
                    rates[2 * end - 4] += sign * mass / MASS
                    rates[2 * end - 3] += sign * heat / ENERGY
        return rates

    def ports(self, x: Any, guard: Callable[..., None]) -> None:
        """Guards of the ports' edges."""
        for port, opening in enumerate(self.open):
            beyond = WAY[port] * (x - EDGES[port])
            if opening == SHUT:
                guard(beyond - NEAR, "port", port, False)
            elif opening == PARTIAL:
                guard(-beyond - NEAR, "port", port, False)
                guard(beyond - HEIGHT - NEAR, "port", port, True)
            else:
                guard(HEIGHT - beyond - NEAR, "port", port, True)

    def bodies(self, u: list[Any], guard: Callable[..., None]) -> None:
        """Guards of contact and rock, lowered by their resolution."""
        gap, tip, fast = u[1] - u[0] + CASE["gap"], u[1], V[1]
        guard((gap if self.closed else -gap) - NEAR, "Open" if self.closed else "Close")
        below, above = hy.par[0], hy.par[1]
        if self.rock == FF:
            guard(tip - below - NEAR, "Q1")
        elif self.rock == DFC:
            guard(-fast - SLOW, "Q2")
            guard(PSI - CASE["barrier"], "Q3")
        elif self.rock == FC:
            guard(-fast - SLOW, "Q4")
        elif self.rock == BC:
            guard(above - tip - NEAR, "Q5")
            guard(fast - SLOW, "Q6")
        else:
            guard(above - tip - NEAR, "LiftOff")
            guard(fast - CASE["speed"] - SLOW, "Q7")
            guard(-fast - CASE["speed"] - SLOW, "Q8")

    def accelerations(self, u: list[Any], pushes: list[Any]) -> list[Any]:
        """Returns both bodies' accelerations; a rigid hammer's mass matrix is diagonal."""
        index = 4 * self.closed + (3 if self.rock == SS else self.rock)
        k, k_off, c, c_off = (CASE[f"{name}{index}{off}"] for name in "kc" for off in ("", "_off"))
        tied = CASE["contact"] * CASE["gap"] if self.closed else 0.0
        held = [tied, -tied]
        foot = {FF: 0.0, DFC: CASE["loading"] * hy.par[0], FC: CASE["loading"] * hy.par[0]}
        foot_force = foot.get(self.rock, CASE["unloading"] * hy.par[1])
        forces = []
        for i in range(2):
            force = CASE["dead"][i] + held[i] + pushes[i] + (foot_force if i else 0.0)
            force -= k[i] * u[i] + k_off[0] * u[1 - i] + c[i] * V[i] + c_off[0] * V[1 - i]
            forces.append(force * CASE["inverse"][i])
        return forces

    def pass_edge(self, port: int, full: bool, sides: Any) -> dict[str, Any]:
        """Opens or shuts a port by one state; returns the event."""
        opens = self.open[port] == (PARTIAL if full else SHUT)
        self.open[port] = (WHOLE if full else SHUT) if self.open[port] == PARTIAL else PARTIAL
        if self.open[port] == PARTIAL and not full:
            self.classify(port, sides)
        return {"Whole" if full else "Port": [port // 2, port % 2, opens]}

    def change_flow(self, path: int, up: int) -> None:
        """Gives a flow its next formula."""
        if up and self.flows[path] == STRAIGHT:
            self.back[path] ^= 1
        else:
            self.flows[path] += -1 if up else 1

    def transit(
        self, what: str, y: list[float], levels: tuple[float, float, float]
    ) -> tuple[float, float, float]:
        """Makes a transition of contact or rock; returns `ul`, `uu` and the last gain."""
        (below, above, gain), tip = levels, y[1] * LENGTH
        if what in ("Close", "Open"):
            self.closed = int(what == "Close")
        elif what in ("Q2", "Q4"):
            foot = tip - (tip - below) / CASE["gamma"]
            gain, above, self.rock = foot - above, foot, BC
        elif what in ("Q5", "LiftOff"):
            below, self.rock = above, FF
        elif what in ("Q3", "Q8"):
            self.rock = FC if what == "Q3" else BC
        elif what == "Q6" and gain < CASE["penetration"]:
            self.rock = SS
        else:
            y[4] = 0.0
            if what != "Q1":
                below = tip - CASE["gamma"] * (tip - above)
            self.rock = DFC
        return below, above, gain


def place(y: list[float]) -> float:
    """Returns the piston's position relative to the bit."""
    return sum(r * c * LENGTH for r, c in zip(CASE["relative"], y[:2], strict=True)) - CASE["gap"]


INTEGRATORS: dict[tuple[Any, ...], Any] = {}


def start() -> tuple[Mode, list[float]]:
    """Returns mode and state at rest."""
    mode, y = Mode(), [*(c / LENGTH for c in CASE["start"]), *[0.0] * 7]
    x = place(y)
    for port in range(4):
        beyond = WAY[port] * (x - EDGES[port])
        mode.open[port] = SHUT if beyond < 0 else PARTIAL if beyond < HEIGHT else WHOLE
    for i, room in enumerate([DEAD[0] + AREA[0] * (CYLINDER + x), DEAD[1] - AREA[1] * x]):
        work = OUTSIDE[int(mode.open[2 * i] == SHUT)] * room
        y[5 + 2 * i] = work / (GAS * WARM) / MASS
        y[6 + 2 * i] = work / (KAPPA - 1) / ENERGY
    for path in range(5):
        mode.classify(path, gas(x, y[5:]))
    return mode, y


def solve() -> tuple[list[list[float]], list[tuple[float, Any]], float]:
    """Returns states, events, and the time inside the integrators, s."""
    mode, y = start()
    levels, now, inside = (0.0, 0.0, 0.0), 0.0, 0.0
    events: list[tuple[float, Any]] = []
    states = []
    for stop in [*CASE["instants"], CASE["end"]]:
        while True:
            if mode.key() not in INTEGRATORS:
                INTEGRATORS[mode.key()] = mode.integrator(y)
            integrator, meanings = INTEGRATORS[mode.key()]
            integrator.time, integrator.state[:] = now, y
            integrator.pars[:] = levels[: len(integrator.pars)]
            integrator.reset_cooldowns()
            begun = time.perf_counter()
            outcome = integrator.propagate_until(stop)[0]
            inside += time.perf_counter() - begun
            now, y = integrator.time, [*integrator.state]
            if outcome == hy.taylor_outcome.time_limit:
                break
            what, *which = meanings[-int(outcome) - 1]
            if what == "flow":
                mode.change_flow(*which)
                continue
            if what == "port":
                events.append((now, mode.pass_edge(*which, gas(place(y), y[5:]))))
                continue
            events.append((now, what))
            levels = mode.transit(what, y, levels)
        if stop < CASE["end"]:
            states.append([c * LENGTH for c in y[:2]] + y[2:4])
    return states, events, inside


def main() -> None:
    """Compiles in a first run, then times."""
    hy.llvm_state.set_diskcache_enabled(False)
    begun = time.process_time()
    solve()
    setup = time.process_time() - begun
    cpu = math.inf
    for _ in range(REPEATS):
        states, events, inside = solve()
        cpu = min(cpu, inside)
    json.dump({"cpu": cpu, "setup": setup, "states": states, "events": events}, sys.stdout)


if __name__ == "__main__":
    main()
