"""Draws what `cargo bench-report speed` hands over on standard input, as JSON.

python figure.py picture.png
"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "guide"))

import pictures
from dth_hammer.figures.style import styled

MARKS = "*osD^vPX<"
COLOURS = [
    "#d55e00",
    "#0072b2",
    "#009e73",
    "#8c6d31",
    "#cc79a7",
    "#56b4e9",
    "#e69f00",
    "#555555",
    "#222222",
]


def by(rows, key):
    """Rows in groups, in order of appearance."""
    groups = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups


def speed(points):
    """Error against CPU time, a line a solver."""
    with styled(6.5, 4.0) as figure:
        axes = figure.subplots()
        solved = [point for point in points if point["verdict"]]
        for i, (solver, rows) in enumerate(by(solved, lambda row: row["solver"]).items()):
            pairs = sorted((row["cpu"], row["verdict"]["error"]) for row in rows)
            axes.loglog(*zip(*pairs, strict=True), marker=MARKS[i], color=COLOURS[i], label=solver)
        axes.set(xlabel="processor time per pressure cycle (s)")
        axes.set(ylabel="worst error (of 1 mm, 1 m/s)", ylim=(None, 2.0))
        axes.grid(color="0.9", linewidth=0.6)
        figure.legend(loc="outside right center")
    return figure


if __name__ == "__main__":
    speed(json.load(sys.stdin)["points"]).savefig(sys.argv[1])
    pictures.stamp(sys.argv[1], "reports/speed-against-error.png")
