"""Draws what `cargo bench-report speed` or `mesh` hands over on standard input, as JSON.

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


def mesh(quantities, rows):
    """Error against cost, a panel a quantity, a line a degree; the peers as points."""
    _, grid = plt.subplots(2, 3, figsize=(9.5, 5.6), layout="constrained")
    axes = grid.flatten()
    ours = "this engine"
    groups = by(rows, lambda r: f"degree {r['degree']}" if r["solver"] == ours else r["solver"])
    for k, (panel, quantity) in enumerate(zip(axes, quantities, strict=False)):
        for i, (label, group) in enumerate(groups.items()):
            line = "-" if group[0]["solver"] == ours else ""
            having = [row for row in group if k < len(row["errors"])]
            cost = [row["cost"] for row in having]
            error = [max(abs(row["errors"][k]), 1e-9) for row in having]
            panel.loglog(cost, error, MARKS[i + 1] + line, ms=3.5, color=COLOURS[i], label=label)
        panel.set(title=quantity, xlabel="cost over 20 linear elements", ylabel="relative error")
        panel.grid(alpha=0.25)
    axes[-1].axis("off")
    axes[-1].legend(*axes[0].get_legend_handles_labels(), loc="center")


def main(picture):
    data = json.load(sys.stdin)
    if "rows" in data:
        mesh(data["quantities"], data["rows"])
    else:
        speed(data["points"])
    plt.savefig(picture, dpi=110, metadata={"Software": None})


main(*sys.argv[1:])
