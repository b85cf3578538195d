"""Every preset, and every drive, through `steady`, `trend`, `calibrate` and `optimise`: a row each.

    python python/tests/study_of_presets.py

A rock that is a tenth harder than the preset's is found again from three means with 1 % of error;
the feed is chosen for the largest rate within a fifth of the preset's.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping

from dth_hammer import HammerWarning, calibrate, optimise, steady, trend
from dth_hammer.scene.variables import PRESETS, numbers, whole

Values = Mapping[str, float | str]
#: Drives that no preset has.
DRIVES: dict[str, Values] = {
    "air": {"drive.source": "Air"},
}
MEASURED = ("rop", "blow_frequency", "blow_energy")


def row(name: str, preset: str, parameters: Values) -> str:
    """What each says of a hammer."""
    middle = whole(numbers(preset, dict(parameters)))
    response = steady(parameters, preset=preset)
    slope = trend(parameters, {"rock.stiffness": 0.05}, ("rop",), preset=preset).table.iloc[0]
    harder = {**parameters, "rock.stiffness": 1.1 * middle["rock.stiffness"]}
    means = steady(harder, preset=preset, error=0.005).mean
    measured = {key: (means[key], 0.01 * means[key]) for key in MEASURED}
    found = calibrate(parameters, measured, ["rock.stiffness"], preset=preset)
    [off] = (found.parameters / harder["rock.stiffness"] - 1.0).to_numpy()
    feed = middle["feed_force"] or 1e3
    best = optimise(parameters, "rop", {"feed_force": (0.8 * feed, 1.2 * feed)}, preset=preset)
    return (
        f"| {name} | {response.kind} | {1e3 * response.mean['rop']:.2f} | "
        f"{slope.iloc[0]:.2f} ± {slope.iloc[1]:.2f} | {off:+.1%} | {1e3 * best.value:.2f} |"
    )


def main() -> None:
    """Prints the table."""
    print("| hammer | kind | rate (mm/s) | trend over stiffness | stiffness found | best rate |")
    print("|---|---|---|---|---|---|")
    hammers: list[tuple[str, str, Values]] = [(name, name, {}) for name in PRESETS]
    hammers += [(name, "reference", parameters) for name, parameters in DRIVES.items()]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HammerWarning)
        for name, preset, parameters in hammers:
            print(row(name, preset, parameters), flush=True)


if __name__ == "__main__":
    main()
