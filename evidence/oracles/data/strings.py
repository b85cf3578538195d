"""Pistons strike drawn drill strings on fixed rock, by elwaspatid's exact characteristics, as JSON.

    python3 -m venv target/venv-elwaspatid
    target/venv-elwaspatid/bin/pip install elwaspatid==2.0.1 "numpy<2" matplotlib
    target/venv-elwaspatid/bin/python evidence/oracles/data/strings.py \
        > evidence/oracles/data/strings.json

The program glues piston and string: what a place feels is true until a wave has come there from
the contact's first pull. It steps on two grids that never meet, and the one without a node in the
contact at the strike is read. Kept are the middles of the longest spells of constant force, in the
middle of the first and the last rod and at the fixed tip.
"""

import json
from itertools import pairwise

import numpy as np
from elwaspatid import BarSingle, Waveprop

MODULUS, DENSITY, SPEED = 210e9, 7850.0, 10.0
CELL = 0.01
#: Rods of the drawn strings, spells kept of each place, and the least cells of a spell.
RODS, SPELLS, LEAST = (1, 2, 3, 4, 6, 8), 4, 46


def draw(noise):
    """Length in cells and area in square metres of piston, shank, rod, coupling and bit."""
    cells = {
        "piston": (50, 90),
        "shank": (50, 90),
        "rod": (50, 80),
        "coupling": (24, 36),
        "bit": (24, 40),
    }
    areas = {
        "piston": (1, 2),
        "shank": (1.5, 2),
        "rod": (1, 1.6),
        "coupling": (2.5, 4),
        "bit": (2, 5),
    }
    half = {"piston": 1, "shank": 1, "rod": 1, "coupling": 2, "bit": 1}
    whole = {
        name: int(noise.integers(*bounds)) // half[name] * half[name]
        for name, bounds in cells.items()
    }
    return {name: [whole[name], round(1e-3 * noise.uniform(*areas[name]), 6)] for name in cells}


def sections(string, rods):
    """Cells and areas from the piston down: a sleeve covers half its length of either neighbour."""
    (shank, a), (rod, b), (sleeve, c) = string["shank"], string["rod"], string["coupling"]
    rows = [string["piston"], [shank - sleeve // 2, a]]
    for k in range(rods):
        rows += [[sleeve, c], [rod - (sleeve if k + 1 < rods else sleeve // 2), b]]
    return [*rows, string["bit"]]


def spells(force, time, half):
    """Middles of the longest spells of constant force, and the time from there to a step."""
    jumps = np.flatnonzero(np.abs(np.diff(force)) > 1e-6 * np.abs(force).max())
    edges = [0, *(jumps + 1), len(force)]
    # A grid's steps are two cells apart.
    found = [(b - a, a, b) for a, b in pairwise(edges[1:]) if 2 * (b - a) >= LEAST]
    for _, a, b in sorted(sorted(found, reverse=True)[:SPELLS], key=lambda spell: spell[1]):
        middle, apart = 0.5 * (time[a] + time[b - 1]), 0.5 * (time[b - 1] - time[a]) + half
        yield {"time": float(middle), "force": float(force[(a + b) // 2]), "apart": float(apart)}


def solve(rods, noise):
    """A string and what its places feel."""
    string = draw(noise)
    rows = sections(string, rods)
    counts, areas = zip(*rows, strict=True)
    contact, total = counts[0], sum(counts)
    bars = BarSingle(
        CELL, np.repeat(np.sqrt(4 * np.array(areas) / np.pi), counts), MODULUS, DENSITY
    )
    steps = 2 * total + 4 * contact
    found = Waveprop(bars, np.zeros(1), nstep=steps, right="fixed", Vinit=SPEED, indV=contact)
    pulled = found.Force[1::2, contact] > 1e-6 * found.Force[1, contact]
    # In a glued string the contact's force is negative while it presses.
    first = 1 + 2 * int(np.argmax(pulled)) if pulled.any() else steps
    tops = np.cumsum(counts)
    middles = {1: 3, rods: 2 * rods + 1}
    places = [(rod, tops[row] - counts[row] // 2) for rod, row in middles.items()]
    felt = []
    for rod, node in [*places, (0, total)]:
        last = min(first + node - contact, steps)
        of = slice(1 + (node - contact) % 2, last, 2)
        force = -found.Force[of, node]
        arrived = int(np.argmax(np.abs(force) > 0))
        if rod == 0 and (force < 0).any():
            # The tip would leave the rock.
            force = force[: int(np.argmax(force < 0))]
        for spell in spells(force[arrived - 1 :], found.time[of][arrived - 1 :], bars.dt):
            felt.append({"rod": rod, **spell})
    metres = {name: [round(CELL * cells, 9), area] for name, (cells, area) in string.items()}
    return {"rods": rods, **metres, "felt": felt}


def main() -> None:
    noise = np.random.default_rng(30)
    print(json.dumps([solve(rods, noise) for rods in RODS], indent=1))


main()
