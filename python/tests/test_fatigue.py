"""Fatigue life: exact turning points, rainflow, damage, hours, and their figures."""

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import DomainError, HammerWarning, RefusedError, Scene, SNCurve, life, report
from dth_hammer.errors import MissingError
from dth_hammer.study import fatigue
from dth_hammer.study.fatigue import Life, _counted, ranges, turning_points

CURVE = SNCurve("200 MPa", 1e7, 8)
# A coarse mesh, at a quarter of the cost, and a contact as stiff as two of its elements.
MESH = {"piston.elements": 10, "bit.elements": 10, "contact.stiffness": 6e10}


@pytest.fixture(scope="module")
def found() -> Life:
    return life(MESH, CURVE)


def test_rainflow_counts_as_the_standard_s_example() -> None:
    # ASTM E1049-85, figure 6: ranges and counts of its table X1.
    history = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
    counted = ranges(history)
    table: dict[float, float] = {}
    for size, _, count in counted:
        table[size] = table.get(size, 0.0) + count
    assert table == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}


def test_turning_points_lie_between_samples() -> None:
    # For a cosine sampled in steps of h the vertex is cos x + sin^2 x (1 + cos h) / (4 cos x), with
    # |x| up to h / 2: it errs by 3 h^4 / 128 at most, and by terms of h^6.
    step = 0.3
    bound = 3 * step**4 / 128 * (1 + step**2)
    samples = np.cos(step * np.arange(4000) + 0.123)
    peaks = np.abs(turning_points(samples))
    assert len(peaks) == math.floor((step * 3999 + 0.123) / math.pi)
    assert np.abs(peaks - 1.0).max() < bound
    # Samples alone would err by up to h^2 / 8, fifty times as much.
    assert 1.0 - np.cos(step / 2) > 50 * bound


def test_the_damage_of_a_cycle_is_that_of_the_line() -> None:
    stress = np.array([100e6, 200e6, 400e6])
    none = np.zeros(3)
    assert CURVE.damage(stress, none) == pytest.approx([1e-7 / 256, 1e-7, 256e-7], rel=1e-12)
    # Goodman: at a mean of half the ultimate strength an amplitude does the damage of twice as
    # much.
    bent = SNCurve(200e6, 1e7, 8, "1 GPa")
    assert bent.damage(stress[:1], np.array([500e6])) == pytest.approx(1e-7, rel=1e-12)
    assert bent.damage(stress[:1], np.array([-500e6])) == pytest.approx(1e-7 / 256, rel=1e-12)
    assert math.isinf(bent.damage(stress[:1], np.array([1e9]))[0])


def test_many_small_cycles_count_where_the_line_is_flat() -> None:
    # One cycle of 100 MPa and 20,000 of 0.9 MPa, whose damages Miner adds.
    small = 20_000
    turns = 1e6 * np.concatenate(([100.0, 0.0], np.tile([0.9, 0.0], small)))
    alone, each = SNCurve("200 MPa", 1e7, 3).damage(np.array([50e6, 0.45e6]), np.zeros(2))
    damage = _counted(turns, SNCurve("200 MPa", 1e7, 3))["damage"]
    assert damage == pytest.approx(alone + small * each, rel=1e-9)
    assert damage > 1.01 * alone


def test_stresses_are_those_of_the_blow(found: Life) -> None:
    # Saint-Venant: two bars of equal section that meet at v have E v / 2 c, compression in both
    # bodies. Where the wave overlaps with its reflection from rock or contact, it is twice that at
    # most.
    front = 0.5 * 11.4 * math.sqrt(210e9 * 7850)
    least = found.places.groupby("body")["least"].min()
    assert (-least).between(front, 2.0 * front).all()
    assert len(found.places) == 20
    assert (found.places["range"] <= found.places["largest"] - found.places["least"] + 1e-3).all()
    assert found.places["position"].between(-0.168, 0.168).all()


def test_hours_go_with_the_strength_to_the_power_of_the_slope(
    found: Life, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Blocks of another length must not lose a turning point.
    monkeypatch.setattr(fatigue, "BLOCK", 97)
    twice = life(MESH, SNCurve("400 MPa", 1e7, 8))
    ratio = twice.places["hours"] / found.places["hours"]
    assert ratio.to_numpy() == pytest.approx(np.full(20, 2.0**8), rel=1e-9)
    # One cycle of the largest range per blow is the least possible damage, and most of it.
    worst = found.worst
    alone = found.curve.damage(worst["range"] / 2, 0.0)
    assert alone <= worst["damage"] * (1 + 1e-12) < 10 * alone
    larger = found.curve.damage((1 + found.stress_error) * worst["range"] / 2, 0.0)
    assert 1 + found.life_error == pytest.approx(larger / alone)
    assert worst["hours"] == pytest.approx(found.time / found.blows / worst["damage"] / 3600)


@pytest.mark.weekly  # a mesh of degree 7 on 180 spans: four minutes
def test_the_mesh_is_the_life_s_own_and_leaves_the_hours_that_it_says() -> None:
    own = life(None, CURVE)
    assert own.mesh["mesh.degree"] >= 5
    assert own.stress_error <= 1.2 ** (1 / 8) - 1
    fine = life({"mesh.degree": 7, "piston.elements": 90, "bit.elements": 90}, CURVE)
    assert fine.stress_error < 0.1 * own.stress_error
    ratio = own.worst["hours"] / fine.worst["hours"]
    assert 1 / (1 + own.life_error) <= ratio <= 1 + own.life_error
    # The reference's own mesh is made for a rate, so its error is large.
    rough = life({"mesh.degree": 3}, CURVE)
    assert rough.mesh["piston.elements"] == 16
    assert rough.stress_error > 0.1


def test_life_on_the_command_line_and_in_the_report(
    found: Life, cli: Callable[..., str], tmp_path: Path
) -> None:
    picture, table = tmp_path / "waves.png", tmp_path / "life.csv"
    sets = [part for name, value in MESH.items() for part in ("--set", f"{name}={value}")]
    command = ["life", *sets, "--sn", "200 MPa,1e7,8", "-o", table, "--plot", picture]
    assert str(found) in cli(*command)
    assert picture.stat().st_size > 10_000
    assert len(table.read_text(encoding="utf-8").splitlines()) == 21
    page = report(Scene("x", "", None, dict(MESH), {}, 0.4), tmp_path / "page.html", curve=CURVE)
    text = page.read_text(encoding="utf-8")
    assert "<h2>Life</h2>" in text
    assert f"{found.worst['hours']:.4g}" in text
    ramp = pd.Series([5e3, 6e3], index=[0.0, 1.0])
    moved = Scene("x", "", None, {}, {"feed_force": ramp}, 0.2)
    assert "Not computed: inputs change" in report(
        moved, tmp_path / "moved.html", curve=CURVE
    ).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("curve", "message"),
    [
        (("200 kg", 1e7, 8), "strength is given in Pa"),
        ((-1.0, 1e7, 8), "strength = -1 must be finite, above 0"),
        ((2e8, math.nan, 8), "cycles = nan"),
        ((2e8, 1e7, 80), "slope = 80 must be finite, above 0 and at most 50"),
        ((2e8, 1e7, 8, 0.0), "ultimate = 0"),
    ],
)
def test_lines_that_are_none_are_refused(curve: tuple[float, ...], message: str) -> None:
    with pytest.raises((DomainError, ValueError), match=message):
        SNCurve(*curve)


def test_what_has_no_life_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DomainError, match="rigid bodies carry no waves"):
        life({"fidelity": "Rigid"}, CURVE)
    # A drive of 1 N does not lift the piston.
    with (
        pytest.warns(HammerWarning, match="is the unit right"),
        pytest.warns(HammerWarning, match="stays at rest"),
        pytest.raises(RefusedError, match="comes to rest"),
    ):
        life({"drive.amplitude": 1.0}, CURVE)
    monkeypatch.setitem(sys.modules, "rainflow", None)
    with pytest.raises(MissingError, match=r"pip install 'dth-hammer\[life\]'"):
        life(None, CURVE)
