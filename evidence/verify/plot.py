"""Figures of the reports of `cargo verify`, from their numbers: `plot.py numbers.json folder`."""

import json
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes


def slope(axis: Axes, n: np.ndarray, start: float, order: float) -> None:
    """A line of an order, from a value at the coarsest mesh, with its order at its end."""
    line = start * (n / n[0]) ** -order
    name = f"{order:g}" if order == int(order) else f"{3 * order:.0f}/3"
    axis.loglog(n, line, "k:", lw=1)
    axis.annotate(name, (n[-1], line[-1]), (4, 0), textcoords="offset points", va="center")


def panel(axis: Axes, study: dict[str, Any], letter: str) -> None:
    """Errors of one study over the number of elements."""
    levels = study["levels"]
    n = np.array([level["elements"] for level in levels], float)
    errors = np.abs([level["errors"] for level in levels])
    for column, (quantity, marker) in enumerate(zip(study["quantities"], "osD^vP", strict=False)):
        axis.loglog(n, errors[:, column], marker + "-", ms=4, lw=1.2, label=quantity["name"])
    orders = sorted({q["order"] for q in study["quantities"] if q["order"] > 0})
    low = 0.45 * errors[0].min()
    for i, order in enumerate(orders):
        slope(axis, n, low * 0.2**i, order)
    bottom = low * 0.2 ** (len(orders) - 1) * 32.0 ** -orders[-1]
    # Room above the curves for the legend.
    decades = np.log10(errors.max() / bottom)
    axis.set_ylim(0.5 * bottom, errors.max() * 10 ** (0.09 * len(study["quantities"]) * decades))
    axis.set_xlim(4.2, 230)
    axis.set_xticks(n, [f"{x:g}" for x in n])
    axis.minorticks_off()
    axis.set_title(f"{letter} {study['title']}", fontsize=9, loc="left")
    axis.set(xlabel="elements per bar", ylabel="error, units of the legend")
    axis.legend(fontsize=7, loc="upper right", framealpha=1)
    axis.grid(alpha=0.3)


def cost(axis: Axes, studies: list[dict[str, Any]]) -> None:
    """What a mesh costs."""
    for study, marker in zip(studies, "osD^v", strict=True):
        n = np.array([level["elements"] for level in study["levels"]], float)
        seconds = [level["seconds"] for level in study["levels"]]
        axis.loglog(n, seconds, marker + "-", ms=4, lw=1.2, label=study["title"])
    axis.loglog(n, 1e-4 * (n / n[0]) ** 2, "k:", lw=1)
    axis.annotate("$n^2$", (n[-1], 1e-4 * 1024), (4, 0), textcoords="offset points", va="center")
    axis.set_xticks(n, [f"{x:g}" for x in n])
    axis.minorticks_off()
    axis.set_xlim(4.2, 230)
    axis.set_ylim(1e-4, 3e1)
    axis.set_title("f  Time taken", fontsize=9, loc="left")
    axis.set(xlabel="elements per bar", ylabel="s, decompositions included")
    axis.legend(fontsize=7, loc="upper left", framealpha=1)
    axis.grid(alpha=0.3)


def convergence(data: dict[str, Any], folder: Path) -> None:
    """Errors against exact waves over the number of elements, and their cost."""
    fig, axes = plt.subplots(2, 3, figsize=(14, 9), layout="constrained")
    studies = data["studies"][:5]  # splines are in the tables
    for axis, study, letter in zip(axes.flat, studies, "abcde", strict=False):
        panel(axis, study, letter + " ")
    cost(axes[1, 2], studies)
    fig.savefig(folder / "convergence.png", dpi=120)


def rigid(data: dict[str, Any], folder: Path) -> None:
    """Error of rigid bodies over length ratio and rock stiffness."""
    ratios, kappas = data["ratios"], data["kappas"]
    fig, axes = plt.subplots(
        2, 2, figsize=(10.5, 8.4), layout="constrained", sharex=True, sharey=True
    )
    titles = {
        "tip_rate": "a  Whole hammer: rate of the tip",
        "period": "b  Whole hammer: period",
        "energy": "c  One bare blow: energy kept by the rock",
        "force": "d  One bare blow: largest rock force",
    }
    for axis, (key, title) in zip(axes.flat, titles.items(), strict=True):
        table = np.array([p[key] for p in data["map"]]).reshape(len(ratios), len(kappas)).T
        look = {"origin": "lower", "aspect": "auto", "cmap": "RdBu_r", "vmin": -60, "vmax": 60}
        image = axis.imshow(100 * table, **look)
        for (i, j), value in np.ndenumerate(table):
            axis.text(
                j,
                i,
                f"{100 * value:+.0f}",
                ha="center",
                va="center",
                color="white" if abs(value) > 0.35 else "black",
                weight="bold" if abs(value) < 0.1 else "normal",
            )
        axis.set_xticks(range(len(ratios)), [f"{r:g}" for r in ratios])
        axis.set_yticks(range(len(kappas)), [f"{k:g}" for k in kappas])
        axis.set_title(title, loc="left", fontsize=10)
    for axis in axes[1]:
        axis.set_xlabel("Lp / Lb")
    for axis in axes[:, 0]:
        axis.set_ylabel("kappa = KR Lp / (E A)")
    fig.colorbar(image, ax=axes, extend="both", label="rigid less elastic, % (bold: within 10 %)")
    fig.savefig(folder / "rigid.png", dpi=120)


def feed(data: dict[str, Any], folder: Path) -> None:
    """Rate over feed: the means, their standard errors, and the range of single blows."""
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    titles = {
        "reference": "a  Reference hammer",
        "rigid": "b  Rigid, barrier 40 J, viscosity 1e6 N s/m",
    }
    for axis, (key, title) in zip(axes, titles.items(), strict=True):
        points = data[key]
        force = [1e-3 * point["feed"] for point in points]
        rate = [3600 * point["rate"] for point in points]
        low, high = ([3600 * point["range"][k] for point in points] for k in (0, 1))
        axis.fill_between(force, low, high, alpha=0.15, label="single blows")
        error = [3600 * point["error"] for point in points]
        axis.errorbar(force, rate, error, fmt="o-", ms=4, capsize=3, label="mean, standard error")
        axis.set_title(title, loc="left", fontsize=10)
        axis.set(xlabel="feed force, kN", ylabel="rate of penetration, m/h")
        axis.set_ylim(bottom=min(0, *low))
        axis.legend(fontsize=8)
        axis.grid(alpha=0.3)
    fig.savefig(folder / "feed.png", dpi=120)


if __name__ == "__main__":
    source, figures = map(Path, sys.argv[1:])
    numbers = json.loads(source.read_text(encoding="utf-8"))
    if "reference" in numbers:
        feed(numbers, figures)
    else:
        convergence(numbers, figures)
        rigid(numbers, figures)
