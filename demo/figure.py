"""The paper's Figure 3 from sampled outputs: one pressure cycle, and its blow."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

# The rock law's modes, from the bit free to the bit held, as the paper draws them.
MODES = {
    "FreeFlight": "FF",
    "DissipativeForward": "DFC",
    "Forward": "FC",
    "Backward": "BC",
    "Standstill": "SS",
}
# Distinct in print and to colour-blind readers (Okabe and Ito).
ROCK, PISTON, BIT, CONTACT = "#8c6d31", "#d55e00", "#0072b2", "#444444"
STYLE = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral", "DejaVu Serif"],
    "mathtext.fontset": "stix",
    "font.size": 10,
    "axes.titlesize": 10.5,
    "legend.fontsize": 9,
    "axes.linewidth": 0.7,
    "lines.linewidth": 1.3,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
}


@dataclass
class Record:
    """Outputs over one pressure cycle and a little more."""

    time: np.ndarray  # s, 0 at the impact
    rock: np.ndarray  # m, position of the rock surface
    piston: np.ndarray  # m, mean position, its face's initial gap taken off
    bit: np.ndarray  # m
    piston_velocity: np.ndarray  # m/s
    bit_velocity: np.ndarray
    mode: list[str]
    closed: np.ndarray

    def between(self, start: float, end: float) -> Record:
        """The part from `start` to `end`."""
        keep = (self.time >= start) & (self.time <= end)
        arrays = (self.rock, self.piston, self.bit, self.piston_velocity, self.bit_velocity)
        mode = [m for m, k in zip(self.mode, keep, strict=True) if k]
        return Record(self.time[keep], *(a[keep] for a in arrays), mode, self.closed[keep])


def displacements(axes: Axes, record: Record) -> None:
    """Rock surface, piston and bit from the rock surface before the blow, in mm."""
    time, base = record.time * 1e3, np.interp(0.0, record.time, record.rock)
    axes.plot(time, (record.piston - base) * 1e3, color=PISTON)
    axes.plot(time, (record.bit - base) * 1e3, color=BIT)
    axes.plot(time, (record.rock - base) * 1e3, color=ROCK, dashes=(4, 1.5))


def velocities(axes: Axes, record: Record) -> None:
    """Mean velocities of the two bodies."""
    axes.axhline(0.0, color="0.75", linewidth=0.6, zorder=0)
    axes.plot(record.time * 1e3, record.piston_velocity, color=PISTON)
    axes.plot(record.time * 1e3, record.bit_velocity, color=BIT)


def statuses(axes: Axes, record: Record) -> None:
    """Mode of the rock law as steps; contact as a second trace on a lane below."""
    lanes = {name: level for level, name in enumerate(MODES)}
    level = np.array([lanes[m] for m in record.mode], dtype=float)
    time = record.time * 1e3
    axes.step(time, level, where="post", color=BIT, linewidth=1.0)
    axes.axhline(-0.75, color="0.6", linewidth=0.6)
    closed = np.where(record.closed, -1.25, -2.25)
    axes.step(time, closed, where="post", color=CONTACT, linewidth=1.0)
    axes.set_yticks([-2.25, -1.25, *lanes.values()], ["open", "closed", *MODES.values()])
    axes.tick_params(axis="y", length=2)
    axes.set_ylim(-2.75, len(lanes) - 0.5)


ROWS = (
    ("a", "displacement (mm)", displacements),
    ("b", "mean velocity (m/s)", velocities),
    ("c", "contact  |  bit/rock mode", statuses),
)


def draw(record: Record, cycle: float, blow: float, path: Path) -> None:
    """Writes the figure: left `cycle` seconds from the impact, right `blow` seconds."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.5, 7.2), layout="constrained")
        grid = figure.subplots(3, 2, sharex="col", height_ratios=(1, 1, 1.15))
        windows = ((-0.03 * cycle, 1.03 * cycle), (-0.04 * blow, blow))
        for column, (start, end) in enumerate(windows):
            part = record.between(start, end)
            for (letter, label, fill), axes in zip(ROWS, grid[:, column], strict=True):
                fill(axes, part)
                axes.set_xlim(start * 1e3, end * 1e3)
                axes.axvline(0.0, color="0.75", linewidth=0.6, linestyle=":", zorder=0)
                axes.set_title(f"({letter}{column + 1})", loc="left", pad=3)
                if column == 0:
                    axes.set_ylabel(label)
            grid[-1, column].set_xlabel("time since impact (ms)")
        # The blow is about the bit and the rock: let the piston leave at the bottom.
        bit = part.bit - np.interp(0.0, part.time, part.rock)
        margin = np.ptp(bit) * 1e3
        grid[0, 1].set_ylim(bit.min() * 1e3 - margin, bit.max() * 1e3 + 0.4 * margin)
        figure.align_ylabels(grid[:, 0])
        grid[0, 0].set_title("one pressure cycle")
        grid[0, 1].set_title("after the impact")
        handles = [
            Line2D([], [], color=PISTON, label="piston"),
            Line2D([], [], color=BIT, label="bit"),
            Line2D([], [], color=ROCK, dashes=(4, 1.5), label="rock surface"),
        ]
        # Above the panels: no place inside them is free in both columns.
        figure.legend(handles=handles, loc="outside upper center", ncols=3, frameon=False)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=220)
