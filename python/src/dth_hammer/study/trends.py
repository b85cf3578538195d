"""What the long-run response depends on over a width that the user states.

A response is piecewise smooth with hundreds of pieces; an exact derivative holds on one of them.
A trend is what is left over many: a straight line through means at points spread over the box of
widths, in logarithms, with what it leaves.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..contract import typed
from ..errors import DomainError, RefusedError, warn
from ..extras import need
from ..run import answers
from ..run.gradients import differentiable
from ..scene.band import beside, factor, in_words, sides, with_sides
from ..scene.hammers import Hammerlike, Rocklike, numbers_of
from ..scene.variables import Array, whole
from .longrun import Steady, Wanted, named, responses

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: What depends, if nobody says.
OUTPUTS = ("rop", "blow_frequency", "blow_speed", "blow_energy", "rebound_ratio", "rock_force_peak")
#: Points of a design are at least so many times its coefficients.
POINTS = 4
#: A curve is fitted if it leaves less than this part of what a straight line leaves, squared, for
#: each coefficient more.
PAYS = 0.8


@dataclass(frozen=True)
class Line:
    """A fit of one output in the logarithms: ``ln y = value + slopes . ln(x / x0)``."""

    value: float
    slopes: Array
    #: Covariance of the slopes, and of value and slopes.
    covariance: Array
    #: Standard deviation of what is left, over the output.
    left: float


@dataclass(frozen=True, repr=False)
class Trend(answers.Answer):
    """Trends of outputs over parameters."""

    #: ``d ln output / d ln parameter`` over the widths, and its standard error: a row for each
    #: output and parameter.
    table: pd.DataFrame
    #: What is left of each output beside the trend, as a part of it: jumps from piece to piece. The
    #: errors of the means are taken off.
    roughness: pd.Series
    #: Widths, as a part of each parameter, both ways.
    widths: pd.Series
    #: Means in the middle, by the fit, with the range of a rate of penetration (``low``, ``high``).
    middle: pd.DataFrame
    #: The points and the means there; of a rate of penetration also its range, as in `middle`, in
    #: columns ``rop_low`` and ``rop_high``.
    points: pd.DataFrame = field(repr=False)
    #: Why points have none.
    refused: tuple[str, ...] = ()
    #: Kinds of motion that were met, and how often.
    kinds: Mapping[str, int] = field(default_factory=dict)
    #: Numbers of all that was set in the middle, by name, in SI units.
    parameters: Mapping[str, float] = field(default_factory=dict, repr=False)

    @property
    def elasticities(self) -> pd.DataFrame:
        """Returns the trends as a table of outputs by parameters."""
        return (
            self.table["elasticity"]
            .unstack("by")
            .loc[[*self.roughness.index], [*self.widths.index]]
        )

    def plot(self) -> Figure:
        """Plots the effect of each width on each output, largest first (a tornado chart)."""
        styled = need("dth_hammer.figures.style").styled
        outputs = [*self.roughness.index]
        height = 0.8 + 0.32 * len(self.widths)
        chart: Figure
        with styled(7.5, height * len(outputs)) as chart:
            axes: Any = chart.subplots(len(outputs), 1, squeeze=False)[:, 0]
            for axis, output in zip(axes, outputs, strict=True):
                # Per cent of the output that each width changes, and its error, the widest first.
                part = self.table.loc[output].mul(100.0 * self.widths, axis=0)
                part = part.sort_values("elasticity", key=abs, ascending=False)
                sizes, places = part["elasticity"], np.arange(len(part))[::-1]
                for way, colour in ((1.0, "#0072b2"), (-1.0, "#e69f00")):
                    label = "more of it" if way > 0 else "less of it"
                    axis.barh(places, way * sizes, color=colour, height=0.6, label=label)
                axis.errorbar(
                    sizes, places, xerr=2.0 * part["error"], fmt="none", ecolor="#222222", lw=1.2
                )
                rough = 100.0 * float(self.roughness[output])
                axis.axvspan(-rough, rough, color="#999999", alpha=0.3, lw=0, label="roughness")
                labels = [f"{n} ±{100 * self.widths[n]:g} %" for n in part.index]
                axis.set_yticks(places, labels)
                axis.axvline(0.0, color="#222222", lw=0.8)
                axis.set_title(output, fontsize="medium", loc="left")
                axis.grid(axis="x", alpha=0.3)
            axes[-1].set_xlabel("change [%]; whiskers: two standard errors")
            chart.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
        return chart

    def to_frame(self) -> pd.DataFrame:
        """Returns the trends, and the roughness beside them."""
        return self.elasticities.assign(roughness=self.roughness)

    def in_words(self) -> list[str]:
        """Widths and number of points, then the rate in the middle with its range."""
        widths = ", ".join(f"{name} +-{100 * width:g} %" for name, width in self.widths.items())
        met = ", ".join(f"{count} {kind}" for kind, count in self.kinds.items())
        text = f"trends over {widths}: {len(self.points)} points ({met})"
        if "rop" not in self.middle.index:
            return [text]
        return [text, in_words(self.middle["mean"]["rop"], self.parameters)]


@typed(widths='give widths by parameter: {"rock.stiffness": 0.05}')
def trend(
    hammer: Hammerlike = None,
    widths: Mapping[str, float] | None = None,
    outputs: Iterable[str] = OUTPUTS,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    points: int | None = None,
    error: float = 0.003,
    seed: int = 1,
    progress: bool = False,
) -> Trend:
    """Finds what long-run means depend on: a power law, fitted over a range of parameters.

    ``ln y = a + sum of e_k ln(x_k / x0_k)``: an elasticity ``e_k`` says by how many per cent an
    output changes for one per cent of a parameter, over the stated width. Points are Sobol's.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        widths: by parameter or constant input, how far from its value, as a part of it: 0.05.
        outputs: means of the long-run response, as ``rop`` or ``blow_energy``.
        preset: parameter set that a mapping is laid over.
        rock: beside it: a name, a class or a strength, or a file, as `dth_hammer.rock` takes them.
        points: number of hammers, rounded up to a power of two; four a coefficient if not given.
        error: relative standard error of the rate of penetration at each point.
        seed: random seed of the points.
        progress: shows a progress bar.

    Example:
        >>> from dth_hammer import trend
        >>> found = trend({"fidelity": "Rigid"}, {"feed_force": 0.05}, ["blow_energy"], points=8)
        >>> print(found.elasticities.loc["blow_energy"].round(2).to_dict())
        {'feed_force': -0.05}
    """
    given, names = numbers_of(hammer, preset, rock), [named(name) for name in outputs]
    wide = box_of(given, widths or {})
    count = points or POINTS * (len(wide) + 2)
    if count < len(wide) + 3:
        raise DomainError(f"points = {count}: {len(wide)} parameters need {len(wide) + 3} or more")
    half = np.log1p([*wide.values()])
    logs = sobol(len(wide), count, seed) * half
    origin = np.array([whole(given)[name] for name in wide])
    scenes = [given | dict(zip(wide, map(float, x), strict=True)) for x in origin * np.exp(logs)]
    found = responses(scenes, Wanted(error=error), progress=progress)
    refused = tuple(dict.fromkeys(a if isinstance(a, str) else a.kind for a in found if lost(a)))
    means, errors = table_of(found, names)
    known = int(np.isfinite(means[:, 0]).sum()) if names else 0
    if known < len(wide) + 3:
        raise RefusedError(f"only {known} of {len(found)} points have a response: {refused[:1]}")
    if refused:
        warn(f"{len(found) - known} of {len(found)} points have no response: {refused[0]}")
    lines = [line(logs, means[:, k]) for k in range(len(names))]
    rows = [dict(zip(names, map(float, row), strict=True)) for row in means]
    rows = [{**scene, **row, **sides(row, scene)} for scene, row in zip(scenes, rows, strict=True)]
    frame = pd.DataFrame(rows, columns=pd.Index([*wide, *with_sides(names)]))
    kinds = pd.Series([a.kind for a in found if isinstance(a, Steady)]).value_counts()
    sampled = np.nanmean((errors / means) ** 2, axis=0)
    return Trend(
        table=_table(names, [*wide], lines),
        roughness=pd.Series(
            [np.sqrt(max(0.0, fit.left**2 - s)) for fit, s in zip(lines, sampled, strict=True)],
            index=pd.Index(names, name="output"),
            name="roughness",
        ),
        widths=pd.Series(dict(wide), name="width", dtype=float),
        middle=beside(
            pd.DataFrame({"mean": [fit.value for fit in lines]}, names), "mean", factor(given)
        ),
        points=frame,
        refused=refused,
        kinds={str(kind): int(number) for kind, number in kinds.items()},
        parameters=given,
    )


def lost(answer: Steady | str) -> bool:
    """Returns whether there is no response."""
    return isinstance(answer, str) or answer.kind == "stalled"


def table_of(answers: Sequence[Steady | str], names: Sequence[str]) -> tuple[Array, Array]:
    """Returns means and errors, one row per hammer; NaN where there is none."""
    rows = np.full((2, len(answers), len(names)), np.nan)
    for k, answer in enumerate(answers):
        if not isinstance(answer, str):
            rows[:, k] = answer.outputs.loc[[*names], ["mean", "error"]].to_numpy(float).T
    return rows[0], rows[1]


def box_of(given: Mapping[str, float], widths: Mapping[str, float]) -> dict[str, float]:
    """Checks the widths."""
    if not (widths and isinstance(widths, Mapping)):
        raise DomainError('give widths by parameter: {"rock.stiffness": 0.05}')
    values = whole(given)
    for name in differentiable(widths):
        width = widths[name]
        if not 0.0 < width < 1.0:
            raise DomainError(f"the width of {name} = {width} must be above 0 and below 1")
        if values[name] == 0.0:
            raise DomainError(f"{name} is 0, and widths are relative: give it another value")
    return dict(widths)


def sobol(dimensions: int, count: int, seed: int) -> Array:
    """Returns space-filling points in [-1, 1], a power of two of them, without repetition."""
    if seed < 0:
        raise DomainError(f"seed = {seed} must be 0 or more")
    qmc = need("scipy.stats").qmc
    power = max(1, int(np.ceil(np.log2(count))))
    points: Array = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(power)
    return 2.0 * points - 1.0


def line(logs: Array, values: Array) -> Line:
    """Fits an output by least squares in logarithms, with squares where these reduce the error."""
    known = np.isfinite(values)
    y = values[known]
    middle = float(np.mean(y))
    signed = len(y) and (np.sign(y) == np.sign(middle)).all() and middle != 0.0
    # What changes its sign has no logarithm: parts of its mean then.
    targets = np.log(y / middle) if signed else y / middle - 1.0
    straight = np.column_stack([np.ones(len(y)), logs[known]])
    curved = np.column_stack([straight, logs[known] ** 2 - np.mean(logs[known] ** 2, axis=0)])
    fit = fitted(straight, targets)
    if len(y) > curved.shape[1] + 3:
        other = fitted(curved, targets)
        if other[2] ** 2 < PAYS * fit[2] ** 2:
            fit = other
    coefficients, covariance, left = fit
    width = logs.shape[1] + 1
    value = middle * (np.exp(coefficients[0]) if signed else 1.0 + coefficients[0])
    return Line(float(value), coefficients[1:width], covariance[:width, :width], left)


def fitted(basis: Array, targets: Array) -> tuple[Array, Array, float]:
    """Coefficients, their covariance, and the standard deviation of what is left."""
    coefficients, *_ = np.linalg.lstsq(basis, targets, rcond=None)
    free = len(targets) - basis.shape[1]
    left = float(np.sum((targets - basis @ coefficients) ** 2)) / max(free, 1)
    return coefficients, left * np.linalg.pinv(basis.T @ basis), float(np.sqrt(left))


def _table(names: Sequence[str], by: Sequence[str], lines: Sequence[Line]) -> pd.DataFrame:
    rows = [
        {"elasticity": slope, "error": float(np.sqrt(fit.covariance[1 + k, 1 + k]))}
        for fit in lines
        for k, slope in enumerate(fit.slopes)
    ]
    return pd.DataFrame(rows, index=pd.MultiIndex.from_product([names, by], names=["output", "by"]))
