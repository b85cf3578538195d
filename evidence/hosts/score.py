"""Scores what a host logs of the unit of events: Python's standard library alone.

    python score.py ROWS.csv    # columns time and relative_position, a row a point of the host's
    python score.py             # the exact instants, as in instants.csv

`--scene` names another than `thrown`: `changed`, in which the acceleration doubles, by the host's
input, at the instant at which the piston passes -0.02 m upward; or `coupled`, in which the second
unit, a valve, doubles it below that level, so that energy is kept and the piston passes it back as
fast as before.

The unit's piston is thrown up against a constant force: in a parabola, until it strikes the
resting bit. So every event has a closed form. With x0 = -gap, the acceleration a and the velocity
v < 0 at the start, it passes a level x at

    t = (-v -+ sqrt(v^2 - 2 a (x0 - x))) / a

twice, and is back on the bit at the later instant of x = 0. Two passages, of a level 1 nm below the
highest point, are 3.2 us apart: who looks at communication points alone does not see them.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Iterable

GAP, VELOCITY, ACCELERATION = 1e-3, -8.3, 800.0
HIGHEST = -GAP - VELOCITY**2 / (2.0 * ACCELERATION)
LEVELS = (-0.01, -0.02, -0.03, -0.04, HIGHEST + 1e-9)
END, STEP = 0.021, 1e-3
#: What is read.
READ = "relative_position"
#: An instant is kept if the host is there to this, s; rounding near the highest point is 1e-14 s.
KEPT = 1e-12


#: Scenes, and until when a host runs each, s.
SCENES = {"thrown": END, "changed": 0.014, "coupled": 0.014}
#: Where the acceleration changes, m, and to what, m/s2.
EDGE, STRONGER = -0.02, 1600.0


def passages(level: float, x: float, v: float, a: float) -> list[float]:
    """When the parabola from x with velocity v is at a level, first and again."""
    root = math.sqrt(v**2 + 2.0 * a * (level - x))
    return [(-v + sign * root) / a for sign in (-1.0, 1.0)]


def instants(scene: str = "thrown") -> list[tuple[float, float]]:
    """Instants and levels of all events, in order."""
    thrown = (-GAP, VELOCITY, ACCELERATION)
    if scene == "thrown":
        found = [(instant, level) for level in LEVELS for instant in passages(level, *thrown)]
        return sorted([*found, (passages(0.0, *thrown)[1], 0.0)])
    up = [(passages(level, *thrown)[0], level) for level in (-0.01, EDGE)]
    edge = up[-1][0]
    speed = math.sqrt(VELOCITY**2 + 2.0 * ACCELERATION * (EDGE + GAP))
    above = (EDGE, -speed, STRONGER)
    found = [(edge + instant, -0.03) for instant in passages(-0.03, *above)]
    back = edge + passages(EDGE, *above)[1]
    found.append((back, EDGE))
    below = (EDGE, speed, STRONGER if scene == "changed" else ACCELERATION)
    found += [(back + passages(level, *below)[1], level) for level in (-0.01, 0.0)]
    return [*up, *found]


def instant_rows(scene: str) -> str:
    rows = [f"{instant!r},{level!r}\n" for instant, level in instants(scene)]
    return "".join(["instant,relative_position\n", *rows])


def input_rows() -> str:
    """The input of the scene `changed`: two rows of one time are a step."""
    edge = instants("changed")[1][0]
    rows = [(0.0, ACCELERATION), (edge, ACCELERATION), (edge, STRONGER), (END, STRONGER)]
    return "".join(["time,acceleration\n", *(f"{time!r},{value!r}\n" for time, value in rows)])


def score(rows: list[tuple[float, float]], scene: str = "thrown") -> tuple[int, int, float]:
    """How many events are kept, how many can be seen at all, and the largest error, s."""
    met = visible = 0
    largest = 0.0
    for instant, level in instants(scene):
        error = min(abs(time - instant) for time, _ in rows)
        before = [x >= level for time, x in rows if time < instant]
        after = [x >= level for time, x in rows if time >= instant]
        # The blow throws the piston back: whoever goes on after it can see that.
        changed = bool(after) and (level == 0.0 or before[-1] != after[0])
        met += error <= KEPT
        visible += error <= KEPT or changed
        largest = max(largest, error)
    return met, visible, largest


def read_rows(lines: Iterable[str]) -> list[tuple[float, float]]:
    return [(float(row["time"]), float(row[READ])) for row in csv.DictReader(lines)]


def cells(rows: list[tuple[float, float]], scene: str = "thrown") -> str:
    met, visible, error = score(rows, scene)
    count = len(instants(scene))
    return f"{met} of {count} | {visible} of {count} | {error:.0e} | {len({t for t, _ in rows})}"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("rows", nargs="?")
    parser.add_argument("--scene", choices=SCENES, default="thrown")
    options = parser.parse_args()
    if options.rows is None:
        print(instant_rows(options.scene), end="")
        return
    with open(options.rows, encoding="utf-8") as file:
        print("| instants kept | events seen | largest error (s) | points |")
        print("|---|---|---|---|")
        print(f"| {cells(read_rows(file), options.scene)} |")


if __name__ == "__main__":
    main()
