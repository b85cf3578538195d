"""Derivatives of runs, and their uses."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from dth_hammer import DomainError, HammerWarning, Run, UnknownNameError, simulate

#: Small meshes, because these results do not depend on the mesh.
SMALL = {"piston.elements": 4, "bit.elements": 4, "contact.stiffness": 2e10}


#: A piston of two sections.
SHAPE = {
    **{"piston.segment[1].area": 3.2e-3, "piston.segment[2].area": 2e-3},
    **{"piston.segment[1].length": 0.1, "piston.segment[2].length": 0.07},
}
RISING = {"feed_force": lambda t: 5e3 + 1e4 * t}
ROCK = ["rock.stiffness"]


@pytest.mark.parametrize(
    ("changed", "inputs", "by", "outputs", "part"),
    [
        ({}, {}, [*ROCK, "feed_force"], ["piston_velocity", "tip_depth", "rop"], 1e-7),
        ({}, {}, ROCK, ["energy_drive", "energy_damping", "rock_impulse"], 1e-7),
        ({}, RISING, ROCK, ["energy_feed"], 1e-7),
        (
            SHAPE | {"piston.segments": 2},
            {},
            [*SHAPE],
            ["piston_velocity", "blow_energy", "rop"],
            1e-8,
        ),
    ],
)
def test_a_run_is_differentiated_through_its_blows(
    changed: dict[str, float],
    inputs: dict[str, Any],
    by: list[str],
    outputs: list[str],
    part: float,
) -> None:
    def run(over: dict[str, float], gradient: Sequence[str] = ()) -> Run:
        scene, read = {**SMALL, **changed, **over}, [*outputs, "blow_count"]
        return simulate(scene, 0.1, inputs, gradient=gradient, outputs=read, step=0.05)

    middle = run({}, by)
    slopes = middle.gradient()
    assert (slopes["blow_count"].to_numpy() == 0.0).all()
    for name, start in middle.by.items():
        step = part * start
        low, high = (run({name: start + way * step}) for way in (-1.0, 1.0))
        for output in outputs:
            ours = slopes[output, name].iloc[-1]
            theirs = (high[output].iloc[-1] - low[output].iloc[-1]) / (2.0 * step)
            # Rounding of 1e-12 of the output over the step; the curvature over a section's larger
            # step.
            bound = 1e-12 * abs(middle[output].iloc[-1]) / step + 1e-4 * abs(ours)
            assert abs(ours - theirs) <= bound, (name, output)


def test_what_has_no_derivative_says_so() -> None:
    with pytest.raises(UnknownNameError, match=r"rock\.stiffness"):
        simulate(until=0.01, gradient=["rock.stifness"])
    with pytest.raises(DomainError, match=r"no derivative .*piston\.length"):
        simulate({"piston.segments": 2}, until=1e-3, gradient=["piston.length"])
    with pytest.raises(DomainError, match=r"no derivative .*piston\.segment\[3\]\.area"):
        simulate({**SHAPE, "piston.segments": 2}, 0.01, gradient=["piston.segment[3].area"])


@pytest.mark.filterwarnings("ignore:The bit goes in")
def test_derivatives_of_a_motion_that_does_not_settle_are_not_told() -> None:
    by, outputs = ["rock.stiffness"], ["tip_depth", "rop"]
    with pytest.warns(HammerWarning, match="does not settle"):
        run = simulate({"feed_force": 0.0}, 2.0, step=2.0, gradient=by, outputs=outputs)
    assert run.gradient().iloc[-1].isna().all()
    # Earlier derivatives exist, but hold for less than a millionth of the parameter.
    with pytest.warns(HammerWarning, match="hold for .*e-08 of it at most"):
        simulate({"feed_force": 0.0}, 0.5, step=0.5, gradient=by, outputs=outputs)


#: Hammers driven by air or with a valve, with and without a casing.
DRAWN: list[tuple[str, dict[str, Any], list[str]]] = [
    ("air_4_inch", {}, ["rock.stiffness", "supply_pressure"]),
    ("air_6_inch", {"casing.mass": 0.0}, ["rock.stiffness", "air.supply_area"]),
    ("air_3_5_inch", {"fidelity": "Rigid"}, ["rock.stiffness", "feed_force"]),
    ("reference", SMALL | {"casing.mass": 60.0}, ["rock.stiffness", "feed_force"]),
    ("reference", SMALL, ["rock.stiffness", "drive.stroke"]),
]
READ = ["tip_depth", "blow_energy", "energy_drive", "rop"]


@pytest.mark.filterwarnings("ignore::dth_hammer.HammerWarning")
def test_the_errors_that_are_told_hold_under_air_and_in_a_casing() -> None:
    held, random = [], np.random.default_rng(71)
    for preset, over, by in DRAWN:
        for _ in range(2):
            # Each draw is another hammer.
            scene = over | {"rock.unloading_ratio": float(random.uniform(4.0, 10.0))}
            run = simulate(
                scene, 0.09, preset=preset, gradient=by, outputs=[*READ, "blow_count"], step=0.03
            )
            assert run["blow_count"].iloc[-1] >= 2.0, preset
            slopes, errors = (run.gradient(errors=told).iloc[-1] for told in (False, True))
            fine = scene | {"air.error": 1e-11} if preset.startswith("air") else scene
            for name, value in run.by.items():
                held += _held(preset, fine, name, value, (slopes, errors))
    assert len(held) > 50
    # An error is an estimate, which must hold in 95 of 100 cases.
    assert np.mean(held) >= 0.95, held


def _held(
    preset: str, scene: dict[str, Any], name: str, value: float, told: tuple[Any, Any]
) -> list[bool]:
    """Whether derivatives by one number are within their errors, of those that are known better.

    What they are is known from differences of the fourth order, with two steps: from each other
    these tell their own error.
    """

    def at(part: float) -> Any:
        changed = scene | {name: value * (1.0 + part)}
        run = simulate(changed, 0.09, preset=preset, outputs=[*READ, "blow_count"], step=0.09)
        return run.frame[READ].iloc[-1]

    def slope(part: float) -> Any:
        far, near = (at(k * part) - at(-k * part) for k in (2, 1))
        return (8.0 * near - far) / (12.0 * part * value)

    finer, coarser = slope(4e-6), slope(8e-6)
    slopes, errors = (part.xs(name, level="by")[READ] for part in told)
    known = (finer - coarser).abs()
    # If the events change between the steps, the differences say nothing.
    sharp = known < 1e-4 * finer.abs() + errors
    return [*((slopes - finer).abs() <= errors + known)[sharp]]
