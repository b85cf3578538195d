"""The page's words, all used: the explanation in several languages, the laboratory in English."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from browsing import OPEN, PHONE, explained, fits_a_phone, judged, wait
from playwright.sync_api import expect

LAB = Path(__file__).parents[2] / "lab"
TEXTS = {path.stem: json.loads(path.read_text("utf-8")) for path in (LAB / "text").glob("*.json")}
ENGLISH = TEXTS["en"]
OTHERS = sorted(TEXTS.keys() - {"en"})


def test_a_translation_has_the_placeholders_of_the_english_text() -> None:
    assert OTHERS == ["de", "es"]
    for name in OTHERS:
        assert TEXTS[name].keys() <= ENGLISH.keys(), name
        for key, text in TEXTS[name].items():
            places = [sorted(re.findall(r"\{\w+\}", each)) for each in (ENGLISH[key], text)]
            assert places[0] == places[1], f"{name}: {key}"
            assert text, f"{name}: {key}"


def test_every_text_is_used_and_every_text_used_is_there() -> None:
    page = (LAB / "page.html").read_text("utf-8")
    script = "".join(path.read_text("utf-8") for path in LAB.glob("*.js"))
    named = set(re.findall(r'data-say(?:-label|-title)?="([^"]+)"', page))
    assert named <= ENGLISH.keys()
    # Other keys are strings in the scripts, or are built from parts there.
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


def test_no_line_of_the_page_s_sources_is_wider_than_120_columns() -> None:
    # Text files are exempt, because each text is one line.
    files = [path for kind in ("js", "css", "html") for path in LAB.glob(f"*.{kind}")]
    assert {"main.js", "page.html", "style.css"} <= {path.name for path in files}
    wide = {
        f"{path.name}:{number}"
        for path in files
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1)
        if len(line) > 120
    }
    assert wide == set()


@pytest.mark.parametrize("language", OTHERS)
def test_no_word_of_the_explanation_is_left_in_english_and_all_fits_a_phone(
    opened: OPEN, language: str
) -> None:
    page = explained(opened, locale=language, size=PHONE)
    texts = TEXTS[language]
    assert page.evaluate("document.documentElement.lang") == language
    # Every key that is used in words or drawings, on each screen and at both ends of its slider.
    heard = "old => say = (key, values) => (asked.add(key), old(key, values))"
    page.evaluate(f"asked = new Set(), ({heard})(say), 0")
    visible = "[...document.querySelectorAll('[data-say]')].filter(e => e.checkVisibility())"
    displayed: set[str] = set()
    for number in range(8):
        page.evaluate(f"explorable.go({number})")
        wait(page, "explorable.settled")
        fits_a_phone(page)
        page.evaluate("explorable.move(0)")
        wait(page, "explorable.settled")
        assert page.inner_text("#screen-title").startswith(texts["screen_step"].split("{")[0])
        displayed |= set(page.evaluate(f"{visible}.map(e => e.dataset.say)"))
    # Keys that were used while the page opened are found in the page's elements.
    labels = (
        "Object.values(explorable.figure.plots).flatMap((plot) => plot.axes.map((a) => a.label))"
    )
    saving = "document.querySelector('#screen-save .save').firstChild.data.trim()"
    standing = page.evaluate(f"[...{labels}, {saving}]")
    assert len(standing) == 7
    assert {*standing} <= {*texts.values()}
    asked = {*page.evaluate("[...asked]"), *(key for key in texts if texts[key] in standing)}
    assert {"piston", "force_axis", "screen_8"} <= asked
    assert {"view_laboratory", "language_choice"} <= displayed
    assert asked | displayed | {"title", "screen_failed"} <= texts.keys()
    # No other text is translated, since nobody would see it.
    drawn = {"casing", "drives", "vented", "lifts", "pause"}
    labels = set(
        re.findall(r'data-say-label="(screen_\w+)"', (LAB / "page.html").read_text("utf-8"))
    )
    assert texts.keys() == asked | displayed | drawn | labels | {
        "title",
        "language",
        "screen_failed",
    }


@pytest.mark.parametrize("language", OTHERS)
def test_the_laboratory_is_in_english_whatever_the_explanation_is_in(
    opened: OPEN, language: str
) -> None:
    page = explained(opened, 8, locale=language, size=PHONE)
    # Another language loads the page again, after the link's navigation within it.
    with page.expect_event("load"):
        page.locator("#screen-next").click()
    wait(page, "laboratory.settled || laboratory.failure")
    assert page.evaluate("document.documentElement.lang") == "en"
    assert page.inner_text("h1") == page.title() == ENGLISH["title_laboratory"]
    # A German reads 2.039 m/min as two thousand, an Englishman does not.
    speed = page.evaluate("laboratory.blows.at(-1).blow_speed")
    assert page.inner_text("#value-speed") == f"{speed:.4g} m/s"
    # A text with a wrong key or placeholder would be visible.
    text = page.inner_text("body")
    assert "undefined" not in text
    assert "{" not in text.split(ENGLISH["as_command"])[0]
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    assert judged(page)["violations"] == []


def test_the_language_is_chosen_and_the_screen_stays(opened: OPEN) -> None:
    page = explained(opened, 3, locale="pt")
    assert page.evaluate("LANGUAGE") == "en"
    with page.expect_navigation():
        page.get_by_label("Language").select_option("Deutsch")
    expect(page.locator("h1")).to_have_text(TEXTS["de"]["title"])
    expect(page.get_by_label(TEXTS["de"]["language_choice"])).to_have_value("de")
    expect(page.locator("#screen-title")).to_contain_text(TEXTS["de"]["screen_3_title"])


@pytest.mark.parametrize("language", OTHERS)
def test_numbers_are_written_as_the_language_writes_them(opened: OPEN, language: str) -> None:
    """A German reads 2.039 m/min as two thousand: both languages have a decimal comma."""
    page = explained(opened, locale=language)
    speed = page.evaluate("explorable.numbers.speed")
    assert f"{speed:.3g} m/s".replace(".", ",") in page.inner_text("#screen-text")
    assert page.evaluate("[digits(-1234.56, 6), fixed(0.5, 2)]") == ["\u22121234,56", "0,50"]
