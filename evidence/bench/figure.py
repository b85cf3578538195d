"""Draws error against CPU time from the data of `cargo bench-report`.

python figure.py data.json figure.svg
"""

import json
import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt

# The same data give the same file.
mpl.rcParams["svg.hashsalt"] = "speed-against-error"
mpl.rcParams["svg.fonttype"] = "none"


def lines(points: list[dict]) -> dict[str, list[tuple[float, float]]]:
    """Pairs of CPU time and error of each solver, cheapest first."""
    found: dict[str, list[tuple[float, float]]] = {}
    for point in points:
        if point["verdict"] and point["verdict"]["error"] is not None:
            pairs = found.setdefault(point["solver"], [])
            pairs.append((point["cpu"], point["verdict"]["error"]))
    return {solver: sorted(pairs) for solver, pairs in found.items()}


def main(source: str, figure: str) -> None:
    """Draws the figure."""
    data = json.loads(Path(source).read_text(encoding="utf-8"))
    _, axes = plt.subplots(figsize=(8.5, 6), layout="constrained")
    colours = plt.get_cmap("tab20").colors
    for i, (solver, pairs) in enumerate(lines(data["points"]).items()):
        ours = solver.startswith("this engine")
        axes.loglog(
            *zip(*pairs, strict=True),
            marker="*" if ours else "osD^v"[i % 5],
            markersize=14 if ours else 5,
            linestyle="--" if solver.startswith("SciPy") else "-",
            color="crimson" if ours else colours[i % 20],
            fillstyle="none" if solver == "this engine" else "full",
            label=solver,
        )
    axes.set_xlabel("CPU time per pressure cycle (s)")
    axes.set_ylabel("worst state error (1 mm, 1 m/s)")
    axes.set_ylim(top=2.0)
    axes.grid(which="both", alpha=0.25)
    axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    plt.savefig(figure, metadata={"Date": None})


main(*sys.argv[1:])
