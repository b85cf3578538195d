"""Blows of hammers that air drives, by SciPy, for `hammer/tests/air_solved.rs`.

    python evidence/oracles/data/air.py > evidence/oracles/data/air.json    # NumPy, SciPy

Written from the equations of the model, not from the engine: the air as mass and inner energy of
each chamber, with the work of its pressure; bars of linear elements or rigid bodies in their own
displacements, a rigid casing; every transition and every port's edge a located event. Radau's
method follows the rigid bodies, the explicit one of order 8 the bars, whose waves are no stiffer
than they must be resolved. With a tolerance of 1e-11 in place of 1e-10 the rigid hammer in its
casing strikes at the same times within 1e-10. The bars take short steps, so that no contact opens
and closes again inside of one.
"""

import json
import sys

import numpy as np
from scipy.integrate import solve_ivp

GAS, KAPPA = 287.05, 1.4
CHOKED = (2 / (KAPPA + 1)) ** (KAPPA / (KAPPA - 1))
TOLERANCE = float(sys.argv[1]) if len(sys.argv) > 1 else 1e-10

AIR = {
    "drive_dead": 6e-5,
    "return_dead": 5e-5,
    "cylinder": 0.07,
    "edges": [[-0.030, -0.020], [-0.015, -0.035]],
    "height": 4e-3,
    "supply_area": 6.25e-5,
    "exhaust_area": 1.5e-4,
    "discharge": 0.8,
    "leakage": 2e-6,
    "drag": 5.0,
    "temperature": 300.0,
    "supply": 1.5e6,
    "exhaust": 101325.0,
    "areas": [1.5e-3, 1.5e-3],
}
STEEL = {
    "E": 210e9, "rho": 7850.0, "A": 2.6e-3, "L": 0.168, "beta": 2e-8, "KC": 1e11, "g0": 0.05,
    "KR": 1.2e8, "gamma": 4.0, "CR": 2.5e4, "WR": 1.2, "vs": 1e-3, "dps": 1e-6, "G": 9.81,
    "ks": 1e9, "cs": 1e4,
}  # fmt: skip
SCENES = [
    {"name": "rigid", "elements": 0, "casing": 0.0, "feed": 5e3, "until": 0.16},
    {"name": "rigid, in a casing", "elements": 0, "casing": 30.0, "feed": 8e3, "until": 0.16},
    {"name": "elastic", "elements": 3, "casing": 0.0, "feed": 5e3, "until": 0.055},
    {"name": "elastic, in a casing", "elements": 3, "casing": 30.0, "feed": 8e3, "until": 0.055},
]


def flow(area, one, other):
    """From the first side (pressure, temperature) to the second, kg/s, and its temperature."""
    sign = 1.0
    if other[0] > one[0]:
        one, other, sign = other, one, -1.0
    (high, hot), low = one, other[0]
    r, scale = low / high, 1.0
    if r > 0.995:
        scale, r = (1 - r) / 0.005, 0.995
    r = max(r, CHOKED)
    shape = np.sqrt(r ** (2 / KAPPA) - r ** ((KAPPA + 1) / KAPPA))
    return sign * scale * area * high * np.sqrt(2 * KAPPA / ((KAPPA - 1) * GAS * hot)) * shape, hot


def bar(n):
    """Mass and stiffness of the uniform bar in n linear elements; with none, of a rigid body."""
    s = STEEL
    mass = s["rho"] * s["A"] * s["L"]
    if n == 0:
        return np.array([[mass]]), np.zeros((1, 1))
    h = s["L"] / n
    m, k = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    for e in range(n):
        i = slice(e, e + 2)
        m[i, i] += s["rho"] * s["A"] * h / 6 * np.array([[2, 1], [1, 2]])
        k[i, i] += s["E"] * s["A"] / h * np.array([[1, -1], [-1, 1]])
    return m, k


class Run:
    def __init__(self, scene):
        self.scene, s = scene, STEEL
        (m, k), n = bar(scene["elements"]), scene["elements"] + 1
        size = 2 * n + (scene["casing"] > 0)
        self.n, self.size = n, size
        mass, stiff = np.zeros((size, size)), np.zeros((size, size))
        mass[:n, :n], mass[n : 2 * n, n : 2 * n] = m, m
        stiff[:n, :n], stiff[n : 2 * n, n : 2 * n] = k, k
        if scene["casing"]:
            mass[-1, -1] = scene["casing"]
        self.inverse, self.stiff = np.linalg.inv(mass), stiff
        body = s["rho"] * s["A"] * s["L"]
        self.mass = body

        def share(i: list[int]) -> np.ndarray:
            return mass[:, i].sum(axis=1)

        piston, bit = range(n), range(n, 2 * n)
        self.spread = share(list(piston))  # of a force on the piston, times its mass
        self.bit_spread = share(list(bit))
        self.piston, self.bit = self.spread / body, self.bit_spread / body

        def unit(i: int) -> np.ndarray:
            return np.eye(size)[i]

        self.gap = unit(n) - unit(n - 1)
        self.top, self.tip = unit(n), unit(2 * n - 1)
        self.casing = unit(size - 1) if scene["casing"] else np.zeros(size)
        self.chuck = self.top - self.casing
        self.relative = self.piston - (self.casing if scene["casing"] else self.bit)
        self.over = self.piston - self.bit
        self.weight = s["G"] * (self.spread + self.bit_spread + scene["casing"] * self.casing)
        self.contact = s["KC"]
        if scene["elements"] == 0:
            own = np.pi**2 * s["E"] * s["A"] / (4 * 2 * s["L"])
            self.contact = 1 / (1 / s["KC"] + 1 / own)
        self.closed, self.shoulder, self.rock = False, scene["casing"] > 0, "SS"
        self.ul = self.uu = self.gain = 0.0
        self.start()

    def volumes(self, x, y):
        a = AIR
        return np.array([
            a["drive_dead"] + a["areas"][0] * (a["cylinder"] + x),
            a["return_dead"] - a["areas"][1] * y,
        ])  # fmt: skip

    def openings(self, x):
        """-1 closed, 0 in part, 1 wholly open, of each chamber supply and exhaust."""
        states = []
        for chamber in range(2):
            for port in range(2):
                way = 1.0 if (chamber == 0) == (port == 1) else -1.0
                beyond = way * (x - AIR["edges"][chamber][port])
                states.append(-1 if beyond < 0 else 0 if beyond < AIR["height"] else 1)
        return states

    def start(self):
        s, scene = STEEL, self.scene
        q = np.zeros(self.size)
        self.ports = self.openings(-s["g0"])
        p = [AIR["supply"] if self.ports[2 * c] >= 0 else AIR["exhaust"] for c in range(2)]
        ad, ar = AIR["areas"]
        drive = (p[0] - AIR["exhaust"]) * ad - (p[1] - AIR["exhaust"]) * ar
        anvil = (p[1] - AIR["exhaust"]) * ar
        above = (
            scene["feed"] + scene["casing"] * s["G"] - (drive + anvil if scene["casing"] else 0.0)
        )
        # The bit stands: its stiffness, that of the rock, what presses on it from above.
        rows = np.arange(self.n, 2 * self.n)
        k = self.stiff[np.ix_(rows, rows)].copy()
        k[-1, -1] += s["gamma"] * s["KR"]
        load = (s["G"] * self.bit_spread)[rows]
        load[0] += above
        load += anvil * self.bit[rows]
        q[rows] = np.linalg.solve(k, load)
        if scene["casing"]:
            q[-1] = q[self.n] + above / s["ks"]
        x = self.relative @ q - s["g0"]
        self.ports = self.openings(x)
        volumes = self.volumes(x, self.over @ q - s["g0"])
        content = []
        for c in range(2):
            content += [
                p[c] * volumes[c] / (GAS * AIR["temperature"]),
                p[c] * volumes[c] / (KAPPA - 1),
            ]
        self.y = np.concatenate([q, np.zeros(self.size), content, [0.0, 0.0]])  # psi, air taken
        self.turned = s["gamma"] * s["KR"] * (self.tip @ q)

    def rates(self, _t, y):
        s, n = STEEL, self.size
        q, v, gas = y[:n], y[n : 2 * n], y[2 * n : 2 * n + 4]
        x, speed = self.relative @ q - s["g0"], self.relative @ v
        volumes = self.volumes(x, self.over @ q - s["g0"])
        pressures = (KAPPA - 1) * gas[1::2] / volumes
        sides = [
            (pressures[c], gas[2 * c + 1] * (KAPPA - 1) / (GAS * gas[2 * c])) for c in range(2)
        ]
        supply, exhaust = ((AIR[k], AIR["temperature"]) for k in ("supply", "exhaust"))
        rate, taken, cp = np.zeros(4), 0.0, KAPPA * GAS / (KAPPA - 1)
        swelling = [AIR["areas"][0] * speed, -AIR["areas"][1] * (self.over @ v)]
        for c in range(2):
            for port, outside in enumerate((supply, exhaust)):
                state = self.ports[2 * c + port]
                if state < 0:
                    continue
                way = 1.0 if (c == 0) == (port == 1) else -1.0
                share = 1.0 if state > 0 else way * (x - AIR["edges"][c][port]) / AIR["height"]
                area = AIR["discharge"] * share * AIR[("supply_area", "exhaust_area")[port]]
                gain, hot = flow(area, outside, sides[c])
                rate[2 * c] += gain
                rate[2 * c + 1] += cp * gain * hot
                taken += gain if port == 0 else 0.0
            rate[2 * c + 1] -= pressures[c] * swelling[c]
        leak, hot = flow(AIR["leakage"], sides[0], sides[1])
        rate += np.array([-leak, -cp * leak * hot, leak, cp * leak * hot])
        beyond = pressures - AIR["exhaust"]
        drive = beyond @ (np.array(AIR["areas"]) * [1, -1]) - AIR["drag"] * speed
        anvil = beyond[1] * AIR["areas"][1]
        force = self.weight + drive * self.piston + anvil * self.bit
        if self.scene["casing"]:
            force = force + (self.scene["feed"] - drive - anvil) * self.casing
        else:
            force = force + self.scene["feed"] * self.top
        force = force - self.stiff @ (q + s["beta"] * v)
        if self.closed:
            force = force - self.contact * (self.gap @ q + s["g0"]) * self.gap
        if self.shoulder:
            force = force - (s["ks"] * (self.chuck @ q) + s["cs"] * (self.chuck @ v)) * self.chuck
        p, pv = self.tip @ q, self.tip @ v
        force = force - self.resistance(p, pv) * self.tip
        psi = s["CR"] * pv**2 if self.rock == "DFC" else 0.0
        return np.concatenate([v, self.inverse @ force, rate, [psi, taken]])

    def resistance(self, p, pv):
        s = STEEL
        return {
            "FF": 0.0, "DFC": s["KR"] * (p - self.ul) + s["CR"] * pv, "FC": s["KR"] * (p - self.ul),
            "BC": s["gamma"] * s["KR"] * (p - self.uu), "SS": s["gamma"] * s["KR"] * (p - self.uu),
        }[self.rock]  # fmt: skip

    def guards(self):
        """Functions, directions and what they lead to."""
        s, n = STEEL, self.size
        tip, speed = (lambda y: self.tip @ y[:n]), (lambda y: self.tip @ y[n : 2 * n])
        gap, chuck = (lambda y: self.gap @ y[:n] + s["g0"]), (lambda y: self.chuck @ y[:n])
        psi, vr = (lambda y: y[2 * n + 4] - s["WR"]), (lambda y: self.relative @ y[:n] - s["g0"])
        rock = {
            "FF": [(lambda y: tip(y) - self.ul, 1, "touch")],
            "DFC": [(speed, -1, "turn"), (psi, 1, "barrier")],
            "FC": [(speed, -1, "turn")],
            "BC": [(lambda y: tip(y) - self.uu, -1, "lift"), (speed, 1, "return")],
            "SS": [(lambda y: speed(y) - s["vs"], 1, "restart"),
                   (lambda y: speed(y) + s["vs"], -1, "back"),
                   (lambda y: tip(y) - self.uu, -1, "lift")],
        }[self.rock]  # fmt: skip
        found = [(gap, 1 if self.closed else -1, "contact"), *rock]
        if self.scene["casing"]:
            found.append((chuck, 1 if self.shoulder else -1, "chuck"))
        for chamber in range(2):
            for port in range(2):
                place, edge = 2 * chamber + port, AIR["edges"][chamber][port]
                way = 1 if (chamber == 0) == (port == 1) else -1
                full, state = edge + way * AIR["height"], self.ports[place]
                ends = {
                    -1: [(edge, way, 0)],
                    0: [(edge, -way, -1), (full, way, 1)],
                    1: [(full, -way, 0)],
                }
                for level, direction, to in ends[state]:
                    found.append((lambda y, level=level: vr(y) - level, direction, (place, to)))
        return found

    def switch(self, event, y):
        s, n = STEEL, self.size
        p = self.tip @ y[:n]
        if event == "contact":
            self.closed = not self.closed
        elif event == "chuck":
            self.shoulder = not self.shoulder
        elif isinstance(event, tuple):
            self.ports[event[0]] = event[1]
        elif event in ("touch",):
            self.rock, y[2 * n + 4] = "DFC", 0.0
        elif event == "barrier":
            self.rock = "FC"
        elif event == "turn":
            before, self.uu = self.uu, p - (p - self.ul) / s["gamma"]
            self.gain, self.rock = self.uu - before, "BC"
        elif event == "lift":
            self.ul, self.rock = self.uu, "FF"
        elif event == "back":
            self.rock = "BC"
        elif event == "return" and self.gain < s["dps"]:
            self.rock = "SS"
        else:
            self.ul, self.rock, y[2 * n + 4] = p - s["gamma"] * (p - self.uu), "DFC", 0.0

    def until(self, end):
        """Blows: time, relative mean speed, air taken; then pressures at the end."""
        t, y, n = 0.0, self.y, self.size
        elastic = self.scene["elements"] > 0
        # Displacements of 1e-2 m, speeds of 10 m/s, masses of 1e-4 kg, energies of 100 J.
        sizes = [1e-2] * n + [10.0] * n + [1e-4, 1e2, 1e-4, 1e2, 1.0, 1e-2]
        blows, risen = [], True
        while t < end:
            guards, events = self.guards(), []
            for function, direction, _ in guards:
                # What has just crossed starts beyond, by rounding.

                def event(_t, y, f=function):
                    return f(y)

                event.terminal, event.direction = True, direction
                events.append(event)
            got = solve_ivp(
                self.rates, (t, end), y, method="DOP853" if elastic else "Radau", events=events,
                rtol=TOLERANCE, atol=TOLERANCE * np.array(sizes),
                max_step=1e-6 if elastic else 2e-4,
            )  # fmt: skip
            t, y = got.t[-1], got.y[:, -1].copy()
            speeds = got.y[n : 2 * n]
            risen = risen or bool((self.piston @ speeds < 0).any())
            fired = [k for k, times in enumerate(got.t_events) if len(times)]
            if not fired:
                break
            event = guards[fired[0]][2]
            closing = event == "contact" and not self.closed
            self.switch(event, y)
            if closing and risen and self.piston @ y[n : 2 * n] > 0:
                speed = (self.piston - self.bit) @ y[n : 2 * n]
                blows.append([t, speed, y[2 * n + 5]])
                risen = False
        x = self.relative @ y[:n] - STEEL["g0"]
        volumes = self.volumes(x, self.over @ y[:n] - STEEL["g0"])
        pressures = (KAPPA - 1) * y[2 * n : 2 * n + 4][1::2] / volumes
        return {
            **self.scene,
            "blows": blows,
            "pressures": list(pressures),
            "position": x,
            "air": y[2 * n + 5],
        }


if __name__ == "__main__":
    only = sys.argv[2] if len(sys.argv) > 2 else ""
    solved = [Run(scene).until(scene["until"]) for scene in SCENES if only in scene["name"]]
    json.dump({"air": AIR, "steel": STEEL, "scenes": solved}, sys.stdout, indent=1)
