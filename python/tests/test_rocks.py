"""Rocks by name, damping by ratio, rate from specific energy, and the summary of a run."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    PRESETS,
    ROCKS,
    VARIABLES,
    DomainError,
    DthHammerError,
    HammerWarning,
    Run,
    Scene,
    rock,
    simulate,
    steady,
)
from dth_hammer.simulation.summary import displayed

HOLE = {"hole.diameter": 0.09, "rock.specific_energy": 399e6}
AREA = math.pi / 4 * 0.09**2


def test_a_rock_under_a_bit_has_the_stiffness_of_its_inserts() -> None:
    found = rock("Kuru granite", inserts=8, insert_radius="7 mm", hole="90 mm")
    hardness = ROCKS["kuru granite"]["hardness"].value
    assert found["rock.stiffness"] == pytest.approx(2 * math.pi * 7e-3 * hardness * 8)
    assert found["hole.diameter"] == 0.09
    assert found["rock.specific_energy"] == ROCKS["kuru granite"]["specific_energy"].value
    # Numbers that are not measured are listed as assumed.
    assert any("Teale 1965" in text for text in found.assumed)
    assert any("energy barrier" in text for text in found.assumed)
    known = rock("kuru granite", inserts=8, insert_radius=7e-3, specific_energy=3e8)
    assert known["rock.specific_energy"] == 3e8
    assert not any("pecific energy" in text for text in known.assumed)
    assert simulate(found, until=0.1)["blow_count"].iloc[-1] > 0


def test_a_name_and_a_hole_are_enough_for_a_rock() -> None:
    found = rock("granite", hole="90 mm", rebound=0.25)
    plain = rock("kuru granite", inserts=8, insert_radius="7 mm", hole="90 mm")
    assert {**found, "rock.unloading_ratio": plain["rock.unloading_ratio"]} == dict(plain)
    # The rock returns a share of the work: loading stiffness over unloading stiffness.
    assert found["rock.unloading_ratio"] == 4.0
    assert any("8 inserts of 7 mm" in text for text in found.assumed)
    # Drillers know that granite is the harder rock.
    assert any("drillers know to be the easier rock" in text for text in found.assumed)
    for given, message in (
        ({}, "give hole, or inserts"),
        ({"hole": "9 m"}, "hole = 9"),
        ({"hole": 0.1, "rebound": 1.2}, "rebound = 1.2"),
    ):
        with pytest.raises(DthHammerError, match=message):
            rock("granite", **given)


def test_a_rock_carries_the_range_of_its_rate() -> None:
    # Teale: the energy is the strength, within a factor of 1.6. Names and classes also have a range
    # of strengths.
    for name, middle, factor in (
        ("180 MPa", 180e6, 1.6),
        ("26107 psi", 180e6, 1.6),
        ("R5", math.sqrt(100e6 * 250e6), math.exp(math.hypot(math.log(2.5) / 2, math.log(1.6)))),
    ):
        found = rock(name, hole="90 mm")
        assert found["rock.specific_energy"] == pytest.approx(middle, rel=1e-4)
        assert found["rock.specific_energy_factor"] == pytest.approx(factor, rel=1e-6)


def test_a_rock_goes_beside_any_hammer_under_its_own_bit(
    tmp_path: Path, cli: Callable[..., str]
) -> None:
    hole = PRESETS["air_5_inch"].values["hole.diameter"]
    expected = rock("granite", hole=hole)
    assert Scene(preset="air_5_inch", rock="granite").numbers.items() >= expected.items()
    # Single values override those of the rock. A given hole has a bit of its size.
    own = Scene(rock="granite", parameters={"rock.viscosity": 7.0, "hole.diameter": "180 mm"})
    assert own.numbers["rock.viscosity"] == 7.0
    assert own.numbers["rock.stiffness"] == rock("granite", hole="180 mm")["rock.stiffness"]
    # A rock that was written and read is the same under another bit.
    file = tmp_path / "quarry.json"
    cli("run", "--rock", "R5", "--until", "0.1", "--quiet", "--write-rock", file)
    (tmp_path / "scene.json").write_text(json.dumps({"rock": file.name, "until": 0.1}), "utf-8")
    again = Scene.read(tmp_path / "scene.json")
    assert again.numbers == pytest.approx(Scene(rock="R5").numbers, rel=1e-12)
    wide = {"hole.diameter": 0.2}
    there = Scene(parameters=wide, rock=str(file)).numbers
    assert there == pytest.approx(Scene(parameters=wide, rock="R5").numbers, rel=1e-12)
    file.write_text('{"hardnes": 1e9}', "utf-8")
    with pytest.raises(DthHammerError, match="did you mean 'hardness'"):
        rock(str(file), hole=0.09)


def test_a_summary_tells_the_air_of_a_hammer_that_takes_some() -> None:
    given = {"drive.source": "Air", "hole.diameter": 0.09}
    run = simulate(given, until=0.3)
    table = run.summary()
    # Blows repeat to some 1e-6 after 0.15 s.
    assert table["mean"]["free air"] == pytest.approx(run["air_flow"].iloc[-1], rel=1e-4)
    pd.testing.assert_frame_equal(run.convert("metric").summary(), table, rtol=1e-12)
    assert "free air" not in simulate(until=0.3).summary().index


def test_every_number_of_a_rock_has_a_source_and_a_scatter() -> None:
    for figures in ROCKS.values():
        assert {"hardness", "unloading_ratio"} <= set(figures)
        for figure in figures.values():
            assert figure.low < figure.value < figure.high
            assert figure.source


@pytest.mark.parametrize(
    ("name", "inserts", "radius", "message"),
    [
        ("cheese", 8, 7e-3, "there are st anne limestone; kuru granite"),
        ("kuru granite", 0, 7e-3, "inserts = 0"),
        ("kuru granite", 8, "7 m", "0.001 to 0.05 m"),
        ("kuru granite", 8, "7 kg", "insert_radius is given in m"),
    ],
)
def test_no_such_rock_or_bit(name: str, inserts: int, radius: float | str, message: str) -> None:
    with pytest.raises(DthHammerError, match=message):
        rock(name, inserts=inserts, insert_radius=radius)


def test_rocks_on_the_command_line(cli: Callable[..., str]) -> None:
    printed = cli("rock")
    assert "Yang 2025" in printed
    assert "assumed: about the uniaxial compressive strength" in printed
    assert "hardness: 1.57 GPa (1.29 to 4.04)" in printed
    assert "specific energy: 158.1 MJ/m3" in printed
    assert "Yang 2025" not in cli("rock", "granite")
    number = rock("kuru granite", inserts=8, insert_radius=7e-3)["rock.stiffness"]
    under = cli("rock", "kuru granite", "--inserts", "8", "--insert-radius", "7 mm")
    assert f"--set rock.stiffness={number:.6g}" in under


def test_a_damping_ratio_is_that_of_the_first_elastic_mode() -> None:
    # A uniform free bar: omega = pi c / L, to the mesh's (pi / 20)^2 / 24.
    start = {v.name: v.start or 0.0 for v in VARIABLES.of("parameter")}
    speed = math.sqrt(start["material.youngs_modulus"] / start["material.density"])
    omega = math.pi * speed / start["piston.length"]
    assert Scene().damping_time("0.005") == pytest.approx(2 * 0.005 / omega, rel=2e-3)
    beta = Scene(parameters={"piston.length": "200 mm"}).damping_time(0.01)
    damped = Scene(parameters={"piston.length": 0.2, "material.damping_time": beta})
    assert damped.damping_ratio == pytest.approx(0.01, rel=1e-12)
    assert Scene(preset="water_hammer").damping_ratio == pytest.approx(0.005, rel=5e-3)
    with pytest.raises(
        DomainError, match=r"damping_ratio = 5 is not allowed: it must be 0 to 0\.5"
    ):
        Scene().damping_time(5)


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(HOLE, until=0.8, step="5 ms")


def test_the_summary_is_made_of_blows_and_energies(run: Run) -> None:
    table = run.summary()
    late = run.blows[run.blows["blow_time"] >= 0.4]
    assert table.loc["blow energy", "mean"] == pytest.approx(late["blow_energy"].mean(), rel=1e-4)
    # In the long run the means agree with those from other energies than a blow records.
    cycle = steady(HOLE)
    work = cycle["energy_rock_dissipated"] + cycle["energy_viscous"]
    for name, value in {
        "frequency": 1 / cycle["period"],
        "impact speed": cycle["blow_speed"],
        "work to the rock per blow": work,
        "power to the rock": work / cycle["period"],
        "work to the rock over blow energy": work / cycle["blow_energy"],
        "tip's gain per time": cycle["tip_rate"],
        "rate of penetration": work / cycle["period"] / (AREA * 399e6),
    }.items():
        assert table.loc[name, "mean"] == pytest.approx(value, rel=2e-4), name
    assert table.loc["blow energy", "spread"] < 1e-2 * table.loc["blow energy", "mean"]
    pd.testing.assert_frame_equal(run.convert("us").summary(), table, rtol=1e-12)
    # The rate's range is that of the specific energy, on which nothing else depends.
    rate, factor = table.loc["rate of penetration"], VARIABLES["rock.specific_energy_factor"].start
    assert factor is not None
    assert [rate["low"], rate["high"]] == [rate["mean"] / factor, rate["mean"] * factor]
    assert table["low"].notna().sum() == 1


def test_the_work_of_all_blows_is_the_ledger_s(run: Run) -> None:
    # The works are those from the start to the last blow.
    names = {
        "energy_drive": "drive_work",
        "energy_gravity": "gravity_work",
        "energy_feed": "feed_work",
        "energy_rock_dissipated": "crushing_work",
        "energy_viscous": "viscous_work",
        "energy_damping": "damping_work",
        "drilled_length": "blow_length",
    }
    times = run.blows["blow_time"].iloc[[-1]].to_numpy()
    ledger = simulate(HOLE, times=times, outputs=[*names]).frame.iloc[-1]
    for output, column in names.items():
        assert run.blows[column].sum() == pytest.approx(ledger[output], rel=1e-9), column
    parts = run.blows["crushing_work"] + run.blows["viscous_work"]
    np.testing.assert_allclose(run.blows["rock_work"], parts, rtol=1e-9)


def test_the_rate_of_the_hole_is_shown_in_the_units_of_the_field(
    run: Run, cli: Callable[..., str]
) -> None:
    assert run.blows["rop"].iloc[-1] == run["rop"].iloc[-1] > 0.0
    sets = [f"--set={name}={value}" for name, value in HOLE.items()]
    printed = cli("run", "--until", "800 ms", "--quiet", *sets)
    assert "rop [m/h]" in printed
    mean = run.summary().loc["rate of penetration", "mean"]
    for factor, unit in ((3600, "m/h"), (60, "m/min")):
        line = next(x for x in printed.splitlines() if x.endswith(f" {unit}") and "rate" in x)
        assert f"{factor * mean:.4g}" in line


def test_one_rate_says_the_specific_energy_that_gives_it_back() -> None:
    own = {"hole.diameter": "90 mm"}
    found = steady(own)
    energy = found.specific_energy("30 m/h")
    there = simulate({**own, "rock.specific_energy": energy}, until=0.8)
    assert there.blows["rop"].iloc[-1] * 3600 == pytest.approx(30, rel=1e-3)
    with pytest.raises(DomainError, match="not finite and above 0"):
        found.specific_energy(0)
    # A measured rate replaces the rock's range by its own scatter.
    rock_here = found.measured("30 m/h", scatter=1.0)
    assert rock_here == {"rock.specific_energy": energy, "rock.specific_energy_factor": 2.0}
    assert found.measured("30 m/h")["rock.specific_energy_factor"] == 1.1
    with pytest.raises(DomainError, match=r"scatter = 1\.5 is not"):
        found.measured("30 m/h", scatter=1.5)


def test_a_hammer_that_never_repeats_has_a_specific_energy_too() -> None:
    # Without feed the overdamped hammer's blows never repeat. The mean power is known as well as
    # the mean rate, to the requested 1 %, here within three times that.
    own = {"hole.diameter": "90 mm", "feed_force": 0.0}
    with pytest.warns(HammerWarning, match="2 sqrt"):
        found = steady(own, preset="overdamped")
    assert found.kind == "irregular"
    own["rock.specific_energy"] = found.specific_energy("30 m/h")
    with pytest.warns(HammerWarning, match="2 sqrt"):
        there = steady(own, preset="overdamped")
    assert there["rop"] * 3600 == pytest.approx(30, rel=0.03)


def test_the_digits_of_a_summary_follow_the_spread() -> None:
    columns = ["mean", "low", "high", "spread", "unit"]
    none = float("nan")
    cases = [
        # A mean has four digits, but none below the second digit of its spread.
        ((11.19281, 0.3456, "J"), ("11.19", "± 0.35")),
        ((11.19281, 3.456, "J"), ("11.2", "± 3.5")),
        ((11.19281, 0.005139, "J"), ("11.19", "± 0.01")),
        ((0.816164, 3.96e-5, "1"), ("0.8162", "< 0.0001")),
        ((0.04487, 0.0, "s"), ("44.87", "< 0.01")),
        ((941830.0, 12345.0, "Hz"), ("942000", "± 12000")),
        ((4845.1, none, "W"), ("4.845", "")),
    ]
    for (mean, spread, unit), expected in cases:
        table = pd.DataFrame([[mean, none, none, spread, unit]], index=["x"], columns=columns)
        ((_, number, _, wide, _),) = displayed(table)
        assert (number, wide) == expected
