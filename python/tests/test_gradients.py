"""Derivatives of runs, and what they are good for."""

from collections.abc import Sequence
from typing import Any

import pytest
from dth_hammer import DomainError, HammerWarning, Run, UnknownNameError, simulate

#: Small meshes: what is shown here does not depend on them.
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
            # Rounding of 1e-12 of the output over the step; a larger step of a section is bent.
            bound = 1e-12 * abs(middle[output].iloc[-1]) / step + 1e-4 * abs(ours)
            assert abs(ours - theirs) <= bound, (name, output)


def test_what_has_no_derivative_says_so() -> None:
    with pytest.raises(UnknownNameError, match=r"rock\.stiffness"):
        simulate(until=0.01, gradient=["rock.stifness"])
    with pytest.raises(DomainError, match=r"no derivative .*piston\.length"):
        simulate({"piston.segments": 2}, until=1e-3, gradient=["piston.length"])
    with pytest.raises(DomainError, match=r"no derivative .*piston\.segment\[3\]\.area"):
        simulate({**SHAPE, "piston.segments": 2}, 0.01, gradient=["piston.segment[3].area"])


def test_derivatives_of_a_motion_that_does_not_settle_are_not_told() -> None:
    by, outputs = ["rock.stiffness"], ["tip_depth", "rop"]
    with pytest.warns(HammerWarning, match="does not settle"):
        run = simulate({"feed_force": 0.0}, 2.0, step=2.0, gradient=by, outputs=outputs)
    assert run.gradient().iloc[-1].isna().all()
    # Earlier they are there, and hold for less than a millionth.
    with pytest.warns(HammerWarning, match="hold for .*e-08 of it at most"):
        simulate({"feed_force": 0.0}, 0.5, step=0.5, gradient=by, outputs=outputs)
