"""Figures of where the energy goes."""

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..errors import TooFewBlowsError
from ..frames import np
from ..scene.hammers import Hammerlike, Rocklike
from ..scene.variables import Array
from ..simulation.run import Run, simulate
from .marks import DARK, apart
from .style import styled

WORKS = {"energy_drive": "drive", "energy_gravity": "gravity", "energy_feed": "feed"}
SINKS = {
    "energy_rock_dissipated": "rock, elastic loading",
    "energy_viscous": "rock, viscous",
    "energy_damping": "material damping",
}
INTO_COLOURS = ("#0072b2", "#009e73", "#56b4e9", "#f0e442")
OUT_COLOURS = ("#8c6d31", "#d55e00", "#cc79a7", "#999999")
STORES = ("energy_kinetic", "energy_strain", "energy_contact", "energy_rock_stored")


def at_blows(
    hammer: Hammerlike = None,
    until: float | str | None = None,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
) -> Run:
    """Simulates a hammer and returns its outputs at the instants of the blows, for `ledger`.

    Example:
        >>> from dth_hammer import figures
        >>> print(len(figures.at_blows(until="300 ms").frame), "rows")
        7 rows
    """
    run = simulate(hammer, until, preset=preset, rock=rock, outputs=["blow_count"])
    table = run.blows
    if len(table) < 2:
        raise TooFewBlowsError(f"{len(table)} blows: too few for an energy ledger")
    return simulate(run, times=table["blow_time"].to_numpy())


def ledger(run: Run) -> Figure:
    """Draws the energy of each blow of a run that `at_blows` made: work done, and where it went.

    The last blow is drawn again at the right, enlarged and with its numbers.

    Example:
        >>> from dth_hammer import figures
        >>> figures.ledger(figures.at_blows(until="300 ms")).savefig("ledger.png")
    """
    frame = run.convert("si").frame
    if len(frame) < 2:
        raise TooFewBlowsError(f"{len(frame)} rows: too few for an energy ledger, see at_blows")
    spent = {c: frame[c].diff().to_numpy()[1:] for c in (*WORKS, *SINKS, *STORES)}
    into = {label: spent[c] for c, label in WORKS.items()}
    if frame["energy_retuned"].any():
        into["change of rock"] = frame["energy_retuned"].diff().to_numpy()[1:]
    out = {label: spent[c] for c, label in SINKS.items()}
    out["change of stored energy"] = np.sum([spent[c] for c in STORES], axis=0)
    numbers = np.arange(1, len(frame))
    with styled(8.5, 4.4) as figure:
        every, last = figure.subplots(1, 2, sharey=True, width_ratios=(1.25, 1))
        bounds = [
            _stack(every, numbers - 0.2, into, INTO_COLOURS, 0.36),
            _stack(every, numbers + 0.2, out, OUT_COLOURS, 0.36),
        ]
        # Matplotlib adds no margin beyond stacked bars, so set the limits explicitly.
        low, high = min(b[0] for b in bounds), max(b[1] for b in bounds)
        every.set_ylim(1.05 * low, 1.08 * high)
        every.set_xlabel("blow (left: work done, right: where it went)")
        every.set_ylabel("energy (J)")
        every.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        for side, parts, colours in ((-1, into, INTO_COLOURS), (1, out, OUT_COLOURS)):
            ending = {label: values[-1:] for label, values in parts.items()}
            _stack(last, np.array([0.26 * side]), ending, colours, 0.46)
            _name_parts(last, side, ending, colours, 0.11 * (high - low))
        last.set_xlim(-2.2, 2.9)
        last.set_xticks([])
        last.tick_params(axis="y", length=0)
        last.spines[:].set_visible(False)
        last.set_xlabel(f"blow {numbers[-1]}, enlarged")
        for axes in (every, last):
            axes.axhline(0.0, color=DARK, linewidth=0.6)
    return figure


def _stack(
    axes: Axes, positions: Array, parts: Mapping[str, Any], colours: tuple[str, ...], width: float
) -> tuple[float, float]:
    top, bottom = np.zeros(len(positions)), np.zeros(len(positions))
    for (label, values), colour in zip(parts.items(), colours, strict=False):
        base = np.where(values >= 0, top, bottom)
        axes.bar(positions, values, width=width, bottom=base, color=colour, label=label)
        top, bottom = top + np.maximum(values, 0), bottom + np.minimum(values, 0)
    return float(bottom.min()), float(top.max())


def _name_parts(
    axes: Axes, side: int, parts: Mapping[str, Any], colours: tuple[str, ...], room: float
) -> None:
    """Writes names and numbers beside a bar, spread out where its parts are thin."""
    values = {label: float(v[0]) for label, v in parts.items()}
    middles, top, bottom = [], 0.0, 0.0
    for value in values.values():
        middles.append((top if value >= 0 else bottom) + 0.5 * value)
        top, bottom = top + max(value, 0.0), bottom + min(value, 0.0)
    label_places = apart(middles, room, top)
    total = sum(values.values())
    for (label, value), middle, place, colour in zip(
        values.items(), middles, label_places, colours, strict=False
    ):
        axes.annotate(
            f"{label}\n{value:.1f} J, {100 * value / total:.1f} %",
            xy=(0.49 * side, middle),
            xytext=(0.85 * side, place),
            ha="left" if side > 0 else "right",
            va="center",
            fontsize=8.5,
            arrowprops={
                "arrowstyle": "-",
                "color": colour,
                "shrinkA": 2,
                "shrinkB": 0,
                "relpos": (0.0 if side > 0 else 1.0, 0.5),
            },
        )
