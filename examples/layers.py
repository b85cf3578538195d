"""Drilling through layers: the rock's tunable parameters follow the hole's depth.

python examples/layers.py --out layers.png
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from dth_hammer import VARIABLES, Hammer, rock, simulate
from dth_hammer.figures import BIT, ROCK
from dth_hammer.figures.style import styled
from matplotlib.figure import Figure

#: Depth at which each rock begins, m, and the rock: a name, a class or a strength.
Layer = tuple[float, str]
FORMATION: Sequence[Layer] = ((0.0, "R3"), (0.012, "granite"), (0.024, "limestone"))


class Formation:
    """A control for `simulate` that sets the rock which the hole has reached."""

    def __init__(self, layers: Sequence[Layer]) -> None:
        hole = VARIABLES["hole.diameter"].start
        self.layers = [
            (top, {n: x for n, x in rock(name, hole=hole).items() if n[0] == "r"})
            for top, name in sorted(layers)
        ]
        self.current = 0

    def __call__(self, hammer: Hammer) -> None:
        """Changes the rock when the depth reaches a new layer."""
        depth = hammer["tip_depth"]
        reached = max(i for i, (top, _) in enumerate(self.layers) if i == 0 or depth >= top)
        if reached != self.current:
            self.current = reached
            hammer.set(self.layers[reached][1])


def run(until: float = 2.0, layers: Sequence[Layer] = FORMATION) -> pd.DataFrame:
    """Returns the outputs over time."""
    names = [
        "tip_depth",
        "rop",
        "blow_time",
        "blow_count",
        "energy_retuned",
        "energy_residual",
    ]
    control = Formation(layers)
    return simulate(until=until, outputs=names, control=control, rock=layers[0][1]).frame


def draw(frame: pd.DataFrame, layers: Sequence[Layer] = FORMATION) -> Figure:
    """Draws depth over time, and rate of penetration over depth with the names of the layers."""
    with styled(7.5, 4.0) as figure:
        left, right = figure.subplots(1, 2, sharey=True)
        left.plot(frame.index, frame["tip_depth"] * 1e3, color=ROCK)
        right.plot(frame["rop"] * 1e3, frame["tip_depth"] * 1e3, color=BIT)
        for top, name in layers:
            for axes in (left, right):
                axes.axhline(top * 1e3, color="0.6", linewidth=0.7, linestyle=":")
            left.annotate(
                name,
                (frame.index[-1], top * 1e3),
                xytext=(-4, -4),
                textcoords="offset points",
                ha="right",
                va="top",
            )
        left.invert_yaxis()
        left.set_xlabel("time (s)")
        left.set_ylabel("tip depth (mm)")
        right.set_xlabel("rate of penetration, last blow period (mm/s)")
    return figure


def main() -> None:
    """Runs and draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("layers.png"))
    options = parser.parse_args()
    frame = run()
    draw(frame).savefig(options.out, dpi=160)
    print(f"{frame['tip_depth'].iloc[-1] * 1e3:.1f} mm in {frame.index[-1]:g} s")


if __name__ == "__main__":
    main()
