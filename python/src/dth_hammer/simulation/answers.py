"""How results are displayed: as text, as HTML in notebooks, and as figures."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from typing import TYPE_CHECKING

from ..errors import MissingError, TooFewBlowsError
from ..extras import need
from ..frames import np, pd

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..scene.variables import Array

BLUE, ORANGE, GREY, BROWN, DARK = "#0072b2", "#d55e00", "#999999", "#8c6d31", "#444444"
#: Half of the interval that holds 95 of 100 normal deviates.
BAND = 1.96


def image(figure: Figure, caption: str, dpi: int = 130) -> str:
    """Returns a figure as an HTML image element."""
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=dpi)
    picture = base64.b64encode(data.getvalue()).decode("ascii")
    return f'<img alt="{html.escape(caption)}" src="data:image/png;base64,{picture}">'


class Answer:
    """The result of a function: sentences, a table, and for some results a figure."""

    #: Caption of the figure that `plot` draws; empty for a result without a figure.
    caption = ""

    def in_words(self) -> list[str]:
        """Returns the sentences that are displayed above the table."""
        return []

    def to_frame(self) -> pd.DataFrame:
        """Returns the result's numbers as a table."""
        raise NotImplementedError

    def plot(self) -> Figure:
        """Draws the result's figure."""
        raise NotImplementedError

    def __repr__(self) -> str:
        table = self.to_frame()
        text = table.to_string(max_rows=20, float_format="{:.5g}".format, na_rep="", line_width=100)
        return "\n".join([*self.in_words(), text])

    def _repr_html_(self) -> str:
        """Returns HTML for notebooks; without matplotlib only sentences and table."""
        texts = "".join(f"<p>{html.escape(text)}</p>" for text in self.in_words())
        markup = texts + self.to_frame().to_html(
            max_rows=20, float_format="{:.6g}".format, na_rep=""
        )
        with suppress(MissingError, TooFewBlowsError):
            return markup + image(self.plot(), self.caption, 90) if self.caption else markup
        return markup


def _styled(width: float, height: float) -> AbstractContextManager[Figure]:
    style = need("dth_hammer.figures.style")
    figure: AbstractContextManager[Figure] = style.styled(width, height)
    return figure


def energies(works: Mapping[str, float]) -> Figure:
    """Draws the energies (J) of a blow or a cycle: work done on the hammer, and where it went."""
    sources = ("drive", "gravity", "feed")
    names = [name.removeprefix("energy_").replace("_", " ") for name in works]
    colours = [BLUE if name in sources else ORANGE for name in names]
    with _styled(6.5, 0.8 + 0.3 * len(works)) as figure:
        axes = figure.subplots()
        axes.barh(names, [*works.values()], color=colours)
        axes.invert_yaxis()
        axes.set_xlabel("energy (J); blue: put in, orange: where it went")
    return figure


def residuals(table: pd.DataFrame) -> Figure:
    """Draws the residuals of a fit: fitted minus measured value, divided by the standard error."""
    over_time = table.index.name == "time"
    label = "fitted less measured, over the error; grey: 95 of 100"
    with _styled(6.5, 3.0 if over_time else 0.9 + 0.3 * len(table)) as figure:
        axes = figure.subplots()
        if over_time:
            axes.axhspan(-BAND, BAND, color=GREY, alpha=0.3, lw=0)
            axes.plot(1e3 * table.index, table["residual"], ".", color=BLUE)
            axes.set(xlabel="time (ms)", ylabel=label)
            return figure
        axes.axvspan(-BAND, BAND, color=GREY, alpha=0.3, lw=0)
        axes.plot(table["residual"], [*table.index], "o", color=BLUE)
        axes.margins(y=0.5 / len(table))
        axes.invert_yaxis()
        axes.set_xlabel(label)
    return figure


def history(table: pd.DataFrame, chosen: float, tolerance: float) -> Figure:
    """Draws the goal of every design in the order of trial.

    Args:
        table: one row per design, with the columns ``goal`` and ``past ...`` (by how much the
            design exceeds each limit, relative to the limit).
        chosen: goal of the chosen design.
        tolerance: a design counts as within a limit if it exceeds it by no more than this.
    """
    inside = (table.filter(like="past ").fillna(0.0) <= tolerance).all(axis=1).to_numpy()
    number, goal = np.arange(1, len(table) + 1), table["goal"]
    with _styled(6.5, 3.0) as figure:
        axes = figure.subplots()
        axes.plot(number[inside], goal[inside], "o", color=BLUE, label="within the limits")
        if not inside.all():
            axes.plot(number[~inside], goal[~inside], "x", color=GREY, label="beyond them")
        axes.axhline(chosen, color=ORANGE, label="chosen")
        axes.set(xlabel="design", ylabel="goal (SI units)")
        figure.legend(loc="outside upper center", ncols=3)
    return figure


def exchanged(table: pd.DataFrame, end: float) -> Figure:
    """Draws a coupled hammer's inputs step by step, and the piston's height above the bit."""
    names = [name for name in table if not str(name).startswith("relative_")]
    times = np.append(table.index, end)
    with _styled(7.0, 4.5) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        for name, colour in zip(names, (BLUE, ORANGE, BROWN, DARK), strict=False):
            steps = np.column_stack([times[:-1], times[1:]]).ravel()
            upper.plot(steps, np.repeat(table[name].to_numpy(), 2), color=colour, label=name)
        units = {str(table.attrs["units"][name]) for name in names}
        upper.set_ylabel(f"given to the hammer ({', '.join(sorted(units))})")
        figure.legend(loc="outside upper center", ncols=2)
        lower.plot(table.index, 1e3 * table["relative_position"], color=DARK)
        lower.set(xlabel="time (s)", ylabel="piston over bit (mm)")
    return figure


def over_time(times: Array, columns: Sequence[tuple[Array, str]], ax: Axes | None = None) -> Figure:
    """Draws columns over time, each in its own panel, or all in the given axes."""
    if ax is not None:
        for values, label in columns:
            ax.plot(times, values, label=label)
        ax.set_xlabel("time (s)")
        ax.legend()
        figure: Figure = ax.get_figure(root=True)  # type: ignore[assignment]
        return figure
    with _styled(7.0, 1.2 + 1.6 * len(columns)) as figure:
        panels = figure.subplots(len(columns), sharex=True, squeeze=False)[:, 0]
        for axes, (values, label) in zip(panels, columns, strict=True):
            axes.plot(times, values, color=BLUE)
            axes.set_ylabel(label)
            axes.grid(color="0.92", linewidth=0.6)
        panels[-1].set_xlabel("time (s)")
        figure.align_ylabels()
    return figure


def overview(frame: pd.DataFrame, blows: pd.DataFrame) -> Figure:
    """Draws drilled length, speed and energy of the blows, and rate of penetration over time."""
    rows: tuple[tuple[str, float, str, str], ...] = (
        ("drilled_length", 1e3, "drilled length (mm)", BROWN),
        ("blow_speed", 1.0, "impact speed (m/s)", ORANGE),
        ("blow_energy", 1.0, "blow energy (J)", DARK),
        ("rop", 3600.0, "ROP (m/h)", BLUE),
    )
    with _styled(7.0, 7.0) as figure:
        panels = figure.subplots(len(rows), sharex=True)
        for axes, (column, factor, label, colour) in zip(panels, rows, strict=True):
            if column == "drilled_length":
                axes.plot(frame.index, frame[column] * factor, color=colour)
            else:
                displayed = blows[blows[column] > 0]
                axes.plot(
                    displayed["blow_time"], displayed[column] * factor, "o-", color=colour, ms=3
                )
            axes.set_ylabel(label)
            axes.grid(color="0.92", linewidth=0.6)
        panels[-1].set_xlabel("time (s)")
        figure.align_ylabels()
    return figure
