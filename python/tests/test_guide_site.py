"""The guide in a browser, from a disk and from a server; skipped where there is no chromium."""

import contextlib
import importlib
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Literal
from urllib.parse import unquote, urlsplit

import pytest
from browsing import browser, judged, served
from playwright.sync_api import Browser, TimeoutError, expect

__all__ = ["browser"]
#: Links by which a page would load something from elsewhere.
ELSEWHERE = re.compile(r"<(?:script|link|img|iframe)\b[^>]*(?:src|href)=\"(https?:[^\"]*)")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Builds the guide as `cargo docs` does, but runs no code and draws nothing."""
    builder = importlib.import_module("build")
    folder = tmp_path_factory.mktemp("guide")
    builder.gather(folder / "pages")
    builder.complete(folder / "pages", lambda: "")
    # Figures are missing here, so broken links are no errors.
    builder.build_site(folder / "pages", folder / "site", strict=False)
    return folder / "site"


class Links(HTMLParser):
    """The links of a page."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        target = found.get("href") if tag in ("a", "link") else found.get("src")
        if target and tag != "img":
            self.found.append(target)


def test_every_link_is_a_file_that_is_there(site: Path) -> None:
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 15
    for page in pages:
        if page.name == "404.html" or "lab" in page.parts:
            continue
        for link in Links(page).found:
            parts = urlsplit(link)
            if parts.scheme in ("http", "https", "data", "mailto") or not parts.path:
                continue
            target = (page.parent / unquote(parts.path)).resolve()
            assert target.is_file(), f"{page.name}: {link}"


def test_nothing_but_links_to_read_leads_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert ELSEWHERE.findall(text) == [], page.name


@pytest.fixture(scope="module")
def server(site: Path) -> Iterator[str]:
    with served(site) as home:
        yield home


@pytest.mark.parametrize("way", ["disk", "server"])
def test_the_search_finds_and_nothing_is_asked_of_others(
    browser: Browser, site: Path, server: str, way: str
) -> None:
    home = site.as_uri() if way == "disk" else server
    page = browser.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(f"{home}/index.html")
    result = page.locator("a.md-search-result__link", has_text="From a datasheet").first
    # Keys before the page's script listens are lost, so the test types again on a slow machine.
    for _ in range(12):
        page.get_by_placeholder("Search").first.fill("")
        page.get_by_placeholder("Search").first.press_sequentially("datasheet")
        with contextlib.suppress(TimeoutError):
            result.wait_for(timeout=10_000)
            break
    expect(result).to_be_visible()
    result.click()
    expect(page.get_by_role("heading", name="From a datasheet", level=1)).to_be_visible()
    assert [url for url in asked if not url.startswith((home, "data:", "blob:"))] == []
    page.close()


#: One page of each kind: equations, wide tables, generated pages.
PAGES = (
    *("index", "theory-modes", "theory-drive", "datasheet", "limits", "outputs", "presets", "cite"),
    *("python", "python-simulate", "variables", "variables-drive", "faq", "gallery"),
)


@pytest.mark.parametrize("width", [1280, 390])
def test_equations_are_whole_and_no_page_is_wider_than_its_window(
    browser: Browser, site: Path, width: int
) -> None:
    page = browser.new_page(viewport={"width": width, "height": 900})
    for name in PAGES:
        page.goto((site / f"{name}.html").as_uri())
        wide = page.evaluate("document.documentElement.scrollWidth")
        assert wide <= width, name
        cut = page.evaluate(
            "[...document.querySelectorAll('math[display=block]')]"
            ".filter(m => m.scrollWidth > m.clientWidth).map(m => m.textContent)"
        )
        # On a phone a long equation may scroll by itself.
        assert width < 1000 or cut == [], name
    page.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(
    browser: Browser, site: Path, scheme: Literal["light", "dark"]
) -> None:
    page = browser.new_page(viewport={"width": 1280, "height": 900}, color_scheme=scheme)
    found = {}
    for name in ("index", "theory-modes", "datasheet", "python-simulate", "presets", "gallery"):
        page.goto((site / f"{name}.html").as_uri())
        for row in judged(page)["violations"]:
            if row["impact"] in ("serious", "critical"):
                found[name, row["id"]] = [node["html"][:200] for node in row["nodes"][:3]]
    assert found == {}
    page.close()
