"""Branches of cycles along a parameter, and the motions that simulations settle to.

Simulations over the parameter come first: from rest and, if the parameter is tunable, up and down
from one value to the next without a restart. From each simulated cycle that is on no branch yet, a
branch is followed in both directions, through folds and where the cycle is unstable. A branch ends
where the return map jumps; the next simulation begins another.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from .cycle import BranchPoint, Cycle, Cycles, found
from .errors import DomainError
from .extras import need
from .hammer import Hammer
from .stepped import repeats
from .variables import VARIABLES, Array, Value, model

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Blows of a transient that are dropped, and blows that are examined.
FORGOTTEN, OBSERVED = 40, 12
#: Blows that the band of an irregular motion is of.
BAND = 60
#: Relative difference in period and ROP below which a simulation is on a branch.
NEAR = 5e-4, 5e-3
#: Longest step along a branch, relative to the parameter's value.
STEP = 0.02
#: Most points of a branch per value.
MOST = 8
#: Longest simulation, s.
LONGEST = 20.0
#: Columns of a table without rows.
COLUMNS = ("value", "kind", "way", "branch", "repeats", "period", "rop", "multiplier", "stable")
#: Style of simulations: bands where they do not repeat, and blows where they do.
FILLED: dict[str, Any] = {"color": "#777777", "alpha": 0.35, "lw": 4.0, "zorder": 2}
OPEN: dict[str, Any] = {"mfc": "none", "mec": "#777777", "mew": 0.7}
#: Colours by the number of blows in a cycle.
COLOURS = {1: "#0072b2", 2: "#009e73", 3: "#cc79a7", 4: "#e69f00"}


@dataclass(frozen=True)
class Settled:
    """The last blows of a simulation: periods (s) and ROP (m/s)."""

    way: str
    value: float
    periods: Array
    rates: Array

    @property
    def repeats(self) -> int:
        """The number of blows after which it repeats; 0 if it does not."""
        return repeats(self.periods[-OBSERVED:])


def atlas(
    name: str,
    values: Collection[float],
    parameters: Mapping[str, Value] | None = None,
    *,
    returns: int = 3,
    preset: str | None = None,
    simulated: bool = True,
    progress: bool = False,
) -> pd.DataFrame:
    """Stable and unstable cycles along a parameter, and the motions that simulations settle to.

    Args:
        name: the parameter or input.
        values: values in SI units, in order, none of them 0.
        parameters: all other parameters.
        returns: longest cycle to follow, in returns of the drive (usually blows).
        preset: parameter set to start from.
        simulated: simulates at each value; otherwise one branch is followed from each value
            that no other has reached.
        progress: shows a progress bar.

    Returns:
        A row for each point of a branch (``kind`` is ``cycle``, ``branch`` its number: mean
        period and ROP of its ``repeats`` blows, leading Floquet multiplier, whether it is stable,
        whether the branch folds here, whether the branch was not resolved up to here, whether
        the order of events differs from the last point) and for each blow of a settled simulation
        (``kind`` is ``simulated``; ``repeats`` is 0 if it does not repeat).
    """
    axis = VARIABLES.settable(name)
    numbers = [axis.number(float(v)) for v in values]
    if len(numbers) < 2 or min(numbers) * max(numbers) <= 0.0 or sorted(set(numbers)) != numbers:
        raise DomainError(f"{name}: give two or more values, ascending, all above or all below 0")
    if not 1 <= returns <= OBSERVED // 2:
        raise DomainError(f"returns = {returns} must be 1 to {OBSERVED // 2}")
    scene = dict(parameters or {})
    runs: list[Settled] = []
    if simulated:
        ways = _ways(preset, scene, name, numbers)
        total = len(numbers) * (3 if axis.tunable else 1)
        runs = [*_bar(ways, progress, unit="run", total=total)]
    chart = _Chart(Cycles(scene, preset=preset), name, numbers)
    for value in _bar(numbers, progress, unit="value"):
        here = [run for run in runs if run.value == value]
        orders = {run.repeats for run in here if 1 <= run.repeats <= returns}
        for order in sorted(orders) if simulated else [1]:
            chart.begin(value, order, [run for run in here if run.repeats == order])
    rows = chart.rows
    for run in runs:
        count = run.repeats or len(run.periods)
        rows += [
            {"value": run.value, "kind": "simulated", "way": run.way, "repeats": run.repeats}
            | {"period": t, "rop": r}
            for t, r in zip(run.periods[-count:], run.rates[-count:], strict=True)
        ]
    table = pd.DataFrame(rows, columns=None if rows else [*COLUMNS])
    table.attrs = {"parameter": name, "unit": axis.unit, "returns": returns, "model": model()}
    return table


def _bar(items: Iterable[Any], progress: bool, **named: Any) -> Iterable[Any]:
    return need("tqdm", "sweep").tqdm(items, leave=False, **named) if progress else items


class _Chart:
    """The branches that have been followed so far."""

    def __init__(self, cycles: Cycles, name: str, values: list[float]) -> None:
        self._cycles, self._name, self._values = cycles, name, values
        self._gap = (values[-1] - values[0]) / (len(values) - 1)
        self._branches: list[tuple[int, list[tuple[float, Cycle]]]] = []
        self.rows: list[dict[str, Any]] = []

    def begin(self, value: float, order: int, runs: Sequence[Settled]) -> None:
        """Follows the cycle at a value unless it is on a branch already."""
        self._cycles.settings(returns=order, settle=FORGOTTEN)
        cycles: list[Cycle] = []
        if not runs or any(not self._passes(value, order, _mean(run)) for run in runs):
            # From rest, and from the end of the last branch, which may be near another cycle.
            for near in (False, True):
                cycle = found(self._cycles, {self._name: value}, near=near)
                if cycle and not self._passes(value, order, (cycle.period / order, cycle.rop)):
                    cycles.append(cycle)
                    self._follow(value, order, cycle)

    def _passes(self, value: float, order: int, mean: tuple[float, float]) -> bool:
        """Whether a branch passes here with this period (s) and ROP."""
        for returns, points in self._branches:
            if returns != order:
                continue
            for (a, first), (b, second) in pairwise(points):
                if not min(a, b) <= value <= max(a, b):
                    continue
                part = (value - a) / (b - a) if b != a else 0.0
                period = first.period + part * (second.period - first.period)
                rop = first.rop + part * (second.rop - first.rop)
                off = abs(period / returns / mean[0] - 1.0), abs(rop / mean[1] - 1.0)
                if off[0] <= NEAR[0] and off[1] <= NEAR[1]:
                    return True
        return False

    def _follow(self, value: float, order: int, start: Cycle) -> None:
        sides = [self._side(value, sign) for sign in (-1.0, 1.0)]
        first = BranchPoint(value, start, rises=True, unresolved=False, other_order=False)
        way = [*_backward([first, *sides[0]]), *sides[1]]
        number = len(self._branches)
        self._branches.append((order, [(w.value, w.cycle) for w in way]))
        headings = np.sign(np.diff([w.value for w in way]))
        for k, point in enumerate(way):
            folds = 0 < k < len(headings) and headings[k] != headings[k - 1]
            self.rows.append(_row(number, point, order, folds=bool(folds)))

    def _side(self, value: float, sign: float) -> list[BranchPoint]:
        low, high = self._values[0], self._values[-1]
        followed: list[BranchPoint] = []
        step = sign * min(self._gap / abs(value), STEP)
        for point in self._cycles.branch(self._name, step):
            if not low <= point.value <= high or len(followed) >= MOST * len(self._values):
                break
            followed.append(point)
        return followed


def _backward(way: list[BranchPoint]) -> list[BranchPoint]:
    """The same points in reverse; flags of an interval belong to its later point."""
    turned = way[::-1]
    flags = [(False, False), *((p.unresolved, p.other_order) for p in turned[:-1])]
    return [
        replace(p, unresolved=o, other_order=e) for p, (o, e) in zip(turned, flags, strict=True)
    ]


def _mean(run: Settled) -> tuple[float, float]:
    count = run.repeats or len(run.periods)
    periods, rates = run.periods[-count:], run.rates[-count:]
    return float(periods.mean()), float((periods * rates).sum() / periods.sum())


def _row(number: int, point: BranchPoint, order: int, *, folds: bool) -> dict[str, Any]:
    cycle = point.cycle
    first = cycle.multipliers[0] if len(cycle.multipliers) else 0.0
    return {
        "value": point.value,
        "kind": "cycle",
        "branch": number,
        "repeats": order,
        "period": cycle.period / order,
        "rop": cycle.rop,
        "multiplier": abs(first),
        "real": float(np.real(first)),
        "imaginary": float(np.imag(first)),
        "stable": cycle.stable,
        "folds": folds,
        "unresolved": point.unresolved,
        "other_order": point.other_order,
        "events": cycle.events,
    }


def _ways(
    preset: str | None,
    scene: Mapping[str, Value],
    name: str,
    values: list[float],
) -> Iterator[Settled]:
    """Simulates from rest at each value, then up and down the values without a restart."""
    for value in values:
        with Hammer({**scene, name: value}, preset=preset, quiet=True) as hammer:
            run = _settled(hammer, "from rest", value)
        if run:
            yield run
    if not VARIABLES[name].tunable:
        return
    for way, order in (("up", values), ("down", values[::-1])):
        with Hammer({**scene, name: order[0]}, preset=preset, quiet=True) as hammer:
            for value in order:
                hammer.set({name: value})
                run = _settled(hammer, way, value)
                if run is None:
                    break
                yield run


def _settled(hammer: Hammer, way: str, value: float) -> Settled | None:
    """Returns the last blows of a simulation; None if there are too few."""
    read = hammer.reader(["blow_count", "blow_period", "rop"])
    known, end = read()[0], hammer.time + LONGEST
    blows: list[tuple[float, float]] = []
    wanted = FORGOTTEN + OBSERVED
    while len(blows) < wanted:
        if hammer.time >= end:
            return None
        hammer.step(0.005)
        count, period, rop = read()
        if count > known:
            known = count
            blows.append((period, rop))
        if len(blows) == FORGOTTEN + OBSERVED and not repeats(np.array(blows)[-OBSERVED:, 0]):
            wanted = FORGOTTEN + BAND
    periods, rates = np.array(blows[FORGOTTEN:]).T
    return Settled(way, value, periods, rates)


def figure(table: pd.DataFrame) -> Figure:
    """ROP, time per blow and leading multiplier over the parameter."""
    styled = need("dth_hammer.style", "plot").styled
    Line2D = need("matplotlib.lines", "plot").Line2D
    name, unit = table.attrs["parameter"], table.attrs["unit"]
    chart: Figure
    with styled(8.0, 8.0) as chart:
        axes = chart.subplots(3, 1, sharex=True)
        simulated = table[table["kind"] == "simulated"]
        for axis, column, scale in ((axes[0], "rop", 3600.0), (axes[1], "period", 1e3)):
            settled = simulated[simulated["repeats"] != 0]
            axis.plot(settled["value"], scale * settled[column], "o", ms=4.5, zorder=3, **OPEN)
            irregular = simulated[simulated["repeats"] == 0].groupby("value")[column]
            low, high = scale * irregular.min(), scale * irregular.max()
            axis.vlines(low.index, low.to_numpy(), high.to_numpy(), **FILLED)
        cycles = table[table["kind"] == "cycle"]
        for _, branch in cycles.groupby("branch") if len(cycles) else []:
            colour = COLOURS.get(int(branch["repeats"].iloc[0]), "#000000")
            panels = (
                (axes[0], "rop", 3600.0),
                (axes[1], "period", 1e3),
                (axes[2], "multiplier", 1.0),
            )
            for axis, column, scale in panels:
                for stable, piece in _pieces(branch):
                    line, mark = ("-", ".") if stable else (":", "x")
                    axis.plot(piece["value"], scale * piece[column], line, marker=mark, ms=3,
                              lw=1.0, color=colour)  # fmt: skip
        axes[0].set_ylabel("ROP [m/h]")
        axes[1].set_ylabel("time per blow [ms]")
        axes[2].set_ylabel("size of leading Floquet multiplier")
        axes[2].set_xlabel(f"{name} [{unit}]")
        axes[2].axhline(1.0, lw=0.8, ls="--", color="#444444")
        axes[2].set_yscale("symlog", linthresh=1.0)
        axes[2].set_ylim(bottom=0.0)
        for axis in axes:
            axis.grid(alpha=0.3)
        kinds = set(zip(cycles["repeats"], cycles["stable"], strict=True)) if len(cycles) else set()
        handles = [Line2D([], [], ls="", marker="o", ms=4.5, **OPEN, label="blows of simulations")]
        if (simulated["repeats"] == 0).any():
            handles.append(Line2D([], [], **FILLED, label="irregular simulations: range of blows"))
        for order, unstable in sorted((int(order), not stable) for order, stable in kinds):
            text = "cycle" if order == 1 else f"cycle of {order} blows, mean"
            colour = COLOURS.get(order, "#000000")
            word, line, mark = ("unstable", ":", "x") if unstable else ("stable", "-", ".")
            handles.append(
                Line2D([], [], ls=line, marker=mark, ms=4, color=colour, label=f"{text}, {word}")
            )
        chart.legend(handles=handles, loc="outside upper center", ncols=3, fontsize="small")
    return chart


def _pieces(branch: pd.DataFrame) -> Iterator[tuple[bool, pd.DataFrame]]:
    """Parts of a branch with the same stability, joined where it changes, but not where the branch
    was not resolved.
    """
    stable, jump = (branch[name].to_numpy(bool) for name in ("stable", "unresolved"))
    breaks = [k for k in range(1, len(branch)) if jump[k] or stable[k] != stable[k - 1]]
    for first, end in pairwise([0, *breaks, len(branch)]):
        begin = first - 1 if first and not jump[first] else first
        yield bool(stable[first]), branch.iloc[begin:end]
