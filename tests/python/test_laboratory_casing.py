"""The laboratory's picture of a hammer in its casing."""

from __future__ import annotations

import numpy as np
import pytest
from browsing import DESK, OPEN, PHONE, in_both_schemes, settled
from fmu import Instance, Package
from playwright.sync_api import Page
from test_laboratory_tools import link, pixels

IDLE = 0.01
SCENE = {"casing.mass": 40.0, "chuck.idle_travel": IDLE}


def column(page: Page, name: str) -> np.ndarray:
    return np.array(page.evaluate("name => Array.from(laboratory.cycle[name])", name))


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
    """Returns the pixel at which the casing's grey ends, along its wall, above the collar."""
    middle, radius = page.evaluate("[drawing.middle, drawing.x(drawing.hole.casing)]")
    column = pixels(page, "hammer", middle - radius + 3, 0, 1, DESK[1] // 2)[:, :3]
    steel = page.evaluate("channels(palette.casing)")
    return int(np.flatnonzero((column == steel).all(axis=1)).max())


def test_the_chuck_is_drawn_where_it_is(opened: OPEN) -> None:
    # With so little feed, the drive lifts the casing.
    page = opened(link(SCENE | {"feed_force": 500.0}))
    chuck, base = page.evaluate("[drawing.chuck, drawing.base]")
    ends, casing = [], column(page, "casing_position")
    for index in (int(casing.argmin()), int(casing.argmax())):
        page.evaluate("i => { play(false); player.index = i; picture(); }", index)
        place = chuck + casing[index] - base
        expected = page.evaluate("place => drawing.place(place)", place)
        # The shoulder has 7 pixels of another colour, and an outline of 1.5 around it.
        assert chuck_end(page) + 1 == pytest.approx(expected - 7 - 0.75, abs=1.5)
        ends.append(expected)
    # The casing bounces by more than a pixel's error.
    assert max(ends) - min(ends) > 3


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


def test_axe_finds_nothing_in_a_casing(opened: OPEN) -> None:
    page = opened(link(SCENE), size=PHONE)
    page.get_by_text("All other settings").click()
    for summary in page.locator("#rest summary").all():
        summary.click()
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    assert [found["violations"] for found in in_both_schemes(page)] == [[], []]
