"""Derivatives: of runs, of cycles, and what they are good for."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    Cycles,
    DomainError,
    HammerWarning,
    Record,
    RefusedError,
    Run,
    UnknownNameError,
    simulate,
    stationary,
)
from dth_hammer.atlas import atlas, figure
from dth_hammer.records import simulated

#: Small meshes: what is shown here does not depend on them.
SMALL = {"piston.elements": 4, "bit.elements": 4, "contact.stiffness": 2e10}


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_the_overdamped_cycle_has_the_derivatives_that_were_measured() -> None:
    cycle = stationary(preset="overdamped", gradient=["rock.stiffness", "feed_force"])
    shares = cycle.elasticities
    # Central differences of settled simulations, to the digits that they gave.
    assert shares.loc["period", "rock.stiffness"] == pytest.approx(-0.071182, abs=5e-7)
    assert shares.loc["advance", "feed_force"] == pytest.approx(0.0947321, abs=5e-8)
    assert cycle.period == pytest.approx(45.389e-3, abs=1e-6)
    assert cycle.stable
    assert abs(cycle.multipliers[0]) == pytest.approx(0.199, abs=5e-4)


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
    with pytest.raises(UnknownNameError):
        stationary(gradient=["piston.elements"])
    with pytest.raises(DomainError, match=r"no derivative .*piston\.length"):
        simulate({"piston.segments": 2}, until=0.01, gradient=["piston.length"])
    with pytest.raises(RefusedError, match=r"drive\.source"):
        stationary({"drive.source": "Force"})


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


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_the_atlas_finds_what_simulations_settle_to_and_what_they_leave() -> None:
    values = np.linspace(0.17, 0.2, 4)
    viscous = {"fidelity": "Rigid", "rock.viscosity": 1.7e5, "rock.energy_barrier": 4.0}
    table = atlas("bit.length", values, viscous, returns=1)
    cycles = table[table["kind"] == "cycle"]
    # The cycle of a short bit flips on the way, and is followed on.
    flipped = cycles[~cycles["stable"].astype(bool)]
    assert len(flipped)
    assert (flipped["real"] < -1.0).all()
    simulated = table[(table["kind"] == "simulated") & (table["repeats"] == 1)]
    assert len(simulated) == len(values)
    for _, run in simulated.iterrows():
        near = cycles.iloc[(cycles["value"] - run["value"]).abs().argsort()[:6]]
        # Between neighbours the period changes by what they differ by.
        off = np.abs(near["period"] - run["period"]).min()
        assert off < 2e-3 * run["period"]
    assert len(figure(table).axes) == 3


def test_derivatives_of_a_motion_that_does_not_settle_are_not_told() -> None:
    by, outputs = ["rock.stiffness"], ["tip_depth", "rop"]
    with pytest.warns(HammerWarning, match="does not settle"):
        run = simulate({"feed_force": 0.0}, 2.0, step=2.0, gradient=by, outputs=outputs)
    assert run.gradient().iloc[-1].isna().all()
    # Earlier they are there, and hold for less than a millionth.
    with pytest.warns(HammerWarning, match="hold for .*e-08 of it at most"):
        simulate({"feed_force": 0.0}, 0.5, step=0.5, gradient=by, outputs=outputs)


def test_a_branch_passes_the_cycle_that_is_found_alone() -> None:
    cycles = Cycles({"fidelity": "Rigid"})
    cycles.find()
    points = [p for _, p in zip(range(4), cycles.branch("rock.stiffness", -0.05), strict=False)]
    assert [p.value for p in points] == sorted((p.value for p in points), reverse=True)
    last = points[-1]
    alone = stationary({"fidelity": "Rigid", "rock.stiffness": last.value})
    # Both are solved to 1e-10 of the state.
    assert last.cycle.period == pytest.approx(alone.period, rel=1e-9)
    assert last.cycle.advance == pytest.approx(alone.advance, rel=1e-9)


def test_an_atlas_draws_bands_where_nothing_repeats_and_nothing_where_nothing_strikes() -> None:
    # Without feed the reference never repeats.
    table = atlas("rock.stiffness", [1.1e8, 1.2e8], {"feed_force": 0.0}, returns=1)
    irregular = table[(table["kind"] == "simulated") & (table["repeats"] == 0)]
    assert set(irregular["value"]) == {1.1e8, 1.2e8}
    spread = irregular.groupby("value")["rop"].agg(np.ptp)
    assert (spread > 0.1 * irregular["rop"].mean()).all()
    assert "irregular" in str([text.get_text() for text in figure(table).legends[0].get_texts()])
    still = {"drive.source": "Force", "drive_force": 0.0, "fidelity": "Rigid"}
    none = atlas("feed_force", [4e3, 5e3], still)
    assert none.empty
    assert len(figure(none).axes) == 3


def test_an_atlas_of_nothing_is_refused() -> None:
    with pytest.raises(DomainError, match="ascending"):
        atlas("bit.length", [0.2, 0.1])
    with pytest.raises(DomainError, match="returns"):
        atlas("bit.length", [0.1, 0.2], returns=0)
    with pytest.raises(DomainError, match="all above or all below 0"):
        atlas("gravity", [-1.0, 1.0])
