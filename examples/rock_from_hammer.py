"""The rock from sensors at each blow: an ensemble Kalman filter over restored states.

    python examples/rock_from_hammer.py --out rock.png    # layers that change under way
    python examples/rock_from_hammer.py --sensors         # what each sensor tells

An ensemble of hammers, each with its own rock, drills in parallel with the measured one. After a
blow the filter corrects the rocks `x`, from the measured signals `z` and those of each hammer, `y`,
with noise of covariance `R`:

    x += C_xy (C_yy + R)^-1 (z + noise - y)

(Evensen 2003, stochastic update). Then each hammer returns to its state before the blow and repeats
it with the corrected rock, so that state and rock agree.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd
from dth_hammer import VARIABLES, Hammer, Snapshot
from dth_hammer.figures import BIT, ROCK
from dth_hammer.figures.style import styled
from dth_hammer.scene.variables import Array, Value
from matplotlib.figure import Figure

T = TypeVar("T")
#: Settings for a quick example.
HAMMER: Mapping[str, Value] = {
    "piston.elements": 4,
    "bit.elements": 4,
    "contact.stiffness": 2e10,
}
#: Parameters to estimate, and the median of each before the first blow.
ROCK_NAMES = ("rock.stiffness", "rock.unloading_ratio")
BELIEVED = {"rock.stiffness": 2e8, "rock.unloading_ratio": 6.0}
#: Standard deviations of their logarithms: before the first blow, and of the change at a blow.
WIDTH, DRIFT = 0.5, 0.04
#: Standard deviations of chi-square beyond which the rock has changed.
SURPRISE = 6.0
#: Rocks over depth (m).
LAYERS: Sequence[tuple[float, Mapping[str, float]]] = (
    (0.0, {"rock.stiffness": 1.2e8, "rock.unloading_ratio": 4.0}),
    (0.020, {"rock.stiffness": 3.0e8, "rock.unloading_ratio": 4.0}),
    (0.035, {"rock.stiffness": 3.0e8, "rock.unloading_ratio": 9.0}),
)
#: Instants after an impact at which motion and strain are sampled, s.
TIMES = np.linspace(5e-5, 6e-4, 8)
#: Position at which the rebounding piston's speed is read, m; longest wait, s.
APART, LONGEST = -2e-3, 0.5


@dataclass(frozen=True)
class Sensor:
    """A quantity that is measured at a blow, and the standard deviation of its noise."""

    unit: str
    noise: float
    count: int = 1


SENSORS = {
    "impact speed": Sensor("m/s", 0.05),
    "rebound speed": Sensor("m/s", 0.05),
    "bit velocity": Sensor("m/s", 0.05, len(TIMES)),
    "strain gauge": Sensor("strain", 5e-6, len(TIMES)),
}


def strike(hammer: Hammer) -> dict[str, Array]:
    """Steps from an impact to the next, and returns the signals of noiseless sensors."""
    modulus = VARIABLES["material.youngs_modulus"].start
    hammer.stop_at()
    names = ["bit_velocity", "bit_stress[2]"]
    samples, _ = hammer.run(hammer.time + TIMES, names, {})
    hammer.stop_at([APART])
    _until(hammer, lambda: hammer["relative_position"] <= APART)
    rebound = hammer["piston_velocity"]
    hammer.stop_at(blows=True)
    count = hammer["blow_count"]
    _until(hammer, lambda: hammer["blow_count"] > count)
    return {
        "impact speed": np.array([hammer["blow_speed"]]),
        "rebound speed": np.array([rebound]),
        "bit velocity": samples[:, 0],
        "strain gauge": samples[:, 1] / modulus,
    }


def _until(hammer: Hammer, there: Callable[[], bool]) -> None:
    end = hammer.time + LONGEST
    while not there():
        if hammer.time >= end:
            raise SystemExit(f"a hammer with {hammer.get(ROCK_NAMES)} strikes no more")
        hammer.advance(end)


@dataclass
class Filter:
    """Hammers, each with its own rock, which is corrected blow by blow."""

    sensors: Sequence[str]
    members: int = 40
    seed: int = 1
    hammers: list[Hammer] = field(init=False)
    #: Logarithms of the rocks, one row per hammer.
    rocks: Array = field(init=False)

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)
        self.rocks = self._believed()
        self.hammers = [Hammer(HAMMER | rock_of(logs), quiet=True) for logs in self.rocks]
        chosen = [SENSORS[name] for name in self.sensors]
        self.noise = np.concatenate([np.full(sensor.count, sensor.noise) for sensor in chosen])
        self._each(first)

    def _each(self, work: Callable[[Hammer], T]) -> list[T]:
        with ThreadPoolExecutor() as crew:
            return [*crew.map(work, self.hammers)]

    def _strike(self) -> Array:
        for hammer, logs in zip(self.hammers, self.rocks, strict=True):
            hammer.set(rock_of(logs))
        return np.array([joined(measured, self.sensors) for measured in self._each(strike)])

    def correct(self, measured: Array) -> None:
        """Corrects the rocks by the measured signals of a blow."""
        before = [hammer.save() for hammer in self.hammers]
        self.rocks += DRIFT * self.random.standard_normal(self.rocks.shape)
        shown, covariance = self._forecast()
        off = measured - shown.mean(axis=0)
        if off @ np.linalg.solve(covariance, off) > len(off) + SURPRISE * np.sqrt(2 * len(off)):
            # None of these rocks explains the signals: the rock has changed, and may again be any.
            self.rocks = self._believed()
            self._restore(before)
            shown, covariance = self._forecast()
        mixed = (shown - shown.mean(axis=0)).T @ (self.rocks - self.rocks.mean(axis=0))
        noisy = measured + self.noise * self.random.standard_normal(shown.shape)
        self.rocks += (noisy - shown) @ np.linalg.solve(covariance, mixed / (self.members - 1))
        self._restore(before)
        self._strike()

    def _forecast(self) -> tuple[Array, Array]:
        """Returns each hammer's signals at a blow, and their covariance with noise."""
        signals = self._strike()
        return signals, np.atleast_2d(np.cov(signals.T)) + np.diag(self.noise**2)

    def _restore(self, states: Sequence[Snapshot]) -> None:
        for hammer, state in zip(self.hammers, states, strict=True):
            hammer.restore(state)

    def _believed(self) -> Array:
        """Draws rocks from the distribution before the first blow."""
        middle = np.log([BELIEVED[name] for name in ROCK_NAMES])
        return middle + WIDTH * self.random.standard_normal((self.members, len(middle)))


def rock_of(logs: Array) -> dict[str, float]:
    """Returns the parameters of a rock; the ratio is above 1."""
    values = dict(zip(ROCK_NAMES, map(float, np.exp(logs)), strict=True))
    return values | {"rock.unloading_ratio": max(values["rock.unloading_ratio"], 1.05)}


def first(hammer: Hammer) -> None:
    """Advances a hammer to its first impact."""
    hammer.stop_at(blows=True)
    _until(hammer, lambda: hammer["blow_count"] > 0)


def joined(measured: Mapping[str, Array], sensors: Sequence[str]) -> Array:
    """Returns the signals of some sensors as a row."""
    return np.concatenate([measured[name] for name in sensors])


def run(
    blows: int = 60,
    sensors: Sequence[str] = ("impact speed", "rebound speed", "bit velocity"),
    layers: Sequence[tuple[float, Mapping[str, float]]] = LAYERS,
    seed: int = 1,
    members: int = 40,
) -> pd.DataFrame:
    """Returns a row per blow: depth, hidden rock, estimate, standard deviation of logarithms."""
    noise = np.random.default_rng([seed, 7])
    filtered = Filter(sensors, members, seed)
    rows = []
    with Hammer(HAMMER | layers[0][1], quiet=True) as field_:
        first(field_)
        for number in range(blows):
            depth = field_["tip_depth"]
            hidden = [rock for top, rock in layers if depth >= top][-1]
            field_.set(hidden)
            signal = joined(strike(field_), sensors)
            began = time.process_time()
            filtered.correct(signal + filtered.noise * noise.standard_normal(len(signal)))
            row = {"blow": number + 1, "depth": depth, "seconds": time.process_time() - began}
            for name, logs in zip(ROCK_NAMES, filtered.rocks.T, strict=True):
                row |= {name: hidden[name], f"{name} found": np.exp(logs.mean())}
                row |= {f"{name} band": logs.std(ddof=1)}
            rows.append(row)
    return pd.DataFrame(rows).set_index("blow")


def compared(blows: int = 12, seeds: Sequence[int] = (1, 2, 3), members: int = 24) -> pd.DataFrame:
    """Returns how well each sensor determines one rock after so many blows.

    The columns are the standard deviation of the ensemble's logarithms, and the error of its mean
    (root mean square over seeds). Before the first blow the former is `WIDTH`.
    """
    ways = [(name,) for name in SENSORS] + [("impact speed", "rebound speed"), tuple(SENSORS)]
    rows = []
    for sensors in ways:
        ends = [run(blows, sensors, LAYERS[:1], seed, members).iloc[-1] for seed in seeds]
        row: dict[str, object] = {"sensors": " and ".join(sensors) if len(sensors) < 3 else "all"}
        for name in ROCK_NAMES:
            off = [np.log(end[f"{name} found"] / end[name]) for end in ends]
            row |= {f"{name} band": np.mean([end[f"{name} band"] for end in ends])}
            row |= {f"{name} off": np.sqrt(np.mean(np.square(off)))}
        rows.append(row)
    return pd.DataFrame(rows).set_index("sensors")


def draw(frame: pd.DataFrame) -> Figure:
    """Draws hidden rock, estimate and two standard deviations over blows."""
    with styled(7.5, 5.0) as figure:
        panels = figure.subplots(2, 1, sharex=True)
        for axes, name, label, scale in zip(
            panels,
            ROCK_NAMES,
            ("rock stiffness (MN/m)", "unloading ratio"),
            (1e-6, 1.0),
            strict=True,
        ):
            found, band = scale * frame[f"{name} found"], np.exp(2.0 * frame[f"{name} band"])
            axes.fill_between(frame.index, found / band, found * band, color=BIT, alpha=0.25, lw=0)
            axes.plot(frame.index, found, color=BIT, label="estimate, two standard deviations")
            axes.step(frame.index, scale * frame[name], color=ROCK, where="mid", label="hidden")
            axes.set_ylabel(label)
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
        panels[1].set_xlabel("blow")
    return figure


def main() -> None:
    """Runs the filter, prints and draws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("rock.png"))
    parser.add_argument("--blows", type=int, default=60)
    parser.add_argument("--sensors", action="store_true", help="compare sensors instead")
    asked = parser.parse_args()
    if asked.sensors:
        print(compared().map("{:.1%}".format).to_string())
        return
    frame = run(asked.blows)
    draw(frame).savefig(asked.out, dpi=160)
    inside = [
        (np.abs(np.log(frame[f"{name} found"] / frame[name])) < 2.0 * frame[f"{name} band"]).mean()
        for name in ROCK_NAMES
    ]
    print(
        f"{1e3 * frame['seconds'].median():.0f} ms of a core a blow; hidden rock within two ",
        end="",
    )
    print(f"standard deviations in {inside[0]:.0%} and {inside[1]:.0%} of the blows")


if __name__ == "__main__":
    main()
