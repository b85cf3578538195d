"""Derivatives of runs, and what they are good for."""

import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    DomainError,
    HammerWarning,
    Record,
    Run,
    UnknownNameError,
    simulate,
)
from dth_hammer.run.records import simulated

#: Small meshes: what is shown here does not depend on them.
SMALL = {"piston.elements": 4, "bit.elements": 4, "contact.stiffness": 2e10}


def test_a_run_is_differentiated_through_its_blows() -> None:
    by = ["rock.stiffness", "feed_force"]
    names = ["piston_velocity", "tip_depth", "rop", "blow_count"]
    frame = simulate(SMALL, 0.1, gradient=by, outputs=names, step=0.05)
    slopes = frame.gradient()
    assert (slopes["blow_count"].to_numpy() == 0.0).all()
    for name, start in (("rock.stiffness", 1.2e8), ("feed_force", 5e3)):
        step = 1e-7 * start
        low, high = (
            simulate({**SMALL, name: start + way * step}, 0.1, outputs=names, step=0.05)
            for way in (-1.0, 1.0)
        )
        for output in names[:3]:
            ours = slopes[output, name].iloc[-1]
            theirs = (high[output].iloc[-1] - low[output].iloc[-1]) / (2.0 * step)
            # Rounding of 1e-12 of the output over 2e-7 of the parameter.
            bound = 1e-5 * abs(frame[output].iloc[-1]) / start + 1e-4 * abs(ours)
            assert abs(ours - theirs) <= bound, (name, output)


def test_a_section_is_a_parameter_like_any_other() -> None:
    shape = {"piston.segments": 2, "piston.segment[1].area": 3.2e-3, "piston.segment[2].area": 2e-3}
    start = {**SMALL, **shape, "piston.segment[1].length": 0.1, "piston.segment[2].length": 0.07}
    by = [name for name in start if ".segment[" in name]
    names = ["piston_velocity", "blow_energy", "rop"]
    frame = simulate(start, 0.1, gradient=by, outputs=names, step=0.05)
    slopes = frame.gradient()
    for name in by:
        step = 1e-8 * start[name]
        low, high = (
            simulate({**start, name: start[name] + way * step}, 0.1, outputs=names, step=0.05)
            for way in (-1.0, 1.0)
        )
        for output in names:
            ours = slopes[output, name].iloc[-1]
            theirs = (high[output].iloc[-1] - low[output].iloc[-1]) / (2.0 * step)
            # Rounding of 1e-12 of the output over 2e-8 of the parameter; a larger step is bent.
            bound = 1e-4 * abs(frame[output].iloc[-1]) / start[name] + 1e-4 * abs(ours)
            assert abs(ours - theirs) <= bound, (name, output)
    with pytest.raises(DomainError, match=r"no derivative .*piston\.segment\[3\]\.area"):
        simulate(start, until=0.01, gradient=["piston.segment[3].area"])


def test_what_has_no_derivative_says_so() -> None:
    with pytest.raises(UnknownNameError, match=r"rock\.stiffness"):
        simulate(until=0.01, gradient=["rock.stifness"])
    with pytest.raises(DomainError, match=r"no derivative .*piston\.length"):
        simulate({"piston.segments": 2}, until=1e-3, gradient=["piston.length"])


def test_energies_are_differentiated_too() -> None:
    by, names = ["rock.stiffness"], ["energy_drive", "energy_damping", "rock_impulse"]
    slopes = simulate(SMALL, 0.1, gradient=by, outputs=names, step=0.05).gradient()
    step = 12.0
    low, high = (
        simulate({**SMALL, "rock.stiffness": 1.2e8 + way * step}, 0.1, outputs=names, step=0.05)
        for way in (-1.0, 1.0)
    )
    for name in names:
        ours = slopes[name, by[0]].iloc[-1]
        theirs = (high[name].iloc[-1] - low[name].iloc[-1]) / (2.0 * step)
        # Rounding of 1e-12 of the output over 2e-7 of the parameter.
        bound = 1e-5 * abs(high[name].iloc[-1]) / 1.2e8 + 1e-4 * abs(ours)
        assert abs(ours - theirs) <= bound, name


def test_works_of_a_feed_that_varies_are_differentiated_too() -> None:
    by, name, start = "rock.stiffness", "energy_feed", 1.2e8

    def work(stiffness: float) -> Run:
        rising = {"feed_force": lambda t: 5e3 + 1e4 * t}
        changed = {**SMALL, by: stiffness}
        return simulate(changed, 0.06, rising, gradient=[by], outputs=[name], step=0.02)

    ours = work(start).gradient()[name, by].iloc[-1]
    step = 1e-7 * start
    low, high = (work(start + way * step)[name].iloc[-1] for way in (-1.0, 1.0))
    # Rounding of 1e-12 of the output over 2e-7 of the parameter.
    bound = 1e-5 * abs(high) / start + 1e-4 * abs(ours)
    assert abs(ours - (high - low) / (2.0 * step)) <= bound


def pulse(samples: float | np.ndarray, blow: int, error: float) -> Record:
    """The contact force over the first impact of a blow, to be filled or as it was seen."""
    times = np.linspace(2e-6, 1.2e-4, 60)
    return Record("contact_force", pd.Series(samples, index=times), error, blow)


def test_a_sample_has_the_derivative_that_differences_of_records_tend_to() -> None:
    name, start = "rock.stiffness", 1.2e8
    blank = pulse(0.0, 3, 1.0)
    _, slopes = simulated(blank, SMALL, [name])
    step = 1e-6 * start
    low, high = (simulated(blank, {**SMALL, name: start + w * step})[0] for w in (-1.0, 1.0))
    differences = (high - low) / (2.0 * step)
    # Rounding of the instants, 1e-13 s, at 1e10 N/s, and curvature: 1e-4 of the largest.
    assert np.abs(slopes[:, 0] - differences).max() < 1e-3 * np.abs(differences).max()


def test_derivatives_of_a_motion_that_does_not_settle_are_not_told() -> None:
    by, outputs = ["rock.stiffness"], ["tip_depth", "rop"]
    with pytest.warns(HammerWarning, match="does not settle"):
        run = simulate({"feed_force": 0.0}, 2.0, step=2.0, gradient=by, outputs=outputs)
    assert run.gradient().iloc[-1].isna().all()
    # Earlier they are there, and hold for less than a millionth.
    with pytest.warns(HammerWarning, match="hold for .*e-08 of it at most"):
        simulate({"feed_force": 0.0}, 0.5, step=0.5, gradient=by, outputs=outputs)
