"""An orbit followed along a parameter, with what simulations settle to beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from tqdm import tqdm

from .cycle import Cycle, Cycles, found
from .hammer import Hammer
from .package import Package, load
from .variables import Array, Value

#: Blows that are simulated before one looks, and that are looked at.
FORGOTTEN, SEEN = 40, 8
#: Blow periods that differ by less, relative, are one.
SAME = 1e-6
#: A multiplier that leaves the unit circle here flips: the period doubles.
FLIP = -1.0


def atlas(
    name: str,
    values: Sequence[float] | Array,
    parameters: Mapping[str, Value] | None = None,
    *,
    laps: int = 1,
    preset: str | None = None,
    simulated: bool = True,
    progress: bool = False,
    fmu: str | Path | Package | None = None,
) -> pd.DataFrame:
    """Cycles along a parameter: stable and unstable ones, and what simulations settle to.

    Each cycle is sought from the last one found, so that a branch is followed where it no
    longer attracts; where it is lost, from a simulation. The order of events is compared from
    point to point: where it changes, the return map has an edge there.

    Args:
        name: the parameter or input.
        values: where, in SI units, in order.
        parameters: the others.
        laps: turns of the relay that the followed cycle closes after.
        preset: parameter set to start from.
        simulated: settles a simulation at each value too.
        progress: shows a progress bar.
        fmu: file to use instead of the one found.

    Returns:
        One row per cycle (``kind`` is ``cycle``: its period, ROP, leading multiplier, whether it is
        stable, whether events changed their order since the last value) or a blow of a settled
        simulation (``simulated``: period and ROP over that blow, and how many blows repeat).
    """
    package = load(fmu)
    axis = package.variables.settable(name)
    numbers = [axis.number(float(v)) for v in values]
    rows: list[dict[str, Any]] = []
    fingerprint = 0
    with Cycles(parameters, preset=preset, laps=laps, fmu=package) as cycles:
        begun = False
        for value in tqdm(numbers, disable=not progress, leave=False, unit="value"):
            cycle = found(cycles, {name: value}, near=True) if begun else None
            followed = cycle is not None
            cycle = cycle or found(cycles, {name: value})
            if cycle is not None:
                other = begun and cycle.fingerprint != fingerprint
                rows.append(_row(value, cycle, laps, followed=followed, other_order=other))
                fingerprint, begun = cycle.fingerprint, True
            if simulated:
                rows.extend(_settled(package, preset, {**(parameters or {}), name: value}, value))
    table = pd.DataFrame(rows)
    table.attrs = {"parameter": name, "unit": axis.unit, "laps": laps, "fmu": package.version}
    return table


def _row(
    value: float, cycle: Cycle, laps: int, *, followed: bool, other_order: bool
) -> dict[str, Any]:
    first = cycle.multipliers[0] if len(cycle.multipliers) else 0.0
    return {
        "value": value,
        "kind": "cycle",
        "period": cycle.period / laps,
        "rop": cycle.rop,
        "multiplier": abs(first),
        "real": float(np.real(first)),
        "imaginary": float(np.imag(first)),
        "stable": cycle.stable,
        "followed": followed,
        "other_order": other_order,
        "events": cycle.events,
        "repeats": laps,
    }


def _settled(
    package: Package, preset: str | None, parameters: Mapping[str, Value], value: float
) -> list[dict[str, Any]]:
    periods: list[float] = []
    rates: list[float] = []
    with Hammer(parameters, preset=preset, fmu=package, quiet=True) as hammer:
        read = hammer.reader(["blow_count", "blow_period", "rop"])
        seen, step = 0.0, 0.005
        while len(periods) < FORGOTTEN + SEEN and hammer.time < 20.0:
            hammer.step(step)
            count, period, rop = read()
            if count > seen:
                seen = count
                periods.append(period)
                rates.append(rop)
    last, rates = np.array(periods[-SEEN:]), rates[-SEEN:]
    if len(periods) < FORGOTTEN + SEEN:
        return []
    ways = [k for k in range(1, SEEN // 2 + 1) if np.allclose(last[k:], last[:-k], rtol=SAME)]
    repeats = ways[0] if ways else 0
    return [
        {"value": value, "kind": "simulated", "period": t, "rop": r, "repeats": repeats}
        for t, r in zip(last[: repeats or SEEN], rates, strict=False)
    ]


def figure(table: pd.DataFrame) -> Figure:
    """ROP, blow period and leading multiplier over the parameter."""
    name, unit = table.attrs["parameter"], table.attrs["unit"]
    chart = Figure(figsize=(7.2, 7.6), layout="constrained")
    axes = chart.subplots(3, 1, sharex=True)
    cycles = table[table["kind"] == "cycle"]
    seen = table[table["kind"] == "simulated"]
    stable = cycles["stable"].astype(bool) if len(cycles) else pd.Series(dtype=bool)
    for axis, column, scale, label in (
        (axes[0], "rop", 1e3, "ROP [mm/s]"),
        (axes[1], "period", 1e3, "time per blow [ms]"),
    ):
        axis.plot(seen["value"], scale * seen[column], ".", ms=3, color="#999999",
                  label="simulated, settled")  # fmt: skip
        axis.plot(cycles["value"][stable], scale * cycles[column][stable], ".", ms=4,
                  color="#0072b2", label="cycle, stable")  # fmt: skip
        axis.plot(cycles["value"][~stable], scale * cycles[column][~stable], "x", ms=4,
                  color="#d55e00", label="cycle, unstable")  # fmt: skip
        axis.set_ylabel(label)
    axes[2].plot(cycles["value"], cycles["real"], ".", ms=4, color="#0072b2", label="real part")
    size = cycles["multiplier"]
    axes[2].plot(cycles["value"], size, ".", ms=2, color="#999999", label="magnitude")
    for level in (1.0, FLIP):
        axes[2].axhline(level, lw=0.8, ls="--", color="#444444")
    axes[2].set_ylabel("leading multiplier [1]")
    axes[2].set_xlabel(f"{name} [{unit}]")
    axes[2].set_yscale("symlog", linthresh=1.0)
    for axis in axes:
        axis.grid(alpha=0.3)
    chart.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    axes[2].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return chart
