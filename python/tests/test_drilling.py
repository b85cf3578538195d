"""From a drilling log to the rock's specific energy over depth."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    PRESETS,
    DomainError,
    HammerWarning,
    compare,
    from_datasheet,
    specific_energy,
    steady,
)
from dth_hammer.scene.variables import numbers, whole
from dth_hammer.study.drilling import FREQUENCY_ERROR, SCATTER, _frequency_effect

SHEET = {"od": "124 mm", "pressure": "24 bar", "power": "31.7 kW", "hole": "140 mm"}


@pytest.mark.filterwarnings("ignore:material.damping_time is ignored")
def test_a_log_of_simulated_rates_gives_the_rock_that_they_were_simulated_in() -> None:
    sheet = from_datasheet(**SHEET)
    # Between the nodes of pressure and feed, above and below the knee.
    scenes = [(24e5, 27e3, 2e8), (15e5, 16e3, 3e8), (20e5, 14e3, 1.5e8), (18.5e5, 22e3, 2.5e8)]
    atmosphere = sheet.parameters["supply_pressure"] - 24e5
    rows = []
    for pressure, feed, energy in scenes:
        air = {"supply_pressure": pressure + atmosphere, "feed_force": feed}
        rock = {"rock.specific_energy": energy, "fidelity": "Rigid"}
        rate = steady({**sheet.parameters, **air, **rock})["rop"]
        rows.append({"depth": len(rows), "rop": rate, "pressure": pressure, "feed": feed})
    units = {"depth": "m", "rop": "m/s", "pressure": "Pa", "feed": "N"}
    found = specific_energy(sheet, pd.DataFrame(rows), unit=units)
    # Relative to the share of the work that a rigid hammer gives the rock, which is equal in all
    # rows.
    off = np.log(found["specific_energy"] / [energy for *_, energy in scenes])
    # Two means of 100 blows, each known to 2 %. The sheet also leaves a hammer's own curve over the
    # pressure open, of which only the middle hammer is used.
    curve = compare(sheet.but(at="15 bar"), sheet).loc["rate of penetration"]
    assert np.ptp(off) < 4.0 * 0.02 * np.sqrt(2.0) + np.log(curve["high"] / curve["low"])
    # A sheet and a log get the same energy from one rate, because members and quantiles are the
    # same.
    one = sheet.but(rop=18 / 3600)
    here = {"depth [m]": [0.0], "rop [m/s]": [18 / 3600], "pressure [Pa]": [24e5]}
    here["feed [N]"] = [one.parameters["feed_force"]]
    alone = specific_energy(sheet, pd.DataFrame(here)).iloc[0]
    assert alone["specific_energy"] == pytest.approx(
        one.parameters["rock.specific_energy"], rel=1e-6
    )
    sides = alone[["specific_energy_low", "specific_energy_high"]]
    assert tuple(sides) == pytest.approx(one.ranges["specific energy"], rel=1e-6)


def test_a_frequency_that_is_heard_moves_the_power_as_the_hammers_go_together() -> None:
    # These hammers' power is in proportion to the cube of the frequency. So a measured frequency
    # determines the power, as far as the measurement is better than the sheet.
    pace = np.log(30.0) + 0.1 * np.random.default_rng(2).standard_normal((1, 240))
    moved = (3.0 * pace + _frequency_effect(3.0 * pace, pace, np.log([33.0])))[0]
    trust = pace.var() / (pace.var() + FREQUENCY_ERROR**2)
    middle = 3.0 * (pace.mean() + trust * (np.log(33.0) - pace.mean()))
    # The mean of 240 random numbers is not zero.
    assert moved.mean() == pytest.approx(middle, abs=4.0 * 3.0 * FREQUENCY_ERROR / np.sqrt(240))
    assert moved.std() == pytest.approx(3.0 * FREQUENCY_ERROR * np.sqrt(trust), rel=0.15)
    assert not _frequency_effect(3.0 * pace, pace, np.array([np.nan])).any()
    with pytest.warns(HammerWarning, match="1 frequencies of the log are of no hammer"):
        _frequency_effect(pace, pace, np.log([60.0]))


def test_logs_are_read_as_rigs_write_them(tmp_path: Path, cli: Callable[..., str]) -> None:
    sheet = from_datasheet(**SHEET)
    plain = {"depth [m]": [10.0, 11.0], "rop [m/s]": [5e-3, 6e-3], "pressure [bar]": [24, 20]}
    expected = specific_energy(sheet, pd.DataFrame(plain))
    cells = [
        "10 m|18 m/h|24 bar",
        "10,5 m|0 m/h|24 bar",
        "11 m|21,6 m/h|20 bar",
        "12 m|-999.25|8bar",
    ]
    units = "Depth|ROP|Air pressure\nm|m/h|bar\n10|18|24\n-999.25|-999.25|0\n11|21.6|20\n12||20"
    rows = [line.split("|") for line in units.splitlines()]
    below = pd.DataFrame(rows[1:], columns=rows[0])
    heads = pd.DataFrame([[10, 18, 24], [11, 21.6, 20], [11, np.nan, 20]], index=["a", "b", "c"])
    heads.columns = pd.Index(["DEPT (m)", "rate [m/h]", "pressure [bar]"])
    german = tmp_path / "hole.csv"
    german.write_text("\n".join(["depth;rop;pressure", *cells]).replace("|", ";"), "utf-8-sig")
    for log, index in ((below, [1, 3]), (heads, ["a", "b"]), (german, [2, 4])):
        with pytest.warns(HammerWarning, match="null, idle or told"):
            found = specific_energy(sheet, log)
        assert found.to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-12)
        # Rows of a table keep its labels, rows of a file have the number of the line.
        assert [*found.index] == index
    text = ",".join(f"{name}={value}" for name, value in SHEET.items())
    printed = cli("log", german, "--sheet", text)
    assert "specific_energy [MJ/m3]" in printed
    assert "'rop' is rop in the units of its cells" in printed
    si = {"depth [m]": [1], "rop [m/s]": [0], "pressure [Pa]": [1e6]}
    with pytest.raises(DomainError, match="there is no pressure, but depth, rop"):
        specific_energy(sheet, pd.DataFrame({"depth": ["1 m"], "rop": ["1 m/h"]}))
    with pytest.raises(DomainError, match="no row of the log"), pytest.warns(HammerWarning):
        specific_energy(sheet, pd.DataFrame(si))


def test_a_frequency_and_a_feed_count_where_they_stand_and_what_else_there_is_stays() -> None:
    # The sheet leaves the power open, which a measured frequency determines better.
    sheet = from_datasheet(od="124 mm", pressure="24 bar", hole="140 mm")
    log = pd.DataFrame(
        {"Depth [m]": [10, 11], "ROP [min/m]": [3, 4], "Percussion pressure [bar]": [24, 24]}
    )
    log["specific_energy"], log["Time"] = ["mine", "mine too"], ["10:02", "10:07"]
    own = sheet.parameters["feed_force"] / 9806.65
    fed = log.assign(**{"Thrust [t]": [own, 2]})
    unfed, alone = specific_energy(sheet, log), specific_energy(sheet, fed)
    middle = 60 * sheet.members["frequency"].median()
    heard = specific_energy(sheet, fed.assign(BPM=[middle, None]))

    def wide(table: pd.DataFrame) -> np.ndarray:
        return np.log(table["specific_energy_high"] / table["specific_energy_low"]).to_numpy()

    first, second = wide(heard) / wide(alone)
    # By the formula for correlated normal numbers, with the error of the measured frequency. The
    # ends of an 80 % range of 240 members are known to some 7 % each.
    logs = np.log(sheet.but(rop="18 m/h").members[["specific energy", "frequency"]])
    trust = logs["frequency"].var() / (logs["frequency"].var() + FREQUENCY_ERROR**2)
    assert first == pytest.approx(np.sqrt(1.0 - trust * logs.corr().iloc[0, 1] ** 2), rel=0.1)
    assert first < 1.0
    assert second == pytest.approx(1.0, rel=1e-9)
    # A measured feed narrows it too. Otherwise the feed is anywhere in the range that rigs use with
    # such a hammer.
    assert (wide(alone) < wide(unfed)).all()
    assert heard["feed"].tolist()[1] == pytest.approx(2000 * 9.80665)
    said = "; ".join(heard.attrs["said"])
    assert "frequency is used in 1 of 2 rows, which makes the range of the power 0." in said
    assert re.search(
        "feed is used in 2 of 2 rows: .* which makes the range of the power 0[.]", said
    )
    assert "'Time' is not used" in said
    assert heard["Time"].tolist() == ["10:02", "10:07"]
    assert heard["specific_energy (of the log)"].tolist() == ["mine", "mine too"]


@pytest.mark.filterwarnings("ignore::dth_hammer.HammerWarning")
def test_a_log_is_of_whatever_simulate_takes(tmp_path: Path, cli: Callable[..., str]) -> None:
    # From a hammer's own rates the log gives its own rock, at its pressure and at another one.
    hammer = {**PRESETS["air_4_inch"].values, "fidelity": "Rigid"}
    lower = hammer | {"supply_pressure": 0.8 * hammer["supply_pressure"]}
    air = whole(numbers(None, hammer))["exhaust_pressure"]
    hole = tmp_path / "hole.csv"
    rows = [
        f"{k} m,{steady(own)['rop']!r} m/s,{own['supply_pressure'] - air!r} Pa"
        for k, own in enumerate((hammer, lower))
    ]
    hole.write_text("\n".join(["depth,rop,pressure", *rows]), encoding="utf-8")
    found = specific_energy(hammer, hole)
    energy = whole(numbers(None, hammer))["rock.specific_energy"]
    # The median of 240 members that are drawn with 5 and 10 %, and two means known to 2 %.
    assert found["specific_energy"].to_numpy() == pytest.approx([energy] * 2, rel=0.06)
    wide = np.log(found["specific_energy_high"] / found["specific_energy_low"])
    assert wide.to_numpy() == pytest.approx([2 * 1.2816 * np.hypot(0.05, SCATTER)] * 2, rel=0.15)
    printed = cli("log", hole, "--sheet", "air_4_inch")
    (row, *_) = json.loads(cli("log", hole, "--sheet", "air_4_inch", "--json"))
    # The text is in field units and has five digits, JSON is in SI units.
    assert "specific_energy [MJ/m3]" in printed
    assert f"{1e-6 * row['specific_energy']:.5g}" in printed
    with pytest.raises(DomainError, match="does not drive this hammer"):
        specific_energy("water_hammer", hole)
