"""The laboratory's words: a table for each language, all of one shape, none of them idle."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from browsing import OPEN, PHONE
from playwright.sync_api import expect

LAB = Path(__file__).parents[2] / "lab"
TEXTS = {path.stem: json.loads(path.read_text("utf-8")) for path in (LAB / "text").glob("*.json")}
ENGLISH = TEXTS["en"]
OTHERS = sorted(TEXTS.keys() - {"en"})


def test_every_language_has_every_text_with_its_placeholders() -> None:
    assert OTHERS == ["de", "es"]
    for name in OTHERS:
        assert list(TEXTS[name]) == list(ENGLISH), name
        for key, text in TEXTS[name].items():
            places = [sorted(re.findall(r"\{\w+\}", each)) for each in (ENGLISH[key], text)]
            assert places[0] == places[1], f"{name}: {key}"
            assert text or not ENGLISH[key], f"{name}: {key}"


def test_every_text_is_used_and_every_text_used_is_there() -> None:
    page = (LAB / "page.html").read_text("utf-8")
    script = "".join(path.read_text("utf-8") for path in LAB.glob("*.js"))
    named = set(re.findall(r'data-say(?:-label|-title)?="([^"]+)"', page))
    assert named <= ENGLISH.keys()
    # Other keys stand as strings in the scripts, or are put together from parts there.
    quoted = set(re.findall(r'"([\w.]+)"|^  (\w+): \[', script, re.MULTILINE))
    literal = {one or other for one, other in quoted}
    parts = re.findall(r"say\(`(\w*)\$\{[^`]*?\}(\w*)`", script)
    made = {
        key
        for key in ENGLISH
        for head, tail in parts
        if (head or tail) and key.startswith(head) and key.endswith(tail)
    }
    idle = ENGLISH.keys() - named - literal - made - {"language"}
    assert idle == set()
    said = set(re.findall(r'\bsay\("([^"]+)"', script))
    assert said <= ENGLISH.keys()


@pytest.mark.parametrize("language", OTHERS)
def test_a_reader_gets_the_page_in_the_browsers_language(opened: OPEN, language: str) -> None:
    page = opened(locale=language, size=PHONE)
    texts = TEXTS[language]
    assert page.evaluate("document.documentElement.lang") == language
    assert page.inner_text("h1") == texts["title"]
    status = texts["blows_done"].replace("{blows}", "30").split("{time}")[0]
    expect(page.locator("#status")).to_contain_text(status)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    # A text whose key or placeholder is wrong would show as such.
    text = page.inner_text("body")
    assert "undefined" not in text
    assert "{" not in text.split(texts["as_command"])[0]
    assert Axe().run(page).response["violations"] == []


def test_the_language_is_chosen_and_the_scene_stays(opened: OPEN) -> None:
    page = opened("#feed_force=7000", locale="pt")
    assert page.evaluate("LANGUAGE") == "en"
    with page.expect_navigation():
        page.get_by_label("Language").select_option("Deutsch")
    expect(page.locator("h1")).to_have_text(TEXTS["de"]["title"])
    expect(page.get_by_label(TEXTS["de"]["language_choice"])).to_have_value("de")
    assert page.evaluate("scene.changed") == {"feed_force": 7000}


@pytest.mark.parametrize("language", OTHERS)
def test_numbers_are_written_as_the_language_writes_them(opened: OPEN, language: str) -> None:
    """A German reads 2.039 m/min as two thousand: both languages have a decimal comma."""
    page = opened(locale=language)
    speed = page.evaluate("laboratory.blows.at(-1).blow_speed")
    assert page.inner_text("#value-speed") == f"{speed:.4g} m/s".replace(".", ",")
    assert page.evaluate("[digits(-1234.56, 6), fixed(0.5, 2)]") == ["\u22121234,56", "0,50"]
