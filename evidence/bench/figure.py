"""Draws what `cargo bench-report speed` hands over on standard input, as JSON.

python figure.py picture.png
"""

import json
import sys

import matplotlib as mpl

mpl.use("agg")
import matplotlib.pyplot as plt

MARKS, COLOURS = "*osD^vPX<", plt.get_cmap("tab10").colors


def by(rows, key):
    """Rows in groups, in order of appearance."""
    groups = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups


def speed(points):
    """Error against CPU time, a line a solver."""
    _, axes = plt.subplots(figsize=(8.5, 5), layout="constrained")
    solved = [point for point in points if point["verdict"]]
    for i, (solver, rows) in enumerate(by(solved, lambda row: row["solver"]).items()):
        pairs = sorted((row["cpu"], row["verdict"]["error"]) for row in rows)
        axes.loglog(*zip(*pairs, strict=True), marker=MARKS[i], color=COLOURS[i], label=solver)
    axes.set(xlabel="CPU time per pressure cycle (s)", ylabel="worst error (1 mm, 1 m/s)")
    axes.set_ylim(top=2.0)
    axes.grid(which="both", alpha=0.25)
    axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))


speed(json.load(sys.stdin)["points"])
plt.savefig(sys.argv[1], dpi=110, metadata={"Software": None})
