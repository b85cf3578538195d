"""Scores what a host logs of the unit of events: Python's standard library alone.

    python score.py ROWS.csv    # columns time and relative_position, a row a point of the host's
    python score.py             # the exact instants, as in instants.csv

The unit's piston is thrown up against a constant force: in a parabola, until it strikes the
resting bit. So every event has a closed form. With x0 = -gap, the acceleration a and the velocity
v < 0 at the start, it passes a level x at

    t = (-v -+ sqrt(v^2 - 2 a (x0 - x))) / a

twice, and is back on the bit at the later instant of x = 0. Two passages, of a level 1 nm below the
highest point, are 3.2 us apart: who looks at communication points alone does not see them.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterable

GAP, VELOCITY, ACCELERATION = 1e-3, -8.3, 800.0
HIGHEST = -GAP - VELOCITY**2 / (2.0 * ACCELERATION)
LEVELS = (-0.01, -0.02, -0.03, -0.04, HIGHEST + 1e-9)
END, STEP = 0.021, 1e-3
#: What is read.
READ = "relative_position"
#: An instant is kept if the host is there to this, s; rounding near the highest point is 1e-14 s.
KEPT = 1e-12


def instants() -> list[tuple[float, float]]:
    """Instants and levels of all events, in order."""

    def passages(level: float) -> list[float]:
        root = math.sqrt(VELOCITY**2 + 2.0 * ACCELERATION * (GAP + level))
        return [(-VELOCITY + sign * root) / ACCELERATION for sign in (-1.0, 1.0)]

    found = [(instant, level) for level in LEVELS for instant in passages(level)]
    return sorted([*found, (passages(0.0)[1], 0.0)])


def score(rows: list[tuple[float, float]]) -> tuple[int, int, float]:
    """How many events are kept, how many can be seen at all, and the largest error, s."""
    met = visible = 0
    largest = 0.0
    for instant, level in instants():
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


def cells(rows: list[tuple[float, float]]) -> str:
    met, visible, error = score(rows)
    count = len(instants())
    return f"{met} of {count} | {visible} of {count} | {error:.0e} | {len({t for t, _ in rows})}"


def main() -> None:
    if len(sys.argv) > 1:
        with open(sys.argv[1], encoding="utf-8") as file:
            print("| instants kept | events seen | largest error (s) | points |")
            print("|---|---|---|---|")
            print(f"| {cells(read_rows(file))} |")
        return
    print("instant,relative_position")
    print("\n".join(f"{instant!r},{level!r}" for instant, level in instants()))


if __name__ == "__main__":
    main()
