"""The laboratory in a browser, opened and watched; skipped by name where there is none."""

from __future__ import annotations

import re
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from fmu import Instance, Package
from playwright.sync_api import Browser, Page, Route, sync_playwright

# First the one without windows of its own: pages cost two thirds of the processor's time there.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
# What a machine without network, sound, or a user of its own needs.
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    # The engine is compiled for speed only where it runs for long, as in some tests.
    "--js-flags=--wasm-tiering-budget=104000000",
)
PAGE = Path(__file__).parents[2] / "dist" / "lab" / "index.html"
DESK, PHONE = (1280, 900), (390, 844)
# As the page looks at a scene: see lab/worker.js.
LOOK, BLOWS, LONGEST = 1e-3, 30, 4.0
OF_BLOW = ["blow_time", "blow_speed", "blow_energy", "blow_period", "blow_penetration", "rop"]
OF_BLOW += ["tip_rate", "air_flow"]
OPEN = Callable[..., Page]
# Ten pictures a second, since software paints them. The explanation computes no place of its handle
# before it is moved there.
SELDOM = """
const drawn = requestAnimationFrame;
window.requestAnimationFrame = (draw) => setTimeout(() => drawn(draw), 100);
Object.defineProperty(window, "explorable", { configurable: true, set(made) {
    Object.defineProperty(window, "explorable", { value: Object.assign(made, { ahead: () => 0 }) });
} });
"""


def chromium() -> str:
    """The browser; a test is skipped where there is none."""
    path = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if path is None:
        pytest.skip("no browser: apt install chromium")
    return path


class Silent(SimpleHTTPRequestHandler):
    """Serves, and says nothing."""

    def log_message(self, *_: object) -> None: ...


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The address of a folder over http."""
    handler = partial(Silent, directory=str(folder))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as listening:
        thread = threading.Thread(target=listening.serve_forever, daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{listening.server_port}"
        finally:
            listening.shutdown()
            thread.join()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    path = chromium()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(QUIET))
        yield browser
        browser.close()


class Pages:
    """Opens the laboratory, in pages used again: a new one's process costs as much as all in it."""

    def __init__(self, browser: Browser) -> None:
        self.browser = browser
        self.idle: dict[tuple[str, str], list[Page]] = {}
        self.used: list[tuple[tuple[str, str], Page]] = []
        self.complaints: list[str] = []

    def refuse(self, route: Route) -> None:
        self.complaints.append(f"asked for {route.request.url}")
        route.abort()

    def new(self, home: str, locale: str) -> Page:
        context = self.browser.new_context(locale=locale)
        context.add_init_script(SELDOM)
        server = home.rsplit("/", 1)[0]
        context.route(re.compile(rf"^(?!{re.escape(server)}|blob:|data:)"), self.refuse)
        page = context.new_page()
        page.on("console", lambda line: self.complaints.append(line.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        return page

    def open(
        self,
        link: str = "#laboratory",
        *,
        size: tuple[int, int] = DESK,
        home: str = PAGE.as_uri(),
        ready: str = "laboratory.settled || laboratory.failure",
        locale: str = "en-US",
        color_scheme: Any = "light",
        reduced_motion: Any = "reduce",
    ) -> Page:
        """From disk if not asked otherwise; waits until the scene has settled."""
        idle = self.idle.setdefault((home, locale), [])
        page = idle.pop() if idle else self.new(home, locale)
        self.used.append(((home, locale), page))
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.emulate_media(color_scheme=color_scheme, reduced_motion=reduced_motion)
        page.goto(home + link)
        wait(page, ready)
        page.evaluate("document.querySelectorAll('.panel').forEach((panel) => (panel.open = true))")
        return page

    def leave(self, before: int = 0) -> None:
        """Ends what runs in all pages after the first ones, which had nothing to complain of."""
        while len(self.used) > before:
            kind, page = self.used.pop()
            page.goto("about:blank")
            self.idle[kind].append(page)
        complaints, self.complaints = self.complaints, []
        assert complaints == []


@pytest.fixture(scope="module")
def pages(browser: Browser) -> Pages:
    if not PAGE.is_file():
        pytest.skip("dist/lab/index.html is not built: `cargo lab` says what is missing")
    return Pages(browser)


@pytest.fixture
def opened(pages: Pages) -> Iterator[OPEN]:
    """Opens pages for one test."""
    before = len(pages.used)
    yield pages.open
    pages.leave(before)


def wait(page: Page, condition: str) -> None:
    """Until a condition holds. Playwright would wait by `eval`, which the policy forbids."""
    # Time enough for a machine that has other things to do; no test waits longer than needed.
    end = time.monotonic() + 120.0
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"{condition}: not within two minutes"
        page.wait_for_timeout(100)


def settled(page: Page) -> Page:
    wait(page, "laboratory.settled || laboratory.failure")
    return page


# Few elements, and means of few blows, for tests that look at words and places alone.
COARSE = """() => {
    Object.assign(explorable.hammer, { "mesh.degree": 1, "piston.elements": 8, "bit.elements": 8 });
    for (const of of [MEAN_OF, MEAN_OF_RODS]) Object.assign(of, { error: 0.5, blows: 12 });
}"""


def explained(opened: OPEN, number: int = 1, **more: Any) -> Page:
    """The explanation, with scenes that take little time."""
    page = opened(f"#screen={number}", ready="explorable.settled", **more)
    page.evaluate(COARSE)
    return page


def choose(page: Page, preset: str) -> Page:
    page.get_by_label("Preset").select_option(preset)
    return settled(page)


def judged(page: Page) -> dict[str, Any]:
    """What axe finds: every place of a violation, one of what passes."""
    return Axe().run(page, options={"resultTypes": ["violations"]}).response


def in_both_schemes(page: Page) -> Iterator[dict[str, Any]]:
    """What axe finds in dark and in light colours."""
    for scheme, paper in (("dark", "!=="), ("light", "===")):
        page.emulate_media(color_scheme=scheme)
        wait(page, f"palette.paper {paper} '#ffffff'")
        yield judged(page)


def fits_a_phone(page: Page) -> None:
    """All of what is explained is on a phone's screen, and axe finds nothing."""
    size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    width, height = page.evaluate(size)
    assert width <= PHONE[0]
    assert height <= PHONE[1]
    assert judged(page)["violations"] == []


def blows(package: Package, values: dict[str, float]) -> list[dict[str, float]]:
    """What the FMU says of each blow, asked as the page asks."""
    rows: list[dict[str, float]] = []
    with Instance(package, values) as hammer:
        for look in range(1, round(LONGEST / LOOK) + 1):
            if len(rows) == BLOWS:
                break
            hammer.advance(look * LOOK)
            if hammer.get("blow_count") > len(rows):
                rows.append(dict(zip(OF_BLOW, hammer.read(OF_BLOW), strict=True)))
    return rows
