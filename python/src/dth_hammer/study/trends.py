"""How the long-run response depends on parameters, over widths that the user states.

A response is piecewise smooth with hundreds of pieces, and an exact derivative holds only on one
of them. A trend describes many pieces: it is a straight line in logarithms, fitted to means at
points spread over the box of the widths. The residual scatter is given as the roughness.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..contract import typed
from ..errors import DomainError, RefusedError, warn
from ..extras import need
from ..frames import np, pd
from ..scene.band import beside, factor, in_words, sides, with_sides
from ..scene.hammers import Hammerlike, Rocklike, numbers_of
from ..scene.variables import Array, whole
from ..simulation import answers
from ..simulation.gradients import differentiable
from .longrun import Steady, Wanted, named, responses

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OUTPUTS = ("rop", "blow_frequency", "blow_speed", "blow_energy", "rebound_ratio", "rock_force_peak")
#: Default number of points per coefficient of the fit.
POINTS = 4
#: Squares are added to a straight line if they reduce the residual variance below this share.
CURVE_GAIN = 0.8


@dataclass(frozen=True)
class Line:
    """A fit of one output in logarithms: ``ln y = ln value + slopes . ln(x / x0)``."""

    value: float
    slopes: Array
    #: Covariance matrix of the constant term and the slopes.
    covariance: Array
    #: Standard deviation of the residuals, relative to the output.
    residual: float


@dataclass(frozen=True, repr=False)
class Trend(answers.Answer):
    """Trends of outputs over parameters."""

    #: Elasticity ``d ln output / d ln parameter`` over the widths, and its standard error: one row
    #: for each output and parameter.
    table: pd.DataFrame
    #: Relative standard deviation of each output around its trend, caused by jumps between the
    #: smooth pieces. The statistical errors of the means are already subtracted.
    roughness: pd.Series
    #: Relative half width of each parameter's interval.
    widths: pd.Series
    #: Fitted means at the centre, with the range of a rate of penetration (``low``, ``high``).
    middle: pd.DataFrame
    #: Parameters and means at each point; for a rate of penetration also its range, in the columns
    #: ``rop_low`` and ``rop_high``.
    points: pd.DataFrame = field(repr=False)
    #: Reasons why some points have no response.
    refused: tuple[str, ...] = ()
    #: Number of points with each kind of motion.
    kinds: Mapping[str, int] = field(default_factory=dict)
    #: Numbers of all parameters and inputs that were set at the centre, by name, in SI units.
    parameters: Mapping[str, float] = field(default_factory=dict, repr=False)

    @property
    def elasticities(self) -> pd.DataFrame:
        """The elasticities, one row per output and one column per parameter."""
        return (
            self.table["elasticity"]
            .unstack("by")
            .loc[[*self.roughness.index], [*self.widths.index]]
        )

    def plot(self) -> Figure:
        """Plots the effect of each parameter on each output as a tornado chart."""
        styled = need("dth_hammer.figures.style").styled
        outputs = [*self.roughness.index]
        height = 0.8 + 0.32 * len(self.widths)
        chart: Figure
        with styled(7.5, height * len(outputs)) as chart:
            axes: Any = chart.subplots(len(outputs), 1, squeeze=False)[:, 0]
            for axis, output in zip(axes, outputs, strict=True):
                # Change of the output in per cent when a parameter changes by its width.
                effects = self.table.loc[output].mul(100.0 * self.widths, axis=0)
                effects = effects.sort_values("elasticity", key=abs, ascending=False)
                sizes, places = effects["elasticity"], np.arange(len(effects))[::-1]
                for sign, colour in ((1.0, "#0072b2"), (-1.0, "#e69f00")):
                    label = "more of it" if sign > 0 else "less of it"
                    axis.barh(places, sign * sizes, color=colour, height=0.6, label=label)
                axis.errorbar(
                    sizes, places, xerr=2.0 * effects["error"], fmt="none", ecolor="#222222", lw=1.2
                )
                rough = 100.0 * float(self.roughness[output])
                axis.axvspan(-rough, rough, color="#999999", alpha=0.3, lw=0, label="roughness")
                labels = [f"{n} ±{100 * self.widths[n]:g} %" for n in effects.index]
                axis.set_yticks(places, labels)
                axis.axvline(0.0, color="#222222", lw=0.8)
                axis.set_title(output, fontsize="medium", loc="left")
                axis.grid(axis="x", alpha=0.3)
            axes[-1].set_xlabel("change [%]; whiskers: two standard errors")
            chart.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
        return chart

    def to_frame(self) -> pd.DataFrame:
        """Returns the elasticities, with the roughness in the last column."""
        return self.elasticities.assign(roughness=self.roughness)

    def in_words(self) -> list[str]:
        """Returns widths and number of points, then the rate at the centre with its range."""
        widths = ", ".join(f"{name} +-{100 * width:g} %" for name, width in self.widths.items())
        motions = ", ".join(f"{count} {kind}" for kind, count in self.kinds.items())
        text = f"trends over {widths}: {len(self.points)} points ({motions})"
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
    """Finds how long-run means depend on parameters, by a power law fitted over stated widths.

    The power law is ``ln y = a + sum of e_k ln(x_k / x0_k)``. The elasticity ``e_k`` says by how
    many per cent an output changes if a parameter changes by one per cent. The hammers are at the
    points of a Sobol sequence.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        widths: relative half widths by parameter or constant input: 0.05 means 5 % to either side.
        outputs: means of the long-run response, such as ``rop`` or ``blow_energy``.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        points: number of hammers, rounded up to a power of two; by default four per coefficient.
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
    box = box_of(given, widths or {})
    count = points or POINTS * (len(box) + 2)
    if count < len(box) + 3:
        raise DomainError(f"points = {count}: {len(box)} parameters need {len(box) + 3} or more")
    log_widths = np.log1p([*box.values()])
    logs = sobol(len(box), count, seed) * log_widths
    origin = np.array([whole(given)[name] for name in box])
    scenes = [given | dict(zip(box, map(float, x), strict=True)) for x in origin * np.exp(logs)]
    results = responses(scenes, Wanted(error=error), progress=progress)
    failed = (a for a in results if has_no_response(a))
    refused = tuple(dict.fromkeys(a if isinstance(a, str) else a.kind for a in failed))
    means, errors = table_of(results, names)
    complete = int(np.isfinite(means[:, 0]).sum()) if names else 0
    if complete < len(box) + 3:
        raise RefusedError(
            f"only {complete} of {len(results)} points have a response: {refused[:1]}"
        )
    if refused:
        warn(f"{len(results) - complete} of {len(results)} points have no response: {refused[0]}")
    lines = [line(logs, means[:, k]) for k in range(len(names))]
    rows = [dict(zip(names, map(float, row), strict=True)) for row in means]
    rows = [{**scene, **row, **sides(row, scene)} for scene, row in zip(scenes, rows, strict=True)]
    frame = pd.DataFrame(rows, columns=pd.Index([*box, *with_sides(names)]))
    kinds = pd.Series([a.kind for a in results if isinstance(a, Steady)]).value_counts()
    sampled = np.nanmean((errors / means) ** 2, axis=0)
    return Trend(
        table=_table(names, [*box], lines),
        roughness=pd.Series(
            [np.sqrt(max(0.0, fit.residual**2 - s)) for fit, s in zip(lines, sampled, strict=True)],
            index=pd.Index(names, name="output"),
            name="roughness",
        ),
        widths=pd.Series(dict(box), name="width", dtype=float),
        middle=beside(
            pd.DataFrame({"mean": [fit.value for fit in lines]}, names), "mean", factor(given)
        ),
        points=frame,
        refused=refused,
        kinds={str(kind): int(number) for kind, number in kinds.items()},
        parameters=given,
    )


def has_no_response(answer: Steady | str) -> bool:
    """Returns whether a hammer has no response: it was refused, or it stalled."""
    return isinstance(answer, str) or answer.kind == "stalled"


def table_of(answers: Sequence[Steady | str], names: Sequence[str]) -> tuple[Array, Array]:
    """Returns means and errors, one row per hammer; those of refused hammers are NaN."""
    rows = np.full((2, len(answers), len(names)), np.nan)
    for k, answer in enumerate(answers):
        if not isinstance(answer, str):
            rows[:, k] = answer.outputs.loc[[*names], ["mean", "error"]].to_numpy(float).T
    return rows[0], rows[1]


def box_of(given: Mapping[str, float], widths: Mapping[str, float]) -> dict[str, float]:
    """Returns the widths after checking their names and values."""
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
    """Returns Sobol points in [-1, 1]; their number is ``count`` rounded up to a power of two."""
    if seed < 0:
        raise DomainError(f"seed = {seed} must be 0 or more")
    qmc = need("scipy.stats").qmc
    power = max(1, int(np.ceil(np.log2(count))))
    points: Array = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(power)
    return 2.0 * points - 1.0


def line(logs: Array, values: Array) -> Line:
    """Fits an output by least squares in logarithms, with squares if they help, see CURVE_GAIN."""
    finite = np.isfinite(values)
    y = values[finite]
    middle = float(np.mean(y))
    same_sign = len(y) and (np.sign(y) == np.sign(middle)).all() and middle != 0.0
    # An output that changes sign has no logarithm: fit its relative deviation from the mean.
    targets = np.log(y / middle) if same_sign else y / middle - 1.0
    straight = np.column_stack([np.ones(len(y)), logs[finite]])
    curved = np.column_stack([straight, logs[finite] ** 2 - np.mean(logs[finite] ** 2, axis=0)])
    fit = fitted(straight, targets)
    if len(y) > curved.shape[1] + 3:
        curved_fit = fitted(curved, targets)
        if curved_fit[2] ** 2 < CURVE_GAIN * fit[2] ** 2:
            fit = curved_fit
    coefficients, covariance, residual = fit
    width = logs.shape[1] + 1
    value = middle * (np.exp(coefficients[0]) if same_sign else 1.0 + coefficients[0])
    return Line(float(value), coefficients[1:width], covariance[:width, :width], residual)


def fitted(basis: Array, targets: Array) -> tuple[Array, Array, float]:
    """Returns coefficients, their covariance, and the standard deviation of the residuals."""
    coefficients, *_ = np.linalg.lstsq(basis, targets, rcond=None)
    degrees_of_freedom = len(targets) - basis.shape[1]
    variance = float(np.sum((targets - basis @ coefficients) ** 2)) / max(degrees_of_freedom, 1)
    return coefficients, variance * np.linalg.pinv(basis.T @ basis), float(np.sqrt(variance))


def _table(names: Sequence[str], parameters: Sequence[str], lines: Sequence[Line]) -> pd.DataFrame:
    rows = [
        {"elasticity": slope, "error": float(np.sqrt(fit.covariance[1 + k, 1 + k]))}
        for fit in lines
        for k, slope in enumerate(fit.slopes)
    ]
    return pd.DataFrame(
        rows, index=pd.MultiIndex.from_product([names, parameters], names=["output", "by"])
    )
