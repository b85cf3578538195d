"""Holds a hammer's blow frequency with the feed, by a controller that is learned.

    pip install dth-hammer[gym]
    python examples/hold_frequency.py --out hold.png

Each episode has a rock of its own; the controller sees the frequency of the last blow and sets the
feed force. It is a PI controller whose two gains are found by the cross-entropy method: of many
that drill side by side the best are kept, and the next are drawn around them.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from dth_hammer.environment import HammerVectorEnv, Task
from dth_hammer.figures import BIT, PISTON, STYLE
from dth_hammer.longrun import Hammerlike
from dth_hammer.variables import Array
from matplotlib.figure import Figure

#: Frequency to hold, Hz.
WANTED = 22.3
#: Bounds of the feed force, N, and of what is observed, s.
FEED = (1e3, 25e3)
PERIOD = (0.03, 0.06)


def reward(outputs: Mapping[str, Array]) -> Array:
    """Minus the relative deviation of the frequency, per cent; nothing before the second blow."""
    period = np.where(outputs["blow_period"] > 0.0, outputs["blow_period"], np.nan)
    return -100.0 * np.abs(1.0 / (WANTED * period) - 1.0)


TASK = Task(
    actions={"feed_force": FEED},
    observations={"blow_period": PERIOD},
    reward=reward,
    scene={"fidelity": "Rigid"},
    drawn={"rock.stiffness": (8e7, 3e8)},
    step="20 ms",
    steps=150,
)


class Controllers:
    """PI controllers of the feed, one a hammer: actions from -1 to 1."""

    def __init__(self, gains: Array) -> None:
        self.proportional, self.integral = np.exp(gains).T
        self.sum = np.zeros(len(gains))

    def __call__(self, observed: Array) -> Array:
        """The next actions."""
        low, high = PERIOD
        period = low + 0.5 * (observed[:, 0] + 1.0) * (high - low)
        # Nothing is known before the second blow.
        off = np.where(observed[:, 0] > -1.0, WANTED * period - 1.0, 0.0)
        self.sum = np.clip(self.sum + self.integral * off, -1.0, 1.0)
        return np.clip(self.sum + self.proportional * off, -1.0, 1.0)[:, None]


def play(gains: Array, seed: int) -> tuple[Array, pd.DataFrame]:
    """An episode of each controller: mean reward of its second half, and what the first one did."""
    hammers, controllers = HammerVectorEnv(TASK, len(gains)), Controllers(gains)
    observed, _ = hammers.reset(seed=seed)
    rewards, rows = [], []
    for number in range(TASK.steps):
        observed, reward_, _, _, outputs = hammers.step(controllers(observed))
        rewards.append(reward_)
        time_ = (number + 1) * hammers.size
        rows.append(
            {"time": time_, "feed": outputs["feed_force"][0], "period": outputs["blow_period"][0]}
        )
    return np.mean(rewards[TASK.steps // 2 :], axis=0), pd.DataFrame(rows).set_index("time")


def learn(rounds: int = 6, members: int = 48, seed: int = 1) -> Array:
    """Logarithms of the two gains."""
    random = np.random.default_rng(seed)
    middle, width = np.log([1.0, 0.3]), np.array([2.0, 2.0])
    for number in range(rounds):
        gains = middle + width * random.standard_normal((members, 2))
        found, _ = play(gains, seed + number)
        best = gains[np.argsort(found)[-members // 5 :]]
        middle, width = best.mean(axis=0), best.std(axis=0) + 0.02
        print(f"round {number + 1}: off by {-np.median(found):.2f} % in the middle of {members}")
    return middle


def main() -> None:
    """Learns, compares with a feed held constant, and draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("hold.png"))
    parser.add_argument("--rounds", type=int, default=6)
    asked = parser.parse_args()
    gains = learn(asked.rounds)
    many = np.tile(gains, (64, 1))
    held, shown = play(many, 100)
    constant, alone = play(np.full_like(many, -30.0), 100)
    print(f"gains {np.exp(gains).round(3)}: off by {-held.mean():.2f} %, ", end="")
    print(f"by {-constant.mean():.2f} % with a constant feed")
    draw(shown, alone).savefig(asked.out, dpi=160)
    print(f"{speed():.0f} steps of 1 ms a second on one core")


def speed(scene: Hammerlike = TASK.scene, count: int = 64, steps: int = 300) -> float:
    """Steps of 1 ms in a second of one core."""
    task = Task(TASK.actions, TASK.observations, reward, scene, step=1e-3, steps=steps)
    hammers = HammerVectorEnv(task, count, threads=1)
    hammers.reset(seed=1)
    actions = np.zeros((count, 1))
    began = time.process_time()
    for _ in range(steps):
        hammers.step(actions)
    return count * steps / (time.process_time() - began)


def draw(shown: pd.DataFrame, alone: pd.DataFrame) -> Figure:
    """Frequency and feed force over time, with and without the controller."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.5, 4.5), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        for frame, colour, label in ((alone, PISTON, "constant feed"), (shown, BIT, "learned")):
            known = frame[frame["period"] > 0.0]
            upper.plot(known.index, 1.0 / known["period"], color=colour, label=label)
            lower.plot(frame.index, frame["feed"] / 1e3, color=colour)
        upper.axhline(WANTED, color="0.4", lw=0.8, ls="--")
        upper.set_ylabel("frequency (Hz)")
        upper.legend()
        lower.set_ylabel("feed force (kN)")
        lower.set_xlabel("time (s)")
    return figure


if __name__ == "__main__":
    main()
