"""A stepped piston strikes a stepped bit, by elwaspatid's exact characteristics, as JSON.

    python3 -m venv target/venv-elwaspatid
    target/venv-elwaspatid/bin/pip install elwaspatid==2.0.1 "numpy<2" matplotlib
    target/venv-elwaspatid/bin/python evidence/oracles/data/stepped_impact.py \
        > evidence/oracles/data/stepped_impact.json

Piston 0.20 m of diameter 60 mm and 0.15 m of 45 mm at 10 m/s; bit at rest, 0.15 m of 50 mm and
0.10 m of 80 mm; steel. The program glues the bodies: what it says holds until the contact's force
falls to zero, and no further. It steps on two grids that never meet; of the one that has a node in
the contact at the strike, that node would need a velocity of both bodies, so the other is read.
"""

import json

import numpy as np
from elwaspatid import BarSingle, Waveprop

MODULUS, DENSITY, SPEED = 210e9, 7850.0, 10.0
#: Lengths in cells, and diameters, from the top.
CELL, CELLS, DIAMETERS = 1e-3, [200, 150, 150, 100], [0.060, 0.045, 0.050, 0.080]


def main() -> None:
    bars = BarSingle(CELL, np.repeat(DIAMETERS, CELLS), MODULUS, DENSITY)
    contact = CELLS[0] + CELLS[1]
    found = Waveprop(bars, np.zeros(1), nstep=4 * contact, Vinit=SPEED, indV=contact)
    force, time = -found.Force[1::2, contact], found.time[1::2]
    force = force[: int(np.argmax(force <= 1e-6 * force[0]))]
    jumps = np.flatnonzero(np.abs(np.diff(force)) > 1e-6 * force[0])
    ends = [*(jumps + 1), len(force)]
    starts = [0, *ends[:-1]]
    spans = [(time[a] - bars.dt, time[b - 1] + bars.dt) for a, b in zip(starts, ends, strict=True)]
    plateaus = [
        {"from": float(start), "to": float(end), "force": float(force[a])}
        for a, (start, end) in zip(starts, spans, strict=True)
    ]
    answer = {"plateaus": plateaus, "impulse": float(2.0 * bars.dt * force.sum())}
    print(json.dumps(answer, indent=1))


main()
