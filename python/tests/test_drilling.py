"""A drilling log to the rock's specific energy over depth."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    DomainError,
    HammerWarning,
    compare,
    from_datasheet,
    specific_energy,
    steady,
)
from dth_hammer.study.drilling import HEARD, _heard

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
    found = specific_energy(sheet, pd.DataFrame(rows))
    # Up to the share of the work that a rigid hammer gives the rock, which is of all rows alike.
    off = np.log(found["specific_energy"] / [energy for *_, energy in scenes])
    # Two means of 100 blows, each known to 2 %, and what the sheet leaves open of a hammer's own
    # curve over the pressure, of which the middle hammer has one.
    curve = compare(sheet.but(at="15 bar"), sheet).loc["rate of penetration"]
    assert np.ptp(off) < 4.0 * 0.02 * np.sqrt(2.0) + np.log(curve["high"] / curve["low"])
    # What one rate says to the sheet, the log says too: the same members and quantiles.
    one, here = sheet.but(rop=18 / 3600), {"depth": [0.0], "rop": [18 / 3600], "pressure": [24e5]}
    alone = specific_energy(sheet, pd.DataFrame(here)).iloc[0]
    assert alone["specific_energy"] == pytest.approx(
        one.parameters["rock.specific_energy"], rel=1e-6
    )
    sides = alone[["specific_energy_low", "specific_energy_high"]]
    assert tuple(sides) == pytest.approx(one.ranges["specific energy"], rel=1e-6)


def test_a_frequency_that_is_heard_moves_the_power_as_the_hammers_go_together() -> None:
    # Hammers whose power goes with the cube of the frequency: what is heard gives the power, as far
    # as the ear is better than the sheet.
    pace = np.log(30.0) + 0.1 * np.random.default_rng(2).standard_normal((1, 240))
    moved = (3.0 * pace + _heard(3.0 * pace, pace, np.log([33.0])))[0]
    trust = pace.var() / (pace.var() + HEARD**2)
    middle = 3.0 * (pace.mean() + trust * (np.log(33.0) - pace.mean()))
    # 240 noises have a mean of their own.
    assert moved.mean() == pytest.approx(middle, abs=4.0 * 3.0 * HEARD / np.sqrt(240))
    assert moved.std() == pytest.approx(3.0 * HEARD * np.sqrt(trust), rel=0.15)
    assert not _heard(3.0 * pace, pace, np.array([np.nan])).any()
    with pytest.warns(HammerWarning, match="1 frequencies of the log are of no hammer"):
        _heard(pace, pace, np.log([60.0]))


def test_logs_are_read_as_rigs_write_them(tmp_path: Path, cli: Callable[..., str]) -> None:
    sheet = from_datasheet(**SHEET)
    plain = {"depth": [10.0, 11.0], "rop": [5e-3, 6e-3], "pressure": [24e5, 20e5]}
    expected = specific_energy(sheet, pd.DataFrame(plain))
    cells = ["10 m|18 m/h|24 bar", "10,5 m|0 m/h|24 bar", "11 m|21,6 m/h|20 bar", "12 m|-999.25|8"]
    units = "Depth|ROP|Air pressure\nm|m/h|bar\n10|18|24\n-999.25|-999.25|0\n11|21.6|20\n12||20"
    rows = [line.split("|") for line in units.splitlines()]
    below = pd.DataFrame(rows[1:], columns=rows[0])
    heads = pd.DataFrame([[10, 18, 24], [11, 21.6, 20], [11, np.nan, 20]])
    heads.columns = pd.Index(["DEPT (m)", "rate [m/h]", "pressure [bar]"])
    german = tmp_path / "hole.csv"
    german.write_text("\n".join(["depth;rop;pressure", *cells]).replace("|", ";"), "utf-8-sig")
    for log in (below, heads, german):
        with pytest.warns(HammerWarning, match="null or idle and are left out"):
            found = specific_energy(sheet, log)
        assert found.to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-12)
    text = ",".join(f"{name}={value}" for name, value in SHEET.items())
    assert "specific_energy [MJ/m3]" in cli("log", german, "--sheet", text)
    with pytest.raises(DomainError, match="there is no pressure, but depth, rop"):
        specific_energy(sheet, pd.DataFrame({"depth": [1], "rop": [1]}))
    with pytest.raises(DomainError, match="rop is given in m/s"):
        specific_energy(sheet, pd.DataFrame({"depth": [1], "rop": ["1 bar"], "pressure": [1e6]}))
    with pytest.raises(DomainError, match="no row of the log"), pytest.warns(HammerWarning):
        specific_energy(sheet, pd.DataFrame({"depth": [1], "rop": [0], "pressure": [1e6]}))
