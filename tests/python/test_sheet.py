"""The sheet at the beginning of a report fits on one page, A4, when a browser prints it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from dth_hammer import PRESETS, VARIABLES, from_datasheet, report
from dth_hammer.figures.front import SCALES, casing, drawing, sections
from dth_hammer.scene.variables import numbers, whole
from playwright.sync_api import Browser

GIVEN = {"piston_mass": 8.6, "od": "124 mm", "pressure": "24 bar", "hole": "140 mm"}
# Size within the margins of front.py, in CSS pixels of 1/96 inch.
WIDTH, HEIGHT = (96 / 25.4 * mm for mm in (210 - 2 * 16, 297 - 2 * 13))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("sheet") / "sheet.html"
    return report(from_datasheet(**GIVEN), out, title="H 5", customer="A <mine>")


def test_it_is_one_page_that_says_what_is_handed_on(browser: Browser, page: Path) -> None:
    view = browser.new_page(viewport={"width": round(WIDTH), "height": round(HEIGHT)})
    view.emulate_media(media="print")
    view.goto(page.as_uri())
    sheet = view.locator(".front")
    text = sheet.inner_text()
    for told in ("A <mine>", "H 5", "rate of penetration", "blow energy", "feed", "24 bar"):
        assert told in text, told
    assert re.search(r"\d{4}-\d\d-\d\d", text)
    # The rate has its range, to two digits.
    assert re.search(r"rate of penetration\s+[\d.]+ m/h \([\d.]+ to [\d.]+\)", text)
    # No name from the code is on it.
    assert not [name for name in VARIABLES if name in text and ("_" in name or "." in name)]
    box = sheet.bounding_box()
    assert box is not None
    assert box["height"] < HEIGHT
    # No word of the drawing, which is 176 mm wide, is cut off.
    edges = "map((t) => t.getBBox()).map((b) => [b.x, b.x + b.width])"
    ends = sheet.evaluate(f"(sheet) => [...sheet.querySelectorAll('svg text')].{edges}")
    assert min(begin for begin, _ in ends) > 0.0
    assert max(end for _, end in ends) < 176.0
    # No column of a table is beyond the page.
    wide = view.evaluate("[...document.querySelectorAll('table')].map((t) => t.scrollWidth)")
    assert max(wide) <= math.ceil(WIDTH)
    pdf = view.pdf(prefer_css_page_size=True)
    view.close()
    assert 2 <= len(re.findall(rb"/Type /Page\b", pdf)) <= 10


@pytest.mark.parametrize("preset", [*PRESETS])
def test_the_drawing_is_to_scale(preset: str) -> None:
    given = whole(numbers(preset, {}))
    svg = drawing(given)
    found = re.search(r"Scale 1 : (\d+)", svg)
    assert found
    scale = int(found[1])
    assert scale in SCALES
    boxes = [tuple(map(float, m)) for m in re.findall(r'width="([\d.]+)" height="([\d.]+)"', svg)]
    parts = [part for body in ("piston", "bit") for part in sections(given, body)]
    # Lengths are written to a thousandth of a millimetre.
    for box, part in zip(boxes, parts, strict=True):
        assert [scale * side for side in box] == pytest.approx(part, abs=1e-3 * scale)


@pytest.mark.parametrize("preset", ["air_3_5_inch", "air_6_inch", "elastic"])
def test_the_casing_drawn_has_the_casings_steel(preset: str) -> None:
    elastic = {"casing.segments": 2, "casing.segment[2].area": 3e-3}
    more = elastic if preset == "elastic" else {}
    given = whole(numbers("air_4_inch" if more else preset, more))
    svg = drawing(given)
    found = re.search(r"Scale 1 : (\d+)", svg)
    assert found
    walls = re.findall(r'd="M[\d.]+ ([\d.]+)h([\d.]+)v([\d.]+)h', svg)
    assert len(walls) == 2 * len(casing(given)) == 2 * max(1, len(more))
    steel = 0.0
    middle = (44.0 - 9.0) / 2
    for edge, long, wall in (map(float, row) for row in walls):
        # The area of a ring is its wall times the circumference of its middle circle; the halves
        # are drawn above and below.
        radius = abs(float(edge) + wall / 2 - middle)
        steel += math.pi * radius * wall * long * (1e-3 * int(found[1])) ** 3
    areas = sum(
        given[f"casing.segment[{k}].length"] * given[f"casing.segment[{k}].area"]
        for k in range(1, int(given["casing.segments"]) + 1)
    )
    expected = areas or given["casing.mass"] / given["material.density"]
    # Edges are written to a thousandth of a millimetre, while walls are about three millimetres
    # thick.
    assert steel == pytest.approx(expected, rel=2e-3)
