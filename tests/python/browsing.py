"""The laboratory in a browser, for tests, which are skipped if there is no browser."""

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

# The first one has no windows of its own, so its pages cost two thirds of the processor's time.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
# Options for a machine without network, sound, or a user of its own.
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
    # The engine is compiled for speed only if it runs for long, as in some tests.
    "--js-flags=--wasm-tiering-budget=104000000",
)
PAGE = Path(__file__).parents[2] / "dist" / "lab" / "index.html"
DESK, PHONE = (1280, 900), (390, 844)
# The page's settings, from lab/worker.js.
LOOK, BLOWS, LONGEST = 1e-3, 30, 4.0
OF_BLOW = ["blow_time", "blow_speed", "blow_energy", "blow_period", "blow_penetration", "rop"]
OF_BLOW += ["tip_rate", "air_flow"]
OPEN = Callable[..., Page]
# Ten pictures per second, because software paints them. The explanation does not compute the other
# positions of its slider in advance.
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
    """A server without log messages."""

    def log_message(self, *_: object) -> None: ...


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serves a folder over http, and yields its address."""
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
    """Opens the laboratory in reused pages, since a new page costs as much as its work."""

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
        """Opens it, by default from disk, and waits until the scene has settled."""
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
        """Stops everything in the pages after the first ones, which must be free of errors."""
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
    """Opens pages for one test, and leaves them at its end."""
    before = len(pages.used)
    yield pages.open
    pages.leave(before)


def wait(page: Page, condition: str) -> None:
    """Waits for a condition without Playwright's `eval`, which the page's policy forbids."""
    # The limit suits a busy machine; no test waits longer than it needs to.
    end = time.monotonic() + 120.0
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"{condition}: not within two minutes"
        page.wait_for_timeout(100)


def settled(page: Page) -> Page:
    wait(page, "laboratory.settled || laboratory.failure")
    return page


# Few elements, and means of few blows, for tests that only check words and places.
COARSE = """() => {
    Object.assign(explorable.hammer, { "mesh.degree": 1, "piston.elements": 8, "bit.elements": 8 });
    for (const of of [MEAN_OF, MEAN_OF_RODS]) Object.assign(of, { error: 0.5, blows: 12 });
}"""


def explained(opened: OPEN, number: int = 1, **more: Any) -> Page:
    """Opens the explanation, with scenes that take little time."""
    page = opened(f"#screen={number}", ready="explorable.settled", **more)
    page.evaluate(COARSE)
    return page


def choose(page: Page, preset: str) -> Page:
    page.get_by_label("Preset").select_option(preset)
    return settled(page)


def judged(page: Page) -> dict[str, Any]:
    """Returns the findings of axe: every place of a violation, one place of each passed rule."""
    return Axe().run(page, options={"resultTypes": ["violations"]}).response


def in_both_schemes(page: Page) -> Iterator[dict[str, Any]]:
    """Runs axe in dark and in light colours."""
    for scheme, paper in (("dark", "!=="), ("light", "===")):
        page.emulate_media(color_scheme=scheme)
        wait(page, f"palette.paper {paper} '#ffffff'")
        yield judged(page)


def fits_a_phone(page: Page) -> None:
    """Checks that the whole explanation fits on a phone's screen, and that axe finds nothing."""
    size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    width, height = page.evaluate(size)
    assert width <= PHONE[0]
    assert height <= PHONE[1]
    assert judged(page)["violations"] == []


def blows(package: Package, values: dict[str, float]) -> list[dict[str, float]]:
    """Returns the FMU's outputs at each blow, read in the page's steps."""
    rows: list[dict[str, float]] = []
    with Instance(package, values) as hammer:
        for look in range(1, round(LONGEST / LOOK) + 1):
            if len(rows) == BLOWS:
                break
            hammer.advance(look * LOOK)
            if hammer.get("blow_count") > len(rows):
                rows.append(dict(zip(OF_BLOW, hammer.read(OF_BLOW), strict=True)))
    return rows
