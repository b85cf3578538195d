"""The laboratory's picture of a hammer in its casing, and what a hoist does to it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from browsing import DESK, OPEN, PHONE, settled, wait
from fmu import Instance, Package
from playwright.sync_api import Page, expect
from test_laboratory_tools import link, pixels, still

IDLE = 0.01
SCENE = {"casing.mass": 40.0, "chuck.idle_travel": IDLE}


def column(page: Page, name: str) -> np.ndarray:
    return np.array(page.evaluate("name => Array.from(laboratory.cycle[name])", name))


def lifted(page: Page) -> Page:
    page.get_by_role("button", name="Lift off and press back").click()
    wait(page, "player.cycle.lifted || laboratory.failure")
    assert page.evaluate("laboratory.failure") is None
    return page


def test_the_casing_moves_as_in_the_fmu(opened: OPEN, package: Package) -> None:
    page = opened(link(SCENE))
    names = ["casing_position", "chuck_force"]
    times, drawn = column(page, "time"), [column(page, name) for name in names]
    with Instance(package, SCENE) as hammer:
        for index in range(0, len(times), 40):
            hammer.advance(times[index])
            assert hammer.read(names) == [each[index] for each in drawn]
    # The ring holds the bit in one part of the cycle, the shoulder presses in another.
    assert drawn[1].min() < 0 < drawn[1].max()
    for index in (int(drawn[1].argmin()), int(drawn[1].argmax())):
        page.evaluate("i => { play(false); player.index = i; picture(); }", index)
        moment = page.inner_text("#moment")
        assert ("ring holds" if drawn[1][index] < 0 else "shoulder presses") in moment
        assert f"{abs(drawn[1][index]) / 1e3:.3g} kN" in moment


def chuck_end(page: Page) -> int:
    """Where the grey of the casing ends, in pixels: along its wall, above the collar."""
    middle, radius = page.evaluate("[drawing.middle, drawing.x(drawing.hole.casing)]")
    column = pixels(page, "hammer", middle - radius + 3, 0, 1, DESK[1] // 2)[:, :3]
    steel = page.evaluate("channels(palette.casing)")
    return int(np.flatnonzero((column == steel).all(axis=1)).max())


def test_the_chuck_is_drawn_where_it_is(opened: OPEN) -> None:
    page = lifted(opened(link(SCENE)))
    chuck, base = page.evaluate("[drawing.chuck, drawing.base]")
    ends = []
    for time in (0.0, 0.5):
        index = still(page, time)
        place = chuck + column(page, "casing_position")[index] - base
        expected = page.evaluate("place => drawing.place(place)", place)
        # The shoulder is 7 pixels of another colour, with an outline of 1.5 about it.
        assert chuck_end(page) + 1 == pytest.approx(expected - 7 - 0.75, abs=1.5)
        ends.append(expected)
    # 40 mm higher: more than a pixel's error.
    assert ends[0] - ends[1] > 20


def test_a_hammer_lifted_off_idles_and_works_when_it_is_pressed_back(
    opened: OPEN, package: Package
) -> None:
    page = lifted(opened(link(SCENE)))
    time, impact = column(page, "time"), page.evaluate("laboratory.cycle.impact")
    after = time - impact
    out = column(page, "bit_position") - column(page, "casing_position")
    piston, count = column(page, "piston_position"), column(page, "contact_count")
    held = (after > 0.15) & (after < 0.85)
    # The bit hangs out and is off the rock: it idles.
    assert out[held].min() > IDLE
    assert (column(page, "rock_force")[held] == 0).all()
    # A vented piston falls freely between two contacts: `p'' = G`, by second differences of
    # samples 8 us apart at least. Positions, below 1 m, are rounded to 1e-16, as are times, at
    # speeds below 10 m/s: their second difference over h^2 errs by 4e-15 / (8e-6)^2 = 6e-5.
    closed = column(page, "contact_closed")
    free = [
        i
        for i in range(1, len(time) - 1)
        if held[i - 1] and held[i + 1] and count[i - 1] == count[i + 1]
        if not closed[i - 1 : i + 2].any()
    ]
    assert len(free) > 100
    for i in free:
        before, next_ = time[i] - time[i - 1], time[i + 1] - time[i]
        slopes = (piston[i + 1] - piston[i]) / next_, (piston[i] - piston[i - 1]) / before
        assert 2 * (slopes[0] - slopes[1]) / (before + next_) == pytest.approx(
            package.start("gravity"), abs=1e-4
        )
    # Pressed back, it strikes again: 22 times a second, in the quarter of a second that is left.
    assert count[-1] - count[held][-1] >= 4
    # The scene itself is as it was: the next cycle is of the same run.
    page.locator("#blow").fill("20")
    page.locator("#blow").press("Enter")
    wait(page, "!player.cycle.lifted")
    assert page.evaluate("laboratory.blows.length") == 30


def test_without_a_casing_there_is_nothing_to_lift(opened: OPEN) -> None:
    page = opened()
    expect(page.get_by_role("button", name="Lift off and press back")).to_be_hidden()
    assert "shoulder" not in page.inner_text("#moment")
    page.get_by_label("Mass of the casing (0: no casing), kg").fill("40")
    page.keyboard.press("Tab")
    settled(page)
    expect(page.get_by_role("button", name="Lift off and press back")).to_be_visible()


def test_every_variable_that_can_be_set_has_a_field(opened: OPEN, package: Package) -> None:
    page = opened()
    kinds = ("parameter", "input")
    wanted = [name for kind in kinds for name in package.names(kind)]
    fields = page.evaluate(
        "names => names.filter(n => document.getElementById(`exact-${n}`))", wanted
    )
    assert fields == wanted
    page.get_by_text("All other settings").click()
    page.locator("#rest summary", has_text="rock").click()
    page.get_by_label("rock.reloading").select_option("Unloading")
    settled(page)
    assert page.evaluate("scene.changed") == {"rock.reloading": 2}


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_in_a_lifted_hammer(opened: OPEN, scheme: str) -> None:
    page: Any = lifted(opened(link(SCENE), size=PHONE, color_scheme=scheme))
    page.get_by_text("All other settings").click()
    for summary in page.locator("#rest summary").all():
        summary.click()
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    assert Axe().run(page).response["violations"] == []
