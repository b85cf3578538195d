"""Quantities: all units of the field, read and written by one module."""

from datetime import timedelta
from fractions import Fraction

import numpy as np
import pandas as pd
import pint
import pytest
from dth_hammer import (
    VARIABLES,
    DomainError,
    DthHammerError,
    Hammer,
    Run,
    UnknownNameError,
    simulate,
)
from dth_hammer.scene import quantities

# Exact by definition: the inch, the pound (mass), standard gravity.
INCH, POUND, GRAVITY = Fraction("0.0254"), Fraction("0.45359237"), Fraction("9.80665")
PSI, CFM = POUND * GRAVITY / INCH**2, (12 * INCH) ** 3 / 60
# 14.7 psi and 60 degF to 1.01325 bar and 0 degC, by the law of ideal gases.
KELVIN = Fraction("273.15")
FREE = Fraction("14.7") * PSI / 101_325 * KELVIN / ((60 - 32) * Fraction(5, 9) + KELVIN)


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("60 mm", "m", Fraction(60, 1000)),
        ("60mm", "m", Fraction(60, 1000)),
        ("3 in", "m", 3 * INCH),
        ("4 in2", "m2", 4 * INCH**2),
        ("2000 psi", "Pa", 2000 * PSI),
        ("15 bar", "Pa", Fraction(1_500_000)),
        ("1124 lbf", "N", 1124 * POUND * GRAVITY),
        ("120 MN/m", "N/m", Fraction(120_000_000)),
        ("120 kN/mm", "N/m", Fraction(120_000_000)),
        ("30 m/h", "m/s", Fraction(30, 3600)),
        ("2 m/min", "m/s", Fraction(2, 60)),
        ("7.85 g/cm3", "kg/m3", Fraction(7850)),
        ("7.85 g/cm³", "kg/m3", Fraction(7850)),
        ("170 kN.s/m", "N.s/m", Fraction(170_000)),
        ("170 kN s/m", "N.s/m", Fraction(170_000)),
        ("150 ft.lbf", "J", 150 * 12 * INCH * POUND * GRAVITY),
        ("65 µs", "s", Fraction(65, 1_000_000)),
        ("1.2e8", "N/m", Fraction(120_000_000)),
        ("1800 bpm", "Hz", Fraction(30)),
        ("1800 blows/min", "Hz", Fraction(30)),
        ("1800 1/min", "Hz", Fraction(30)),
        ("1.8 1/ms", "Hz", Fraction(1800)),
        ("600 N m", "J", Fraction(600)),
        ("0.6 kN*m", "J", Fraction(600)),
        ("9.81 m s^-2", "m/s2", Fraction("9.81")),
        ("4 mm**2", "m2", Fraction(4, 10**6)),
        ("350 PSI", "Pa", 350 * PSI),
        ("24 kg/cm2", "Pa", 24 * GRAVITY * 10_000),
        ("12 KN", "N", Fraction(12_000)),
        ("42 hp", "W", 42 * 550 * 12 * INCH * POUND * GRAVITY),
        ("35 lbs", "kg", 35 * POUND),
        ("600 ft-lbs", "J", 600 * 12 * INCH * POUND * GRAVITY),
        ("815 Nm", "J", Fraction(815)),
        ("60 fph", "m/s", 60 * 12 * INCH / 3600),
        ("750 scfm", "m3/s", 750 * CFM * FREE),
        ('5-1/2"', "m", Fraction(11, 2) * INCH),
        ("5 %", "1", Fraction(1, 20)),
        ("5½ in", "m", Fraction(11, 2) * INCH),
        ("140 MM", "m", Fraction(140, 1000)),
        ("380 lpm", "m3/s", Fraction(380, 60_000)),
        ("1 700 spm", "Hz", Fraction(1700, 60)),
        ("24 bar(g)", "Pa", Fraction(2_400_000)),
        ("24 kp/cm2", "Pa", 24 * GRAVITY * 10_000),
        ("2 atm", "Pa", Fraction(202_650)),
        ("25 ksi", "Pa", 25_000 * PSI),
        ("1900 kg", "N", 1900 * GRAVITY),
        ("2 t", "N", 2000 * GRAVITY),
        ("4.2 klbf", "N", 4200 * POUND * GRAVITY),
        ("81.5 daN.m", "J", Fraction(815)),
        ("60 lb/in", "N/m", 60 * POUND * GRAVITY / INCH),
        ("18 M/HR", "m/s", Fraction(18, 3600)),
        ("18 metres per hour", "m/s", Fraction(18, 3600)),
        ("20 °C", "K", 20 + KELVIN),
        ("68 degF", "K", 20 + KELVIN),
    ],
)
def test_a_unit_of_the_field_is_the_number_by_its_definition(
    text: str, unit: str, number: Fraction
) -> None:
    # The number is rounded once, to the nearest double.
    assert quantities.read(text, unit, "x") == float(number)


@pytest.mark.parametrize(
    ("text", "unit", "name", "asked"),
    [
        ("25 rpm", "Hz", "frequency", "is of blows, not of turns"),
        ("3 mph", "m/s", "rop", "may be several units: give m/h"),
        ("24 barg", "Pa", "supply_pressure", "is absolute"),
        ("1,5 m", "m", "x", "a decimal is written 1.5"),
        ("1,700 bpm", "Hz", "frequency", r"a decimal is written 1.700, thousands 1700"),
        ("25 bpm", "Hz", "rotation", "is of turns, not of blows"),
        ("24 bar(a)", "Pa", "pressure", "is over the air's"),
        ("20 Nm3/min", "m3/s", "flow", "is not of air"),
        ("750 acfm", "m3/s", "air_flow", "give scfm"),
        ("2 tons", "N", "feed", "give t or 2000 lb"),
        ("3 min/m", "m/s", "impact_speed", "is given in m/s"),
    ],
)
def test_what_may_be_meant_otherwise_is_asked(text: str, unit: str, name: str, asked: str) -> None:
    with pytest.raises(DomainError, match=asked):
        quantities.read(text, unit, name)
    assert quantities.read("1500 rpm", "Hz", "rotation") == 25.0
    # A rate of drilling may also be time per length.
    assert quantities.read("4 min/m", "m/s", "rop") == pytest.approx(1 / 240, rel=1e-15)


def test_air_is_free_air_by_the_law_of_ideal_gases() -> None:
    for text, kelvins, bars in (
        ("20 Nm3/min", KELVIN, Fraction("1.01325")),
        ("20 Sm3/min", KELVIN + 15, Fraction("1.01325")),
        ("20 m3/min FAD", KELVIN + 20, Fraction(1)),
    ):
        free = Fraction(20, 60) * bars / Fraction("1.01325") * KELVIN / kelvins
        assert quantities.read(text, "m3/s", "air_flow") == float(free)


def test_a_unit_that_stands_once_is_that_of_all_or_refused() -> None:
    assert quantities.alike(["4", "6", "8 kN"], "x") == ["4 kN", "6 kN", "8 kN"]
    assert quantities.alike((4, "6 kN"), "x") == ["4 kN", "6 kN"]
    for same in (["0", "4 kN"], ["4 kN", "6 N"], [1.0, 2.0], ["Relay", "Force"], [None, "4 kN"]):
        assert quantities.alike(same, "x") == same
    for mixed in (["34", "5 mm/s", "35", "1 mm/s"], ["4 kN", "6"]):
        with pytest.raises(DomainError, match="some have a unit and some have none"):
            quantities.alike(mixed, "x")


@pytest.mark.parametrize("text", ["60 N", "60 kg", "60 dB", "60 degC", "60 mm mm", "60 m/0"])
def test_a_foreign_unit_is_refused_and_those_of_the_field_are_named(text: str) -> None:
    with pytest.raises(DomainError, match=r"piston\.length is given in m, mm, cm, in, ft, not in"):
        VARIABLES["piston.length"].number(text)


@pytest.mark.parametrize(
    "value", ["1,5 m", "m", "", "9**9**9 m", "1 2 m", "__import__('os')", None, [1.0], {}]
)
def test_what_is_no_number_is_refused_in_words(value: object) -> None:
    with pytest.raises(DomainError, match=r"piston\.length = .* is not a number"):
        VARIABLES["piston.length"].number(value)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["nan", "inf m", "1e400 m", "1e999999999 m", float("nan")])
def test_what_is_not_finite_is_refused_at_once(value: object) -> None:
    with pytest.raises(DomainError):
        VARIABLES["piston.length"].number(value)  # type: ignore[arg-type]


def test_pure_numbers_have_no_unit_and_counts_are_whole() -> None:
    with pytest.raises(DomainError, match=r"rock\.unloading_ratio is given in no unit"):
        VARIABLES["rock.unloading_ratio"].number("4 m")
    with pytest.raises(DomainError, match="whole number"):
        VARIABLES["bit.elements"].number("10.5")


def test_a_quantity_of_pint_s_is_taken() -> None:
    registry = pint.UnitRegistry()
    with Hammer({"piston.length": registry.Quantity(180.0, "mm")}) as hammer:
        assert hammer["piston.length"] == 0.18


@pytest.mark.parametrize("until", ["50 ms", 0.05, timedelta(milliseconds=50), "0.05"])
def test_durations_are_the_same_in_any_dress(until: object) -> None:
    run = simulate(until=until, step="10 ms", outputs=["rop"])  # type: ignore[arg-type]
    assert run.time.tolist() == [k * 0.01 for k in range(5)] + [0.05]


@pytest.mark.parametrize(
    ("until", "message"),
    [
        (float("nan"), "until must be finite"),
        ("soon", "until = 'soon' is not a number"),
        ("5 m", "until is given in s, ms, us, min, h, not in 'm'"),
        (-1.0, "until = -1 s is not above 0"),
        (1e9, "more than 1e"),
    ],
)
def test_a_duration_that_is_none_is_refused_by_its_name(until: object, message: str) -> None:
    with pytest.raises(DthHammerError, match=message):
        simulate(until=until)  # type: ignore[arg-type]


class TestInputsOverTime:
    """A Series has one meaning, or is refused."""

    def test_timedeltas_are_seconds(self) -> None:
        index = pd.to_timedelta([0.0, 0.1], unit="s")
        one = self.depth(pd.Series([5e3, 8e3], index=index))
        two = self.depth(pd.Series(["5 kN", "8 kN"], index=[0.0, 0.1]))
        three = self.depth(pd.Series([5e3, 8e3], index=["0 s", "100 ms"]))
        assert one == two == three

    @pytest.mark.parametrize(
        ("value", "index", "message"),
        [
            (8e3, [0.1, 0.0], r"index of feed_force must rise, but 0\.1 s"),
            (8e3, [0.1, 0.1], r"index of feed_force must rise, but 0\.1 s"),
            (8e3, pd.to_datetime(["2020-01-01", "2020-01-02"]), "not dates"),
            (float("nan"), [0.0, 0.1], "feed_force"),
            (None, [0.0, 0.1], "feed_force"),
            ("much", [0.0, 0.1], "feed_force"),
        ],
    )
    def test_every_instant_and_value_is_looked_at(
        self, value: object, index: object, message: str
    ) -> None:
        with pytest.raises(DomainError, match=message):
            self.depth(pd.Series([5e3, value], index=index, dtype=object))  # type: ignore[call-overload]

    def test_an_input_must_be_an_input(self) -> None:
        with pytest.raises(DomainError, match=r"piston\.length is fixed"):
            simulate(until=0.01, inputs={"piston.length": 0.2})

    @staticmethod
    def depth(feed: pd.Series) -> float:
        run = simulate(until=0.1, inputs={"feed_force": feed}, outputs=["tip_depth"])
        return float(run["tip_depth"].iloc[-1])


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(until=0.15)


@pytest.fixture(scope="module")
def frame(run: Run) -> pd.DataFrame:
    return run.frame


def test_a_table_goes_to_other_units_and_back(frame: pd.DataFrame) -> None:
    field = quantities.convert(frame, {"rop": "m/h", "rock_force": "lbf"})
    assert field.attrs["units"]["rop"] == "m/h"
    np.testing.assert_allclose(field["rop"], frame["rop"] * 3600, rtol=1e-15)
    assert field["tip_depth"].equals(frame["tip_depth"])
    back = quantities.convert(quantities.convert(field, "us"), "si")
    assert back.attrs["units"] == frame.attrs["units"]
    for name in ("rop", "rock_force", "tip_depth", "blow_energy"):
        # A product with each factor and its inverse: four roundings.
        np.testing.assert_allclose(back[name], frame[name], rtol=1e-15)


def test_a_table_for_reading_has_its_units_in_the_headings(run: Run) -> None:
    readable = run.to_frame("rop", "blow_count", units={"rop": "m/h"})
    assert list(readable) == ["rop [m/h]", "blow_count"]
    assert readable.index.name == "time [s]"
    assert len(run.to_frame("rop")) == len(run.blows)
    with pytest.raises(UnknownNameError, match="did you mean 'rop'"):
        run.to_frame("ropp")


def test_systems_of_units(frame: pd.DataFrame) -> None:
    metric, us = (
        quantities.convert(frame, "metric").attrs["units"],
        quantities.convert(frame, "us").attrs["units"],
    )
    assert [metric[n] for n in ("rop", "tip_depth", "rock_force")] == ["m/h", "mm", "kN"]
    assert [us[n] for n in ("rop", "tip_depth", "rock_force")] == ["ft/h", "in", "lbf"]
    with pytest.raises(UnknownNameError, match="did you mean 'metric'"):
        quantities.convert(frame, "metrik")
    with pytest.raises(UnknownNameError, match="did you mean 'rop'"):
        quantities.convert(frame, {"ropp": "m/h"})


def test_figures_and_blows_do_not_mind_the_units(run: Run) -> None:
    us = run.convert("us")
    assert us.blows.attrs["units"]["blow_speed"] == "ft/s"
    speeds = (each.blows["blow_speed"].iloc[0] for each in (us, run))
    assert next(speeds) == pytest.approx(next(speeds) / float(12 * INCH))
    for one, two in zip(us.plot().get_axes(), run.plot().get_axes(), strict=True):
        np.testing.assert_allclose(one.lines[0].get_ydata(), two.lines[0].get_ydata(), rtol=1e-14)
