"""Figures of the verification report, from the studies' numbers."""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def convergence(data: dict, folder: Path) -> None:
    """Errors against exact waves over the number of elements."""
    meshes = data["meshes"]
    n = np.array([m["elements"] for m in meshes], float)
    fig, axis = plt.subplots(figsize=(6.4, 4.6), layout="constrained")
    for i, name in enumerate(data["quantities"]):
        axis.loglog(n, [m["errors"][i] for m in meshes], "o-", label=name)
    top = max(meshes[0]["errors"])
    axis.loglog(n, top * n[0] / n, "k:", lw=1, label="order 1")
    axis.loglog(n, 0.1 * top * (n[0] / n) ** 2, "k--", lw=1, label="order 2")
    axis.set_xticks(n, [f"{x:g}" for x in n])
    axis.minorticks_off()
    axis.set(xlabel="elements a bar", ylabel="error against exact waves")
    axis.legend(fontsize=8)
    axis.grid(alpha=0.3)
    fig.savefig(folder / "convergence.png", dpi=140)


def rigid(data: dict, folder: Path) -> None:
    """Error of rigid bodies over length ratio and rock stiffness."""
    ratios, kappas = data["ratios"], data["kappas"]
    fig, axes = plt.subplots(1, 2, figsize=(10.5, 4.6), layout="constrained", sharey=True)
    for axis, key, title in zip(
        axes, ("energy", "force"), ("energy kept by the rock", "largest rock force"), strict=True
    ):
        table = np.array([p[key] for p in data["map"]]).reshape(len(ratios), len(kappas)).T
        look = {"origin": "lower", "aspect": "auto", "cmap": "RdBu_r", "vmin": -60, "vmax": 60}
        image = axis.imshow(100 * table, **look)
        for i in range(len(kappas)):
            for j in range(len(ratios)):
                dark = abs(table[i, j]) > 0.35
                axis.text(
                    j,
                    i,
                    f"{100 * table[i, j]:+.1f}",
                    ha="center",
                    va="center",
                    fontsize=8,
                    color="white" if dark else "black",
                )
        axis.set_xticks(range(len(ratios)), [f"{r:g}" for r in ratios])
        axis.set_yticks(range(len(kappas)), [f"{k:g}" for k in kappas])
        axis.set(xlabel="Lp / Lb", title=f"rigid against elastic: {title}, %")
    axes[0].set_ylabel("kappa = KR Lp / (E A)")
    fig.colorbar(image, ax=axes, extend="both")
    fig.savefig(folder / "rigid.png", dpi=140)


if __name__ == "__main__":
    figures = Path(sys.argv[1])
    numbers = json.loads((figures / "studies.json").read_text(encoding="utf-8"))
    convergence(numbers, figures)
    rigid(numbers, figures)
