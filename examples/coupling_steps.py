"""Which communication step a coupled hammer needs: measured, as a table and a figure.

    python examples/coupling_steps.py --out steps

Errors of blow period, impact speed and rate of penetration of the settled response, for
Jacobi and Gauss-Seidel coupling, pressures held at a step's start or at their mean or as straight
lines, and with rejected steps, against the same coupling at a very small step; and what a second
costs the hammer, without what its partner in Python does. Writes steps.md and steps.png.
"""

from __future__ import annotations

import argparse
import itertools
import math
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd
from dth_hammer import Coupling, Hammer, RefusedError
from dth_hammer.models.hydraulic import Water, WaterDrive
from dth_hammer.style import styled
from matplotlib.figure import Figure
from tqdm import tqdm

STEPS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6)  # s
REFERENCE = 1e-6  # s: also the smallest step looked at
SAMPLING = 1e-3  # s: how often the blow count is read; finer than a blow period
AVERAGED = 5  # blows at the end of a run
QUANTITIES = {"period": "blow period", "speed": "impact speed", "tip_rate": "tip rate"}
VARIANTS: dict[str, dict[str, Any]] = {
    "Jacobi": {"scheme": "jacobi", "slopes": False},
    "Jacobi, derivatives": {"scheme": "jacobi", "slopes": True},
    "Gauss-Seidel": {"scheme": "gauss-seidel", "slopes": False},
    "Gauss-Seidel, mean of a step": {"scheme": "gauss-seidel", "slopes": "midpoint"},
    "Gauss-Seidel, derivatives": {"scheme": "gauss-seidel", "slopes": True},
}
CONTROLLED = "Gauss-Seidel, derivatives, rejection"


TOLERANCES = (1e6, 1e5, 1e4)  # Pa, for rejected steps
UNTIL = 0.45  # s: long enough to settle


class Timed(Hammer):
    """Counts the processor's time that the hammer itself takes."""

    spent = 0.0

    def advance(self, to: float | str) -> float:
        """One step, timed."""
        began = time.thread_time()
        try:
            return super().advance(to)
        finally:
            self.spent += time.thread_time() - began


def settled(step: float, until: float, **options: Any) -> dict[str, float]:
    """Means over the last blows, and what they cost."""
    names = ["blow_count", "blow_period", "blow_speed", "blow_penetration"]
    blows: list[dict[str, float]] = []
    with Timed(Water().parameters()) as hammer:
        coupling = Coupling(hammer, WaterDrive(), step, **options)
        count = 0.0
        for k in range(1, round(until / SAMPLING) + 1):
            coupling.advance(k * SAMPLING)
            now = hammer.get(names)
            if now["blow_count"] > count:
                count = now["blow_count"]
                blows.append(now)
    last = blows[-AVERAGED:]
    if len(blows) <= AVERAGED:
        raise ArithmeticError(f"{len(blows)} blows: the hammer does not run")
    period = sum(b["blow_period"] for b in last)
    return {
        "period": period / AVERAGED,
        "speed": sum(b["blow_speed"] for b in last) / AVERAGED,
        "tip_rate": sum(b["blow_penetration"] for b in last) / period,
        "step": until / coupling.accepted,
        "rejected": coupling.rejected,
        "cost": hammer.spent / until,
    }


def measure(
    steps: Iterable[float] = STEPS, reference: float = REFERENCE, until: float = UNTIL
) -> pd.DataFrame:
    """One row a variant and step: relative errors against the reference step."""
    truth = settled(reference, until, slopes=True)
    runs = [(v, s, {**options}) for (v, options), s in itertools.product(VARIANTS.items(), steps)]
    runs += [(CONTROLLED, max(steps), {"tolerance": t, "slopes": True}) for t in TOLERANCES]
    rows = []
    for variant, step, options in tqdm(runs, unit="run", leave=False, disable=None):
        row: dict[str, Any] = {
            "variant": variant,
            "asked": step,
            "tolerance": options.get("tolerance"),
        }
        try:
            found = settled(step, until, **options)
            row |= {q: abs(found[q] / truth[q] - 1.0) for q in QUANTITIES}
            row |= {k: found[k] for k in ("step", "rejected", "cost")}
        except (ArithmeticError, ValueError, RefusedError) as error:
            row["failed"] = str(error)
        rows.append(row)
    table = pd.DataFrame(rows)
    table.attrs = {"truth": truth, "reference": reference, "until": until}
    return table


def advice(table: pd.DataFrame) -> str:
    """The largest step that keeps each error bound, by variant."""
    bounds = (1e-2, 1e-3, 1e-4)
    lines = [
        "| variant | " + " | ".join(f"all errors < {b:g}" for b in bounds) + " |",
        "|---" * (len(bounds) + 1) + "|",
    ]
    for variant, part in table.groupby("variant", sort=False):
        worst = part[[*QUANTITIES]].max(axis=1, skipna=False)
        cells = []
        for bound in bounds:
            # A step counts only if no smaller one is worse.
            good = part[part["step"] <= _limit(part["step"], worst, bound)]
            row = good.loc[good["step"].idxmax()] if len(good) else None
            cells.append("-" if row is None else f"{_micro(row['step'])} ({1e3 * row['cost']:.0f})")
        lines.append(f"| {variant} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _limit(steps: pd.Series, worst: pd.Series, bound: float) -> float:
    limit = 0.0
    for step, error in sorted(zip(steps, worst, strict=True)):
        if not error < bound:
            break
        limit = step
    return limit


def _micro(seconds: float) -> str:
    micro = seconds * 1e6
    return f"{micro:.0f} µs" if micro >= 10 else f"{micro:.2g} µs"


def report(table: pd.DataFrame, picture: str) -> str:
    """The page: what was measured, the advice, the numbers."""
    truth = table.attrs["truth"]
    lines = [
        f"Reference: hydraulic model, Gauss-Seidel with derivatives at "
        f"{_micro(table.attrs['reference'])}: blow period {truth['period'] * 1e3:.4f} ms, "
        f"impact speed {truth['speed']:.4f} m/s, tip rate {truth['tip_rate'] * 1e3:.3f} mm/s "
        f"(means of the last {AVERAGED} blows of {table.attrs['until']:g} s).",
        "",
        "Largest step for a bound on the relative errors of all three, "
        "in brackets the processor's milliseconds in the hammer per simulated second:",
        "",
        advice(table),
        "",
        f"![Relative errors against the communication step]({picture})",
        "",
        '<details markdown="1"><summary>All measurements</summary>',
        "",
        "| variant | step | rejected | " + " | ".join(QUANTITIES.values()) + " | cost ms/s |",
        "|---" * (len(QUANTITIES) + 4) + "|",
    ]
    for row in table.to_dict("records"):
        if isinstance(row.get("failed"), str):
            line = f"| {row['variant']} | {_micro(row['asked'])} | | fails: {row['failed']} | | | |"
        else:
            errors = " | ".join(f"{row[q]:.1e}" for q in QUANTITIES)
            limit = (
                "" if math.isnan(row["tolerance"] or math.nan) else f", {row['tolerance']:.0e} Pa"
            )
            line = (
                f"| {row['variant']}{limit} | {_micro(row['step'])} | {row['rejected']:.0f} "
                f"| {errors} | {1e3 * row['cost']:.0f} |"
            )
        lines.append(line)
    return "\n".join([*lines, "", "</details>"]) + "\n"


def draw(table: pd.DataFrame) -> Figure:
    """Relative errors against the step, one panel a quantity."""
    with styled(8.5, 3.6) as figure:
        panels = figure.subplots(1, len(QUANTITIES), sharey=True)
        colours = ("#d55e00", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "0.2")
        looks = itertools.cycle(zip("os^PDv", colours, strict=True))
        done = table.dropna(subset=["step"]).sort_values("step")
        for (variant, part), (marker, colour) in zip(
            done.groupby(pd.Categorical(done["variant"], [*VARIANTS, CONTROLLED]), observed=True),
            looks,
            strict=False,
        ):
            for axes, quantity in zip(panels, QUANTITIES, strict=True):
                axes.loglog(
                    part["step"] * 1e6,
                    part[quantity],
                    marker=marker,
                    color=colour,
                    ms=4,
                    label=variant if quantity == "period" else None,
                )
        for axes, label in zip(panels, QUANTITIES.values(), strict=True):
            axes.set_title(label)
            axes.set_xlabel("communication step (µs)")
            axes.grid(color="0.9", linewidth=0.6)
        panels[0].set_ylabel("relative error")
        figure.legend(loc="outside upper center", ncols=3)
    return figure


def main() -> None:
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("steps"))
    options = parser.parse_args()
    table = measure()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    picture = options.out.with_suffix(".png")
    draw(table).savefig(picture, dpi=160)
    options.out.with_suffix(".md").write_text(report(table, picture.name), encoding="utf-8")
    print(advice(table))


if __name__ == "__main__":
    main()
