"""The laboratory's figures of the drive: pressures over the piston's height, and the air taken."""

from __future__ import annotations

import numpy as np
import pytest
from browsing import OPEN, choose, settled
from fmu import Instance, Package
from playwright.sync_api import Page, expect
from test_laboratory_casing import column

CHAMBERS = ["drive_chamber_pressure", "return_chamber_pressure"]


def of_air(opened: OPEN) -> Page:
    return choose(opened(), "air_4_inch")


def loops(page: Page) -> list[list[np.ndarray]]:
    """Returns height (mm) and the values over it, for each loop of the indicator diagram."""
    drawn = page.evaluate("charts.indicator.data.slice(1)")
    return [[np.array(values, dtype=float) for values in pair] for pair in drawn]


def test_the_indicator_of_air_has_the_fmus_pressures(opened: OPEN, package: Package) -> None:
    page = of_air(opened)
    impact, period = page.evaluate("[laboratory.cycle.impact, laboratory.cycle.period]")
    times = column(page, "time")
    inside = np.flatnonzero((times >= impact) & (times <= impact + period))
    above, below, force = loops(page)
    assert force[0].size == 0
    values = page.evaluate("scene.changed")
    with Instance(package, values) as hammer:
        for place in range(0, len(inside), 40):
            hammer.advance(times[inside[place]])
            height, *bars = hammer.read(["relative_position", *CHAMBERS])
            assert above[0][place] == pytest.approx(-1e3 * height, abs=1e-9)
            assert [above[1][place], below[1][place]] == pytest.approx([1e-5 * p for p in bars])
    # The loops times the areas of the faces are the work that the engine counts. They differ by the
    # motion of the bit, 1 % of the stroke, and by the chords between samples, 2 %.
    work = 0.0
    for (height, bar), area, sign in [(above, "drive", 1.0), (below, "return", -1.0)]:
        mean = 0.5e5 * (bar[1:] + bar[:-1])
        face = page.evaluate(f"scene.get('drive.area_{area}')")
        work -= sign * face * float(np.sum(mean * np.diff(1e-3 * height)))
    energy = column(page, "energy_drive")[inside]
    assert work == pytest.approx(energy[-1] - energy[0], rel=0.03)


def test_a_drive_that_is_a_force_is_drawn_as_one(opened: OPEN) -> None:
    page = opened()
    above, below, force = loops(page)
    assert above[0].size == below[0].size == 0
    # The relay has two values of the force.
    strength = page.evaluate("1e-3 * scene.get('drive.amplitude')")
    assert np.abs(force[1]) == pytest.approx(strength)
    expect(page.locator("#chambers")).to_be_hidden()
    expect(page.locator("#value-air")).to_be_hidden()
    expect(page.locator("[id='slide-supply_pressure']")).to_be_hidden()


def test_the_air_taken_is_told_and_follows_the_pressure(opened: OPEN) -> None:
    page = of_air(opened)
    expect(page.locator("[id='slide-drive.amplitude']")).to_be_hidden()

    def air() -> float:
        text = page.inner_text("#value-air")
        flow = page.evaluate("60 * laboratory.blows.at(-1).air_flow")
        assert text == f"{float(f'{flow:.4g}'):g} m³/min"
        return float(flow)

    before = air()
    pressure = page.locator("[id='exact-supply_pressure']")
    expect(pressure).to_be_visible()
    full = float(pressure.input_value())
    pressure.fill(str(0.8 * full))
    pressure.press("Enter")
    settled(page)
    # Choked ports pass air in proportion to the absolute pressure.
    assert air() == pytest.approx(0.8 * before, rel=0.1)
