"""Answers in a notebook: tables with units, and figures with the same numbers."""

import re
from collections.abc import Mapping

import numpy as np
import pytest
from dth_hammer import (
    VARIABLES,
    HammerWarning,
    calibrate,
    from_datasheet,
    optimise,
    steady,
    trend,
)
from dth_hammer.errors import MissingError
from dth_hammer.simulation.answers import BAND, BLUE, ORANGE
from dth_hammer.study.calibration import Calibration
from dth_hammer.study.longrun import Steady
from dth_hammer.study.optimisation import LIMIT_TOLERANCE, Optimum
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

RIGID = {"fidelity": "Rigid"}


@pytest.fixture(scope="module")
def cycle() -> Steady:
    return steady()


@pytest.fixture(scope="module")
def fit() -> Calibration:
    mean = steady({**RIGID, "rock.stiffness": 1.5e8}).mean
    rates = {name: (mean[name], 0.01 * mean[name]) for name in ("rop", "rebound_ratio")}
    # No such hammer has this frequency, which is off by five errors.
    rates["blow_frequency"] = (1.05 * mean["blow_frequency"], 0.01 * mean["blow_frequency"])
    with pytest.warns(HammerWarning, match="does not describe"):
        return calibrate(RIGID, rates, ["rock.stiffness"])


@pytest.fixture(scope="module")
def best() -> Optimum:
    limits = {"blow_energy": (None, "240 J")}
    return optimise(RIGID, "rop", {"drive.stroke": ("30 mm", "60 mm")}, limits=limits, starts=2)


def sums(figure: Figure) -> Mapping[str, float]:
    """Returns the total length of the bars of each colour."""
    found = {BLUE: 0.0, ORANGE: 0.0}
    for bar in figure.axes[0].patches:
        found[to_hex(bar.get_facecolor())] += bar.get_width()  # type: ignore[attr-defined]
    return found


def test_what_is_put_into_a_cycle_is_what_goes_out_of_it(cycle: Steady) -> None:
    """A cycle stores nothing: the bars of both colours are equally long."""
    energy = sums(cycle.plot())
    # Blows repeat to 1e-9, and the stored energy is a fiftieth of that of a blow.
    assert energy[BLUE] == pytest.approx(energy[ORANGE], rel=1e-7)
    assert energy[BLUE] > 100.0
    mean = sums(steady(RIGID).plot())
    assert mean[BLUE] == pytest.approx(mean[ORANGE], rel=1e-7)


def test_a_measurement_that_does_not_fit_lies_outside_the_band(fit: Calibration) -> None:
    line = fit.plot().axes[0].lines[0]
    off = dict(zip(line.get_ydata(), line.get_xdata(), strict=True))
    assert abs(off["blow_frequency"]) > BAND
    assert abs(off["rop"]) < BAND


def test_every_design_is_drawn_and_those_beyond_a_limit_are_told_apart(best: Optimum) -> None:
    inside, beyond, chosen = best.plot().axes[0].lines
    assert len(inside.get_xdata()) + len(beyond.get_xdata()) == best.evaluations
    past = best.history["past blow_energy"].to_numpy()
    assert len(beyond.get_xdata()) == np.count_nonzero(past > LIMIT_TOLERANCE) > 0
    assert set(chosen.get_ydata()) == {best.value}


def test_a_notebook_shows_tables_with_units_and_a_figure(
    cycle: Steady, fit: Calibration, best: Optimum
) -> None:
    for answer in (cycle, fit, best):
        html = answer._repr_html_()
        assert "<table" in html
        assert len(re.findall(r'<img alt="[^"]+" src="data:image/png;base64,', html)) == 1
    assert "<td>m/s</td>" in cycle._repr_html_()


def test_without_matplotlib_the_tables_are_left(
    cycle: Steady, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(*_: str) -> None:
        raise MissingError("this needs matplotlib", name="matplotlib")

    monkeypatch.setattr("dth_hammer.simulation.answers.need", missing)
    assert "<img" not in cycle._repr_html_()
    assert "<table" in cycle._repr_html_()


def test_each_answer_tells_the_range_of_its_rate(fit: Calibration, best: Optimum) -> None:
    """The specific energy is known within a factor, and so is every rate."""
    wide = {"rock.specific_energy_factor": 1.3}
    trends = trend(RIGID | wide, {"feed_force": 0.02}, ["blow_energy", "rop"], points=8)
    default = VARIABLES["rock.specific_energy_factor"].start
    assert [*trends.points] == ["feed_force", "blow_energy", "rop", "rop_low", "rop_high"]
    sides = {"rop_low": "low", "rop_high": "high"}
    rates = [
        *((row.rename(sides), "rop", 1.3, trends) for _, row in trends.points.iterrows()),
        (trends.middle.loc["rop"], "mean", 1.3, trends),
        (steady(RIGID | wide).outputs.loc["rop"], "mean", 1.3, steady(RIGID | wide)),
        (fit.residuals.loc["rop"], "found", default, fit),
        (best.steady.outputs.loc["rop"], "mean", default, best),
        (best.history.iloc[0].rename(sides), "rop", default, best),
    ]
    for row, column, factor, answer in rates:
        assert row["low"] == pytest.approx(row[column] / factor)
        assert row["high"] == pytest.approx(row[column] * factor)
        assert re.search(
            r"rate of penetration [\d.]+ m/h \([\d.]+ to [\d.]+\)", answer._repr_html_()
        )
    assert trends.middle.loc["blow_energy", ["low", "high"]].isna().all()


def test_a_datasheet_is_a_table_whose_ranges_hold_its_values() -> None:
    sheet = from_datasheet(od="124 mm", pressure="24 bar", power="31.7 kW", hole="140 mm")
    table = sheet.to_frame()
    assert [*table.index] == [name for name, *_ in sheet.found]
    assert table["value"].between(table["low"], table["high"]).all()
    assert table.loc["rate of penetration", "unit"] == "m/s"
