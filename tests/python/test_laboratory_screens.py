"""The explanation: every number in it agrees with the long run, over the whole of each slider."""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from browsing import OPEN, PHONE, Pages, explained, fits_a_phone, wait
from dth_hammer import VARIABLES, Hammer, HammerWarning, Steady, steady
from dth_hammer.scene.variables import whole
from PIL import Image, ImageFilter
from playwright.sync_api import Locator, Page

FIGURE = "#explore [role=img]:visible"
SCREENS = range(1, 9)


@pytest.fixture(scope="module")
def page(pages: Pages, request: pytest.FixtureRequest) -> Iterator[Page]:
    """Opens a screen, once for all its tests, which ask the engine for the same scenes."""
    page = pages.open(f"#screen={request.param}", ready="explorable.settled")
    assert page.evaluate("explorable.failure ?? null") is None
    yield page
    pages.leave()


def of_screen(*numbers: int) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("page", numbers, indirect=True)


def numbers_at(page: Page, at: int) -> dict[str, float]:
    """Returns the numbers at a slider's position, which the text must have to three digits."""
    page.evaluate(f"explorable.move({at})")
    wait(page, "explorable.settled")
    assert page.evaluate("explorable.failure ?? null") is None
    numbers, text = page.evaluate("explorable.numbers"), page.inner_text("#screen-text")
    assert not re.search(r"[{}]|undefined|NaN", text)
    return dict(numbers)


def places(page: Page) -> list[int]:
    """Returns both ends of the slider and three positions between."""
    last = page.evaluate("explorable.screens[explorable.screen].places.length") - 1
    return [round(last * part) for part in (0.0, 0.25, 0.5, 0.75, 1.0)]


def pixels(picture: bytes) -> np.ndarray:
    """Returns the brightness of each pixel."""
    return np.asarray(Image.open(io.BytesIO(picture)).convert("L"), float)


def answer(page: Page, which: str = "values") -> Steady:
    """Returns the engine's long-run response of the screen's scene, with the page's settings."""
    ways = page.evaluate("explorable.screens[explorable.screen].of ?? MEAN_OF")
    values = page.evaluate(f"explorable.{which}")
    with warnings.catch_warnings():
        # Irregular hammers have means with the page's errors, which cause warnings.
        warnings.simplefilter("ignore", HammerWarning)
        return steady(values, error=ways["error"], blows=ways["blows"])


def share(mean: pd.Series) -> float:
    """Returns the percentage of a blow's energy that the rock takes."""
    put = mean["energy_drive"] + mean["energy_feed"] + mean["energy_gravity"]
    return float(100 * (mean["energy_rock_dissipated"] + mean["energy_viscous"]) / put)


def close(found: float, expected: float, part: float = 1e-9) -> None:
    """Compares results of two builds of the engine, by default up to the rounding of sums."""
    assert found == pytest.approx(expected, rel=part)


def rise(page: Page) -> float:
    """Returns the piston's highest rise above the bit, mm, in the engine's repeating cycle."""
    with Hammer(page.evaluate("explorable.answer.values"), quiet=True) as hammer:
        hammer.advance(0.2)
        heights, _ = hammer.run(0.2 + 1e-4 * np.arange(1, 500), ["relative_position"], {})
    return -1e3 * float(heights.min())


@of_screen(1)
def test_pressure_makes_more_and_harder_blows(page: Page) -> None:
    rows = []
    for at in places(page):
        numbers, mean = numbers_at(page, at), answer(page, "answer.values").mean
        for name, of in (
            ("speed", "blow_speed"),
            ("energy", "blow_energy"),
            ("times", "blow_frequency"),
        ):
            close(numbers[name], mean[of])
        close(numbers["energy"], 0.5 * numbers["mass"] * numbers["speed"] ** 2, 1e-3)
        close(numbers["height"], numbers["speed"] ** 2 / (2 * VARIABLES["gravity"].start))
        assert numbers["rise"] == pytest.approx(rise(page), rel=2e-3)
        rows.append([numbers[name] for name in ("bar", "speed", "energy", "times")])
    assert (np.diff(rows, axis=0) > 0).all()
    # The hammer's own pressure is 24 bar.
    assert numbers_at(page, 7)["times"] == pytest.approx(44, abs=0.5)


@of_screen(2)
def test_the_indicator_diagrams_area_is_the_drives_work(page: Page) -> None:
    numbers, mean = numbers_at(page, 60), answer(page, "answer.values").mean
    close(numbers["drive"], mean["energy_drive"])
    close(numbers["air"], 60 * mean["air_flow"])
    # A trapezoidal rule with 400 samples per period cuts the corners of the pressures.
    close(numbers["both"], numbers["above"] + numbers["below"])
    close(numbers["both"], numbers["drive"], 0.005)


@of_screen(3)
def test_a_blow_is_a_wave_no_faster_than_sound(page: Page) -> None:
    numbers, values = numbers_at(page, 30), page.evaluate("explorable.answer.values")
    modulus, density = (
        VARIABLES[f"material.{name}"].start for name in ("youngs_modulus", "density")
    )
    area, length = (values[f"bit.segment[1].{name}"] for name in ("area", "length"))
    wave = math.sqrt(modulus / density)
    # St-Venant: two bars of equal section share the speed.
    close(numbers["shock"], 0.5e-3 * area * math.sqrt(modulus * density) * numbers["speed"])
    # Feed and air also press on the faces: 12 and up to 6 kN, 18 of 773 kN.
    close(numbers["contact"], numbers["shock"], 18 / 773)
    close(numbers["arrives"], 0.5e6 * length / wave)
    # The contact's spring takes ln(2) A E / (2 K c) to half of the plateau: 0.84 us. Between
    # samples 2 us apart a front is not straight.
    late = 1e6 * math.log(2) * area * modulus / (2 * values["contact.stiffness"] * wave)
    assert numbers["felt"] == pytest.approx(numbers["arrives"] + late, abs=1.0)
    # Nothing precedes the front except its width, from damping and contact: three widths ahead,
    # less than a hundredth of it has arrived.
    stresses = """() => { const { time, impact, stress: [, bit] } = explorable.answer.cycle;
        const t = time.findIndex((t) => t >= impact + 2e-5);
        return [time[t] - impact, [...bit[t]], [...bit[t - 20]]]; }"""
    time, now, before = page.evaluate(stresses)
    middles = (np.arange(len(now)) + 0.5) * length / len(now)
    width = wave * math.sqrt(2 * values["material.damping_time"] * time)
    ahead = np.abs(np.subtract(now, before))[middles > wave * time + 3 * width]
    assert ahead.size > 5
    assert ahead.max() < 0.01 * 1e3 * numbers["shock"] / area


@of_screen(4)
def test_the_loops_area_is_the_work_that_the_rock_keeps(page: Page) -> None:
    numbers, mean = numbers_at(page, 60), answer(page, "answer.values").mean
    close(numbers["work"], mean["energy_rock_dissipated"] + mean["energy_viscous"])
    close(numbers["share"], 100 * numbers["work"] / mean["blow_energy"])
    # A trapezoidal rule misses the jump of the force where the rock changes its mode.
    close(numbers["loop"], numbers["work"], 0.01)


@of_screen(5)
def test_the_account_of_a_blow_closes(page: Page) -> None:
    pairs = []
    for at in places(page):
        numbers, mean = numbers_at(page, at), answer(page, "answer.values").mean
        parts = [numbers["drive"], numbers["feed"], numbers["rebound"]]
        close(numbers["given"], sum(parts))
        close(numbers["gone"], numbers["work"] + numbers["damping"] + numbers["rebound"])
        # The cycle repeats to 1e-9 of a blow, and so does the stored energy.
        close(numbers["given"], numbers["gone"], 1e-7)
        close(numbers["feed"], mean["energy_feed"] + mean["energy_gravity"])
        close(numbers["rebound"], 0.5 * numbers["mass"] * mean["rebound_speed"] ** 2)
        close(numbers["peak"], 1e-3 * mean["rock_force_peak"])
        pairs.append([numbers[name] for name in ("peak", "kept")])
    # The slider changes the bars by more than a tenth, and the peak fourfold.
    assert pairs[-1][0] > 3 * pairs[0][0]


@of_screen(6)
def test_the_rate_is_the_power_over_what_a_metre_takes(page: Page) -> None:
    factor = VARIABLES["rock.specific_energy_factor"].start
    for at in places(page):
        numbers, mean = numbers_at(page, at), answer(page, "answer.values").mean
        close(numbers["rate"], 3600 * mean["rop"])
        # The mean rate is the work over the time of all blows, which is the same for a repeating
        # hammer.
        close(numbers["predicted"], numbers["rate"], 1e-6)
        close(numbers["high"] / numbers["low"], factor**2, 0.01)
        close(numbers["power"], 1e-3 * numbers["work"] * mean["blow_frequency"])
        area, energy = 0.25e-6 * math.pi * numbers["diameter"] ** 2, 1e6 * numbers["metre"]
        values = page.evaluate("explorable.answer.values")
        close(energy, area * values["rock.specific_energy"])
        close(1e3 * numbers["power"] / energy, mean["rop"], 1e-6)
        # The text has two digits of the range's ends.
        close(numbers["low"], 3.6e6 * numbers["power"] / (1e6 * numbers["hard"] * area), 0.05)
        close(numbers["high"], 3.6e6 * numbers["power"] / (1e6 * numbers["easy"] * area), 0.05)


@of_screen(7)
def test_too_little_feed_lifts_the_hammer_off_and_the_rate_bends_at_a_knee(page: Page) -> None:
    rates, shares, held = {}, {}, answer(page, "hammer").mean
    for at in range(12):
        numbers, found = numbers_at(page, at), answer(page, "answer.values")
        kN = numbers["feed"]
        close(numbers["rate"], 3600 * found.mean["rop"])
        rates[kN] = numbers["rate"]
        shares[kN] = found.mean["energy_damping"] / found.mean["energy_drive"]
        close(numbers["held_rate"], 3600 * held["rop"])
        close(numbers["part"], 100 * found.mean["rop"] / held["rop"])
        turned = (held["blow_speed"] + held["rebound_speed"]) * held["blow_frequency"]
        close(numbers["push"], 1e-3 * numbers["mass"] * turned)
        close(numbers["least"], numbers["push"] - numbers["weight"])
    # The piston's impulses require the drive's mean force, which is read from the engine.
    read = """() => { const { cycle: c } = window.asked, [a, b] = periodOf(c);
        return areaUnder(c.applied_drive_force, c.time, [a, b]) / (c.time[b] - c.time[a]); }"""
    page.evaluate("explorable.ask('explore', explorable.hammer).then((a) => (window.asked = a)), 0")
    wait(page, "window.asked")
    # Speeds are relative to the bit, which moves by up to 0.4 of the 18.8 m/s of the piston's
    # reversal.
    weight = 1e-3 * numbers["mass"] * VARIABLES["gravity"].start
    close(1e-3 * page.evaluate(read), numbers["push"] - weight, 0.4 / 18.8)
    lifting = [rate for kN, rate in rates.items() if kN < numbers["least"]]
    # Below the knee the rate falls with the feed to a sixth, above it the rate hardly rises.
    assert [*rates.values()] == sorted(rates.values())
    assert lifting[0] < 0.2 * rates[12]
    assert lifting[-1] < 0.5 * rates[12]
    assert rates[12] < 1.05 * rates[9]
    assert rates[18] < 1.1 * rates[9]
    # If the casing is lifted, blows go into chuck and bit.
    assert min(shares[kN] for kN in (1.5, 3, 4.5)) > 3 * max(shares[kN] for kN in (9, 10.5, 12))


@of_screen(8)
def test_rods_take_their_share_and_a_hammer_down_the_hole_has_none(page: Page) -> None:
    rows, down_the_hole = [], share(answer(page, "hammer").mean)
    for at in (0, 2, 4):
        numbers = numbers_at(page, at)
        page.evaluate("explorable.loose = { ...explorable.answer.values, ...LOOSE }")
        for name, which in (("tight", "answer.values"), ("loose", "loose")):
            close(numbers[name], share(answer(page, which).mean))
        rows.append([numbers[name] for name in ("rods", "tight", "loose", "down")])
        given = whole(page.evaluate("explorable.answer.values"))
        bit = sum(given[f"bit.segment[{k}].length"] for k in (1, 2))
        rod = numbers["rods"] * given["drill.rod.length"]
        close(numbers["long"], given["drill.shank.length"] + rod + bit)
        assert numbers["down"] == pytest.approx(down_the_hole, rel=0.02)
    rods, tight, loose, down = np.array(rows).T
    assert [*rods] == [1, 3, 6]
    # The errors of the means are below two per cent.
    assert (np.diff(tight) < 2).all()
    assert (np.diff(loose) < 2).all()
    assert tight[-1] < tight[0] - 5
    assert (loose < tight + 1).all()
    assert (down > tight).all()


@of_screen(*SCREENS)
def test_the_handle_moves_its_figure_over_its_whole_range_and_it_is_saved_as_it_looks(
    page: Page,
) -> None:
    """Some pixels must change between neighbouring quarters of the slider."""
    pictures = []
    for at in places(page):
        numbers_at(page, at)
        pictures.append(pixels(page.locator(FIGURE).screenshot()))
    for one, other in pairwise(pictures):
        # A dot with a radius of 6 pixels, at two places, changes more than this.
        assert (np.abs(one - other) > 30).sum() > 60
    same(page, page.locator(FIGURE), page.locator("#explore"))


def test_a_curve_fills_by_itself(opened: OPEN) -> None:
    page = explained(opened, 7)
    numbers_at(page, 0)
    before = pixels(page.locator(FIGURE).screenshot())
    page.evaluate("delete explorable.ahead, explorable.ahead(6), 0")
    whole = "explorable.row.length === explorable.screens[6].places.length"
    assert not page.evaluate(whole)
    assert re.search(r"still being computed: \d+ of 12", page.inner_text("#screen-text"))
    wait(page, f"{whole} && explorable.at[6] === 0")
    assert "still being computed" not in page.inner_text("#screen-text")
    after = pixels(page.locator(FIGURE).screenshot())
    assert (np.abs(before - after) > 30).sum() > 60


def test_every_screen_fits_a_phone_and_axe_finds_nothing(opened: OPEN) -> None:
    page = explained(opened, size=PHONE)
    for number in SCREENS:
        page.evaluate(f"explorable.go({number - 1})")
        wait(page, "explorable.settled")
        fits_a_phone(page)


def test_it_plays_slowed_and_stops_and_the_keyboard_moves_it(opened: OPEN) -> None:
    page = opened("#screen=3", ready="explorable.settled", reduced_motion="no-preference")
    wait(page, "explorable.playing")
    place = page.evaluate("explorable.at[2]")
    wait(page, f"explorable.at[2] !== {place}")
    assert re.search(r"\d[,\d]* times", page.inner_text("#screen-slowed"))
    page.get_by_role("button", name="Pause").press("Enter")
    stopped = page.evaluate("explorable.at[2]")
    page.wait_for_timeout(200)
    assert page.evaluate("explorable.at[2]") == stopped
    before = page.inner_text("#screen-value")
    page.locator("#screen-handle").press("ArrowRight")
    wait(page, "explorable.settled")
    assert page.inner_text("#screen-value") != before
    with page.expect_download() as download:
        page.get_by_role("button", name="PNG").click()
    assert download.value.path().read_bytes().startswith(b"\x89PNG")
    page.locator("#screen-next").press("Enter")
    wait(page, "explorable.settled && explorable.screen === 3")
    assert page.evaluate("location.hash") == "#screen=4"


def saved(page: Page, row: Locator, kind: str) -> bytes:
    with page.expect_download() as download:
        row.get_by_role("button", name=kind).click()
    return download.value.path().read_bytes()


def same(page: Page, figure: Locator, row: Locator) -> None:
    """Checks that both files of a figure look like it, except for smoothed letters and edges."""
    page.evaluate("document.fonts.ready.then(() => 0)")
    expected = pixels(figure.screenshot())
    other = page.context.new_page()
    other.set_viewport_size({"width": expected.shape[1], "height": expected.shape[0]})
    drawing = saved(page, row, "SVG").decode("utf-8")
    other.set_content(f"<style>body {{ margin: 0 }} svg {{ display: block }}</style>{drawing}")
    whole = Image.open(io.BytesIO(saved(page, row, "PNG")))
    half = whole.resize((whole.width // 2, whole.height // 2), Image.Resampling.BOX)
    for found in (pixels(other.screenshot()), np.asarray(half.convert("L"), float)):
        rows, columns = (min(sides) for sides in zip(found.shape, expected.shape, strict=True))
        one, two = (lines[:rows, :columns] < 200 for lines in (found, expected))
        # Each line and letter has its counterpart within two pixels, except for some that are
        # smoothed otherwise.
        for here, there in ((one, two), (two, one)):
            wide = Image.fromarray(there).convert("L").filter(ImageFilter.MaxFilter(5))
            assert (here & (np.asarray(wide) == 0)).sum() < 0.05 * here.sum()
    other.close()


def test_every_figure_of_the_laboratory_is_saved_as_it_looks(opened: OPEN) -> None:
    page = opened("#rock.stiffness=2e8")
    page.evaluate("curves.find('curve-over').value = 'feed_force', curves.start()")
    wait(page, "!curves.busy")
    figures = page.locator("#laboratory [role=img]").all()
    assert len(figures) == 11
    for figure in figures:
        same(page, figure, figure.locator("xpath=following-sibling::span[1]"))
