"""SciPy's solvers on the hammer: DOP853, LSODA and Radau with event detection.

The assembled system comes as text (`bench::export`); the right-hand side is compiled
by numba, the constant Jacobian of each mode is dense. One JSON object a line goes to
standard output: method, tolerance, CPU seconds, states (u then v) at the instants,
events [time, name]; or the reason of a failure.

    python scipy_peer.py system.txt end instant,instant,... method:tolerance ...
"""

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from scipy.integrate import solve_ivp

PATIENCE = 120.0  # CPU seconds a run
ARRAYS = {"lower", "inverse", "dead", "drive", "relative", "start"}

Function = Callable[[float, np.ndarray], Any]
System = dict[str, Any]


def load(path: str) -> System:
    """Reads the system: numbers, and arrays by name."""
    system = {}
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            name, *values = line.split()
            row = np.array([float(value) for value in values])
            array = name in ARRAYS or name[-1].isdigit() or name.endswith("_off")
            system[name] = row if array else row[0]
    return system


@numba.njit
def derivative(
    y: np.ndarray,
    out: np.ndarray,
    forces: np.ndarray,
    k: np.ndarray,
    k_off: np.ndarray,
    c: np.ndarray,
    c_off: np.ndarray,
    lower: np.ndarray,
    inverse: np.ndarray,
    power: float,
) -> None:
    """y = (u, v, psi): u' = v, M v' = forces - K u - C v, psi' = power v_tip^2."""
    n = k.size
    for i in range(n):
        out[i] = y[n + i]
        total = k[i] * y[i] + c[i] * y[n + i]
        if i > 0:
            total += k_off[i - 1] * y[i - 1] + c_off[i - 1] * y[n + i - 1]
        if i + 1 < n:
            total += k_off[i] * y[i + 1] + c_off[i] * y[n + i + 1]
        out[n + i] = forces[i] - total
    for i in range(1, n):
        out[n + i] -= lower[i - 1] * out[n + i - 1]
    out[2 * n - 1] *= inverse[n - 1]
    for i in range(n - 2, -1, -1):
        out[n + i] = out[n + i] * inverse[i] - lower[i] * out[n + i + 1]
    out[2 * n] = power * y[2 * n - 1] ** 2


class Hammer:
    """The discrete state and the laws of model.md."""

    def __init__(self, system: System) -> None:
        self.s = system
        self.n = int(system["nodes"])
        self.bit = int(system["bit"])
        self.closed, self.rock, self.down = False, "SS", True
        self.ul = self.uu = self.gain = 0.0
        self.jacobians = {}

    def index(self) -> int:
        """Which of the eight linear systems holds."""
        rock = {"FF": 0, "DFC": 1, "FC": 2, "BC": 3, "SS": 3}[self.rock]
        return 4 * self.closed + rock

    def forces(self) -> np.ndarray:
        """The constant forces of the mode, N."""
        s = self.s
        f = s["dead"] + (s["amplitude"] if self.down else -s["amplitude"]) * s["drive"]
        if self.closed:
            push = s["contact"] * s["gap"]
            f[self.bit - 1] += push
            f[self.bit] -= push
        if self.rock in ("DFC", "FC"):
            f[-1] += s["loading"] * self.ul
        elif self.rock != "FF":
            f[-1] += s["unloading"] * self.uu
        return f

    def rhs(self, forces: np.ndarray) -> Function:
        """The right-hand side of the mode."""
        s, i = self.s, self.index()
        rows = [s[f"{name}{i}{off}"] for name in "kc" for off in ("", "_off")]
        power = s["viscosity"] if self.rock == "DFC" else 0.0

        def function(_: float, y: np.ndarray) -> np.ndarray:
            out = np.empty_like(y)
            derivative(y, out, forces, *rows, s["lower"], s["inverse"], power)
            return out

        return function

    def jacobian(self) -> tuple[np.ndarray, Function]:
        """Its Jacobian: the constant part, and as a function."""
        if self.index() not in self.jacobians:
            function = self.rhs(np.zeros(self.n))
            unit = np.eye(2 * self.n + 1)
            unit[:, 2 * self.n] = 0.0
            self.jacobians[self.index()] = np.array([function(0, row) for row in unit]).T
        matrix = self.jacobians[self.index()].copy()
        matrix[-1] = 0.0
        if self.rock != "DFC":
            return matrix, lambda _, y: matrix
        power = 2 * self.s["viscosity"]

        def function(_: float, y: np.ndarray) -> np.ndarray:
            matrix[-1, 2 * self.n - 1] = power * y[2 * self.n - 1]
            return matrix

        return matrix, function

    def guards(self) -> list[tuple[str, Function]]:
        """Pairs of an event's name and the function whose rise through zero it is."""
        s, n, bit = self.s, self.n, self.bit
        dx, dv = s["position_resolution"], s["velocity_resolution"]
        vs, d1, wr, relative = s["speed"], s["stroke"], s["barrier"], s["relative"]
        ul, uu, gap = self.ul, self.uu, s["gap"]
        tip, speed = n - 1, 2 * n - 1
        rock = {
            "FF": [("Q1", lambda _, y: y[tip] - ul - dx)],
            "DFC": [("Q2", lambda _, y: -y[speed] - dv), ("Q3", lambda _, y: y[2 * n] - wr)],
            "FC": [("Q4", lambda _, y: -y[speed] - dv)],
            "BC": [
                ("Q5", lambda _, y: uu - y[tip] - dx),
                ("Q6", lambda _, y: y[speed] - dv),
            ],
            "SS": [
                ("LiftOff", lambda _, y: uu - y[tip] - dx),
                ("Q7", lambda _, y: y[speed] - vs - dv),
                ("Q8", lambda _, y: -y[speed] - vs - dv),
            ],
        }[self.rock]
        contact = (
            ("Open", lambda _, y: y[bit] - y[bit - 1] + gap - dx)
            if self.closed
            else ("Close", lambda _, y: y[bit - 1] - y[bit] - gap - dx)
        )
        relay = (
            ("Q9", lambda _, y: relative @ y[:n] - gap - dx)
            if self.down
            else ("Q10", lambda _, y: -(relative @ y[:n] - gap) - d1 - dx)
        )
        guards = [contact, *rock, relay]
        for _, function in guards:
            function.terminal, function.direction = True, 1
        return guards

    def transition(self, event: str, y: np.ndarray) -> None:
        """What an event does; `y` is changed in place."""
        p, gamma = y[self.n - 1], self.s["gamma"]
        if event in ("Close", "Open"):
            self.closed = event == "Close"
        elif event in ("Q9", "Q10"):
            self.down = event == "Q10"
        elif event == "Q1":
            self.rock, y[-1] = "DFC", 0.0
        elif event == "Q3":
            self.rock = "FC"
        elif event == "Q8":
            self.rock = "BC"
        elif event in ("Q2", "Q4"):
            foot = p - (p - self.ul) / gamma
            self.gain, self.uu, self.rock = foot - self.uu, foot, "BC"
        elif event in ("Q5", "LiftOff"):
            self.ul, self.rock = self.uu, "FF"
        elif event == "Q6" and self.gain < self.s["penetration"]:
            self.rock = "SS"
        else:
            self.ul = p - gamma * (p - self.uu)
            self.rock, y[-1] = "DFC", 0.0


def integrate(
    system: System, method: str, tolerance: float, end: float, instants: list[float]
) -> dict[str, Any]:
    """Solves from rest to `end`."""
    hammer = Hammer(system)
    n = hammer.n
    y = np.concatenate([system["start"], np.zeros(n + 1)])
    atol = np.concatenate([np.full(n, 1e-3 * tolerance), np.full(n + 1, tolerance)])
    t, states, events = 0.0, [], []
    clock = time.process_time()
    for stop in [*instants, end]:
        while t < stop:
            if time.process_time() - clock > PATIENCE:
                raise TimeoutError(f"gave up at {t:.6f} s")
            options = {}
            if method in ("LSODA", "Radau"):
                matrix, function = hammer.jacobian()
                constant = method == "Radau" and hammer.rock != "DFC"
                options["jac"] = matrix if constant else function
            guards = hammer.guards()
            solution = solve_ivp(
                hammer.rhs(hammer.forces()),
                (t, stop),
                y,
                method=method,
                rtol=max(tolerance, 3e-14),
                atol=atol,
                events=[function for _, function in guards],
                **options,
            )
            if solution.status < 0:
                raise ArithmeticError(solution.message)
            t, y = solution.t[-1], solution.y[:, -1].copy()
            if solution.status == 1:
                name = next(
                    name
                    for (name, _), times in zip(guards, solution.t_events, strict=True)
                    if times.size
                )
                events.append([t, name])
                hammer.transition(name, y)
        if stop < end:
            states.append(y[:-1].tolist())
    return {"cpu": time.process_time() - clock, "states": states, "events": events}


def main() -> None:
    """Runs every method:tolerance asked for."""
    path, end, instants, *runs = sys.argv[1:]
    system = load(path)
    instants = [float(instant) for instant in instants.split(",")]
    Hammer(system).rhs(np.zeros(int(system["nodes"])))(0.0, np.zeros(2 * int(system["nodes"]) + 1))
    for run in runs:
        method, tolerance = run.split(":")
        report = {"method": method, "tolerance": float(tolerance)}
        try:
            report |= integrate(system, method, float(tolerance), float(end), instants)
        except (TimeoutError, ArithmeticError) as error:
            report["failure"] = str(error)
        print(json.dumps(report), flush=True)


main()
