"""Long-run responses and trends, compared with longer simulations, known lines, and each other."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dth_hammer import VARIABLES, Coupling, Hammer, HammerWarning, simulate, steady, trend
from dth_hammer.errors import DomainError, UnknownNameError
from dth_hammer.scene.band import unseen
from dth_hammer.scene.hammers import numbers_of
from dth_hammer.study.motions import random_starts
from dth_hammer.study.trends import line, sobol
from test_coupling import Valve

RIGID = {"fidelity": "Rigid"}
#: A rock so stiff and viscous that the blows of `overdamped` alternate.
HARD = {
    "rock.stiffness": 5e8,
    "rock.unloading_ratio": 6.0,
    "rock.viscosity": 3e5,
    "rock.energy_barrier": 15.0,
}


def test_blows_that_repeat_have_the_numbers_of_a_long_run_and_no_error() -> None:
    found = steady(RIGID)
    assert (found.kind, found.reached) == ("cycle", True)
    assert repr(found).startswith("cycle, 1 blows\nrate of penetration ")
    assert (found.error == 0.0).all()
    names = ("rop", "blow_period", "blow_penetration", "blow_speed", "blow_energy")
    last = simulate(RIGID, until=6.0, step=6.0, outputs=names).frame.iloc[-1]
    means = ("rop", "period", "advance", "blow_speed", "blow_energy")
    for name, mean in zip(names, means, strict=True):
        # Blows repeat to 1e-9.
        assert found[mean] == pytest.approx(last[name], rel=1e-8), name
    assert found["blow_frequency"] * found["period"] == pytest.approx(1.0, rel=1e-12)


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_blows_that_alternate_are_found_where_a_cycle_of_one_repels() -> None:
    found = steady(HARD, preset="overdamped")
    assert found.kind == "cycle of 2"
    # The mean of two alternating blows is that of a long run.
    long = simulate(HARD, preset="overdamped", until=8.0, outputs=["tip_rate"]).blows.tail(40)
    rate = long["blow_penetration"].sum() / long["blow_period"].sum()
    # They are simulated until they repeat to 1e-9: a transient that shrinks by a hundredth from one
    # pair of blows to the next is then still 100 times that.
    assert found["tip_rate"] == pytest.approx(rate, rel=1e-7)


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_a_mean_lies_within_its_error_of_a_longer_one() -> None:
    thrown = {"feed_force": 0.0}
    short, long = (steady(thrown, preset="overdamped", error=error) for error in (0.02, 0.004))
    assert short.kind == long.kind == "irregular"
    assert long.error["rop"] <= 0.004 * long["rop"]
    both = np.hypot(short.error["rop"], long.error["rop"])
    # Three standard errors: exceeded once in 370 draws.
    assert abs(short["rop"] - long["rop"]) < 3.0 * both
    with pytest.warns(HammerWarning, match=r"not reached after \d+ blows"):
        few = steady(thrown, preset="overdamped", error=1e-5, blows=100)
    assert not few.reached
    assert few.in_words()[0] == f"irregular, {few.blows} blows, error not reached"


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_without_an_error_a_rate_is_as_exact_as_its_range_lets_see() -> None:
    factors = (1.55, 1.05)
    # An error of twice this beside the range moves an end by half a unit of two digits, up to 99.
    for wide in np.log(factors):
        moved = np.hypot(wide, 2.0 * unseen(np.exp(wide))) - wide
        assert moved == pytest.approx(0.005, rel=1e-9)
    # For a rate known to 5 % this is 1.1 %, for one known to 55 % three times as much.
    thrown = [{"feed_force": 0.0, "rock.specific_energy_factor": factor} for factor in factors]
    vague, known = (steady(given, preset="overdamped") for given in thrown)
    assert vague.blows < known.blows
    for found, factor in zip((vague, known), factors, strict=True):
        assert found.error["rop"] <= unseen(factor) * found["rop"]


#: Rigid bodies on viscous rock with two stable motions.
APART = {
    **RIGID,
    "rock.viscosity": 1.7e5,
    "rock.energy_barrier": 4.0,
    "bit.length": 0.1566,
    "feed_force": 11260.0,
    "rock.stiffness": 9.3e7,
    "rock.unloading_ratio": 5.43,
}


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_several_motions_are_told_with_their_shares_and_are_those_of_simulations() -> None:
    with pytest.warns(HammerWarning, match=r"depends on its start: \d+ % cycle at 52\.59 mm/s"):
        found = steady(APART, starts=8)
    motions = found.motions
    assert motions is not None
    assert len(motions) == 2
    assert motions["share"].sum() == 1.0
    # The shares must be those of the same starts, each simulated for a long time.
    given = numbers_of(APART, None)
    rates = []
    for start in [given, *random_starts(given, found["blow_speed"], 7, 1)]:
        blows = simulate(start, until=8.0, outputs=["tip_rate"]).blows.tail(40)
        rates.append(blows["blow_penetration"].sum() / blows["blow_period"].sum())
    for motion in motions.to_dict("records"):
        count = sum(abs(rate / motion["tip_rate"] - 1.0) < 1e-6 for rate in rates)
        assert count == motion["starts"] == round(8 * motion["share"])
    # The first result is that of the hammer's own start.
    assert found["tip_rate"] == motions["tip_rate"][0]
    assert found["tip_rate"] == pytest.approx(rates[0], rel=1e-6)


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_one_motion_from_every_start_is_one_row_and_starts_need_a_hammer_alone() -> None:
    motions = steady(RIGID, starts=4).motions
    assert motions is not None
    assert motions[["kind", "share"]].to_numpy().tolist() == [["cycle", 1.0]]
    assert steady(RIGID).motions is None
    with pytest.raises(DomainError, match="without inputs, control or partner"):
        steady(RIGID, starts=2, control=lambda hammer: None)
    with pytest.raises(DomainError, match="starts = 0"):
        steady(RIGID, starts=0)


COARSE = {"piston.elements": 6, "bit.elements": 6}
SCENES: dict[str, tuple[str | None, dict[str, float | str]]] = {
    "rigid": (None, RIGID),
    "elastic": (None, {}),
    "weak feed": (None, RIGID | {"feed_force": 1e3}),
    "soft rock": (None, COARSE | {"rock.stiffness": 4e7}),
    "two blows": ("overdamped", HARD),
    "irregular": ("overdamped", {"feed_force": 0.0}),
    "irregular, rigid": (None, RIGID | {"feed_force": 20.0}),
    "casing": (None, RIGID | {"casing.mass": 40.0}),
    "casing, elastic": (None, COARSE | {"casing.mass": 40.0}),
    "rods": (None, {"piston.elements": 6, "bit.elements": 48, "drill.rods": 1}),
    "air": (None, RIGID | {"drive.source": "Air"}),
    "air, 4 inch": ("air_4_inch", {}),
}


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
@pytest.mark.filterwarnings("ignore:The bit goes in")
@pytest.mark.parametrize("scene", SCENES)
def test_every_road_to_the_means_leads_to_the_engine_s(scene: str) -> None:
    preset, given = SCENES[scene]
    feed = numbers_of(given, preset).get("feed_force", VARIABLES["feed_force"].start or 0.0)
    known = steady(given, preset=preset, error=0.05)
    roads = (
        steady(given, preset=preset, error=0.05, control=lambda hammer: None),
        steady(given, preset=preset, error=0.05, inputs={"feed_force": lambda time: feed}),
        steady(given, preset=preset, error=0.05, partner=lambda hammer: hammer, step=3e-3),
    )
    for found in roads:
        assert found.kind == known.kind
        off = (found.mean - known.mean).abs()
        if known.repeats:
            assert (off <= 1e-9 * known.mean.abs()).all(), off / known.mean
        else:
            # The errors of one simulation and of four: one draw in 16,000 exceeds four of them.
            assert (off <= 4.0 * np.hypot(found.error, known.error)).all(), off / known.error
    energy = [found.specific_energy("11 m/h") for found in (known, *roads)]
    assert np.allclose(energy, energy[0], rtol=1e-9 if known.repeats else 0.5)


def test_a_controller_that_stalls_the_hammer_is_told_and_a_step_needs_an_act() -> None:
    def control(hammer: Hammer) -> None:
        if hammer.time > 0.5:
            hammer.set(drive_force=1800.0)

    pressed = RIGID | {"drive.source": "Force", "drive_force": 1800.0}
    assert steady(pressed, control=control).kind == "stalled"
    with pytest.raises(DomainError, match="step"):
        steady(RIGID, step=1e-3)


def test_a_relay_outside_has_the_means_of_the_relay_inside() -> None:
    force, stroke = (VARIABLES[f"drive.{name}"].start or 0.0 for name in ("amplitude", "stroke"))
    coupled: list[Coupling] = []

    def partner(hammer: Hammer) -> Coupling:
        hammer.stop_at([-stroke, 0.0])
        coupled.append(Coupling(hammer, Valve(stroke, -force), 5e-3))
        return coupled[-1]

    own = RIGID | {"drive.source": "Force", "drive_force": -force}
    found, known = steady(own, partner=partner, step=5e-3), steady(RIGID)
    assert found.kind == known.kind == "cycle"
    # The valve switches at its position to rounding, and blows repeat to 1e-9.
    assert np.allclose(found.mean, known.mean, rtol=1e-7)
    assert coupled[0].hammer.closed


def test_a_line_is_fitted_with_the_errors_that_its_scatter_makes() -> None:
    noise = np.random.default_rng(5)
    logs = sobol(2, 32, 1) * 0.1
    off = []
    for _ in range(200):
        values = 7.0 * np.exp(0.5 * logs[:, 0] - 2.0 * logs[:, 1] + 0.01 * noise.normal(size=32))
        fit = line(logs, values)
        off.append((fit.slopes - [0.5, -2.0]) / np.sqrt(np.diag(fit.covariance)[1:]))
        assert fit.value == pytest.approx(7.0, rel=0.01)
    # The root mean square of 400 standard numbers is 1 within 3 / sqrt(800).
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(1.0, abs=0.12)


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_the_trend_over_the_rock_is_the_published_one() -> None:
    # -0.455 over 10 %, with a roughness of 0.19 %, by 598 pieces.
    over = {"rock.stiffness": 0.1}
    found = trend(None, over, ["tip_rate", "period"], points=32, preset="overdamped")
    row = found.table.loc[("tip_rate", "rock.stiffness")]
    assert abs(row["elasticity"] + 0.455) < 3.0 * row["error"]
    assert 0.001 < found.roughness["tip_rate"] < 0.003
    assert len(found.plot().axes) == 2
    assert "roughness" in found._repr_html_()


def test_wrong_names_and_widths_are_told() -> None:
    with pytest.raises(UnknownNameError, match="rop"):
        trend(None, {"rock.stiffness": 0.1}, ["ropp"])
    with pytest.raises(DomainError, match="width of gravity"):
        trend(None, {"gravity": 2.0}, ["rop"])
    with pytest.raises(DomainError, match="give widths by parameter"):
        trend(None, ["rock.stiffness"])  # type: ignore[arg-type]
    with pytest.raises(DomainError, match="error"):
        steady(error=0.0)


def test_the_commands_tell_means_and_trends(cli: Callable[..., str], tmp_path: Path) -> None:
    hammer = ["--set", "fidelity=Rigid", "--quiet"]
    message = cli("steady", *hammer, "--units", "rop=mm/s")
    assert message.startswith("cycle, 1 blows")
    assert "mm/s" in message
    drawn = ["--outputs", "rop", "--plot", tmp_path / "tornado.png"]
    assert "feed_force" in cli("trend", *hammer, "--over", "feed_force=0.1", *drawn)
