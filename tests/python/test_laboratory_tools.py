"""The laboratory's pictures and tools agree with the FMU."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from browsing import OPEN, PHONE, blows, choose, settled, wait
from dth_hammer import Hammer
from fmu import Instance, Package
from playwright.sync_api import Page, expect

PIXELS = """([id, x, y, width, height]) => {
    const canvas = document.getElementById(id), scale = devicePixelRatio;
    const [left, top, w, h] = [x, y, width, height].map((n) => Math.round(n * scale));
    const copy = new OffscreenCanvas(w, h).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, -left, -top);
    return Array.from(copy.getImageData(0, 0, w, h).data);
}"""
MINUS = "\N{MINUS SIGN}"
HOLE = {"hole.diameter": 0.09, "piston.elements": 8, "bit.elements": 8}


def pixels(page: Page, *where: Any) -> np.ndarray:
    """Returns red, green, blue and opacity, one row per pixel."""
    return np.reshape(page.evaluate(PIXELS, [*where]), (-1, 4))


def link(values: dict[str, float]) -> str:
    return "#" + "&".join(f"{name}={value}" for name, value in values.items())


def still(page: Page, time: float) -> int:
    """Stops the page at a time after the impact (s), and returns the index of the sample."""
    page.evaluate("time => { play(false); player.goTo(time); picture(); }", time)
    index = page.evaluate("player.index")
    assert page.evaluate("laboratory.shown") == index
    return int(index)


def test_the_gap_in_the_picture_is_the_fmus(opened: OPEN, package: Package) -> None:
    page = opened()
    index = still(page, 0.02)
    time = page.evaluate("laboratory.cycle.time[player.index]")
    with Instance(package) as hammer:
        hammer.advance(time)
        gap = hammer.get("contact_gap")
    assert gap > 0.05
    assert index > 0
    # A line down the axis, without names or arrows on it.
    height = page.evaluate("drawing.canvas.clientHeight")
    column = pixels(page, "hammer", page.evaluate("drawing.middle"), 0, 1, height)[:, :3]
    # The chamber below the piston has one colour, which the bodies do not have.
    top, end = page.evaluate("drawing.tops(player.index).map(top => drawing.place(top))")
    piston = page.evaluate(
        "drawing.place(drawing.tops(player.index)[0] + drawing.bodies[0].length)"
    )
    chamber = column[round(0.5 * (piston + end))]
    empty = np.flatnonzero((column == chamber).all(axis=1) & (np.arange(height) > top + 3))
    stretches = np.split(empty, np.flatnonzero(np.diff(empty) > 1) + 1)
    low, high = page.evaluate("drawing.span")
    # Each body has an outline of 2 pixels, half of it outside, and edges fall between pixels.
    longest = max(len(stretch) for stretch in stretches)
    assert longest == pytest.approx(gap * height / (high - low) - 2, abs=2)


def test_the_wave_diagram_is_the_fmus(opened: OPEN, package: Package) -> None:
    page = opened()
    still(page, 0.02)
    frame = page.evaluate("waves.frame()")
    left, top = frame["left"], frame["top"]
    width, height = frame["right"] - left, frame["bottom"] - top
    limit = page.evaluate("waves.limit")
    colours = page.evaluate("stressColours(palette.paper)")
    times = np.array(page.evaluate("Array.from(laboratory.cycle.time)"))
    after = times - page.evaluate("laboratory.cycle.impact")
    colours_met = set()
    spans = int(package.start("piston.elements"))
    with Hammer() as hammer:
        for column in range(20, int(width), 41):
            moment = -3e-5 + (column + 0.5) / width * 6.2e-4
            sample = np.flatnonzero(after <= moment).max()
            hammer.advance(times[sample])
            for row in range(7, int(height), 37):
                place = (row + 0.5) / height * 2 * spans  # of both bodies, of one length
                if abs(place - round(place)) < 0.1:
                    continue
                body, element = divmod(int(place), spans)
                stress = hammer[f"{('piston', 'bit')[body]}_stress[{element + 1}]"]
                part = max(-1.0, min(1.0, stress / limit))
                expected = colours[100 + math.floor(100 * part + 0.5)]
                found = pixels(page, "waves", left + column, top + row, 1, 1)[0, :3]
                assert list(found) == expected
                colours_met.add(tuple(expected))
    assert len(colours_met) > 30


def test_pointing_at_a_wave_shows_the_hammer_at_that_moment(opened: OPEN, package: Package) -> None:
    page = opened()
    resting = still(page, 0.02)
    canvas = page.locator("#waves")
    canvas.scroll_into_view_if_needed()
    frame = page.evaluate("waves.frame()")
    place = {
        "x": frame["left"] + 0.2 * (frame["right"] - frame["left"]),
        "y": 0.7 * frame["bottom"],
    }
    canvas.hover(position=place)
    pointed = page.evaluate("laboratory.shown")
    assert pointed != resting
    time, impact = page.evaluate(
        "i => [laboratory.cycle.time[i], laboratory.cycle.impact]", pointed
    )
    # Samples are 2 microseconds apart, and a pixel is less.
    assert time - impact == pytest.approx(-3e-5 + 0.2 * 6.2e-4, abs=3e-6)
    reading = page.inner_text("#wave-text")
    below = float(reading.split("impact, ")[1].split()[0])
    with Hammer() as hammer:
        hammer.advance(time)
        span = 1e3 * package.start("bit.length") / package.start("bit.elements")
        stress = hammer[f"bit_stress[{int(below / span) + 1}]"]
    number = float(reading.rsplit(": ", 1)[1].split()[0].replace(MINUS, "-"))
    assert number == pytest.approx(1e-6 * stress, rel=5e-3)
    page.mouse.move(0, 0)
    assert page.evaluate("laboratory.shown") == pointed or page.evaluate("player.index") == resting
    canvas.click(position=place)
    page.mouse.move(0, 0)
    assert page.evaluate("[player.index, laboratory.shown]") == [pointed, pointed]


def test_slow_motion_follows_the_blow(opened: OPEN) -> None:
    """Waves are played at the chosen pace, and whole cycles within seconds."""
    page = opened()
    page.evaluate("play(false)")
    spent = """follow => {
        player.hurry = follow;
        player.timeScale = 2e-4;
        Object.assign(player, { index: 0, rest: 0 });
        const { time, impact } = player.cycle, step = 1 / 60;
        let [inside, all] = [0, 0];
        do {
            const t = time[player.index] - impact;
            if (t >= 0 && t < 5e-4) inside += step;
            all += step;
            player.advance(step);
        } while (player.index > 0 || all < 1);
        return [inside, all];
    }"""
    inside, whole = page.evaluate(spent, True)
    # 0.5 ms at 0.2 ms per second, to one frame at each end.
    assert inside == pytest.approx(2.5, abs=2 / 60)
    inside, everything = page.evaluate(spent, False)
    assert inside == pytest.approx(2.5, abs=2 / 60)
    assert everything > page.evaluate("laboratory.cycle.period") / 2e-4
    # Two collisions with their waves are a hundredth of the cycle. Together with the fast flights
    # they take a tenth of the time.
    assert whole < 0.1 * everything


def test_a_curve_is_of_the_long_run(opened: OPEN, package: Package) -> None:
    """If a hammer repeats its blows, the means are those of the settled FMU."""
    mesh = {"piston.elements": 8, "bit.elements": 8}
    page = opened(link(mesh))
    page.locator("#curve-over").select_option("feed_force")
    page.get_by_role("button", name="Draw", exact=True).click()
    wait(page, "curves.points.length > 0 && !curves.busy")
    points = page.evaluate("curves.points")
    assert len(points) == 17
    assert not any("failure" in point for point in points)
    assert [point["value"] for point in points if point["now"]] == [package.start("feed_force")]
    cycles = [point for point in points if point["response"] == "cycle"]
    assert len(cycles) > 3
    for point in cycles[:: len(cycles) // 3]:
        with Instance(package, {**mesh, "feed_force": point["value"]}) as hammer:
            hammer.advance(6.0)
            advance = period = 0.0
            repeat = int(point["returns"])
            for _ in range(4 * repeat):
                count = hammer.get("blow_count")
                while hammer.get("blow_count") == count:
                    hammer.advance(hammer.time + 1e-3)
                more = hammer.read(["blow_penetration", "blow_period"])
                advance, period = advance + more[0], period + more[1]
        # The cycle is solved for, and a run of six seconds agrees to 1e-4.
        assert point["mean"]["period"] == pytest.approx(period / (4 * repeat), rel=1e-4)
        assert point["mean"]["tip_rate"] == pytest.approx(advance / period, rel=1e-4)
        assert point["error"]["tip_rate"] == 0
    page.locator("#curve-of").select_option("blow_frequency")
    drawn = page.evaluate("[curves.plot.data[0], curves.plot.data[3]].map(l => Array.from(l))")
    known = [point for point in points if point["response"] != "stalled"]
    assert drawn[0] == pytest.approx([1e-3 * point["value"] for point in known], rel=1e-12)
    assert drawn[1] == [point["mean"]["blow_frequency"] for point in known]


def test_the_rate_over_a_setting_is_that_of_the_hole(opened: OPEN) -> None:
    """`4 P / (pi D^2 E_v)` in m/h."""
    page = opened(link({**HOLE, "fidelity": 1}))
    drawn = "[curves.plot.data[0], curves.plot.data[3]].map(l => Array.from(l))"
    for energy in (200e6, 399e6):
        page.evaluate("value => change('rock.specific_energy', value)", energy)
        page.locator("#curve-over").select_option("drive.amplitude")
        page.get_by_role("button", name="Draw", exact=True).click()
        wait(page, "curves.points.length > 0 && !curves.busy")
        means = [p["mean"] for p in page.evaluate("curves.points") if p["response"] != "stalled"]
        assert len(means) > 10
        power = [(m["energy_rock_dissipated"] + m["energy_viscous"]) / m["period"] for m in means]
        hole = [3600 * 4 * p / (math.pi * 0.09**2 * energy) for p in power]
        # The tolerance is the rounding of sums of some thousand differences of lengths.
        assert page.evaluate(drawn)[1] == pytest.approx(hole, rel=1e-9)
        assert page.evaluate("curves.plot.axes[1].label").endswith("(m/h)")


def test_a_setting_that_cannot_be_is_a_gap_in_the_curve(opened: OPEN) -> None:
    page = opened("#rock.unloading_ratio=1.5")
    page.locator("#curve-over").select_option("rock.unloading_ratio")
    page.evaluate("SLIDERS.group_rock[1][1].factor = 8")  # from 0.5: below 1 it is refused
    page.get_by_role("button", name="Draw", exact=True).click()
    wait(page, "curves.points.some(point => point.failure) && curves.points.some(p => p.mean)")
    failures = page.evaluate("curves.points.filter(p => p.failure).map(p => [p.value, p.failure])")
    assert all(value <= 1 and "rock.unloading_ratio" in text for value, text in failures)
    # Started and stopped in one task of the page, so that no worker can have finished.
    wait(page, "!curves.busy")
    page.locator("#curve-start").evaluate("button => { button.click(); button.click(); }")
    expect(page.locator("#curve-status")).to_contain_text("Stopped")


def test_what_was_before_is_shown_beside_it(opened: OPEN, package: Package) -> None:
    page = opened()
    choose(page, "overdamped")
    start, other = blows(package, {})[-1], page.evaluate("laboratory.blows.at(-1)")
    change = 100 * (other["blow_energy"] / start["blow_energy"] - 1)
    difference = page.inner_text("#was-energy").split()[0].replace(MINUS, "-")
    # The page shows it to a tenth of a per cent.
    assert float(difference) == pytest.approx(change, abs=0.0501)
    ghost = page.evaluate("past.ghost().rows")
    assert ghost == blows(package, {})
    assert page.evaluate("charts.energy.data[1]") == [row["blow_energy"] for row in ghost]
    assert len(page.evaluate("charts.loops.data[1][0]")) > 100


def test_a_is_kept_and_swapped_with_b(opened: OPEN) -> None:
    page = opened()
    page.get_by_role("button", name="Keep as A").click()
    choose(page, "overdamped")
    choose(page, "long_bit")
    assert page.evaluate("past.ghost().link") == ""
    page.get_by_role("button", name="Swap with A").click()
    settled(page)
    assert page.get_by_label("Preset").input_value() == "reference"
    second = page.evaluate(
        "new URLSearchParams(Object.entries(scene.presets.long_bit.start_values)).toString()"
    )
    assert page.evaluate("past.ghost().link") == second
    page.get_by_role("button", name="Let A go").click()
    expect(page.get_by_role("button", name="Keep as A")).to_be_visible()


def test_undo_goes_back_change_by_change(opened: OPEN) -> None:
    page = opened()
    undo, redo = (page.get_by_role("button", name=name, exact=True) for name in ("Undo", "Redo"))
    assert undo.is_disabled()
    assert redo.is_disabled()
    page.get_by_label("Preset").select_option("overdamped")
    page.wait_for_timeout(800)
    slider = page.get_by_label("Feed force", exact=True)
    # Moving a slider once is one change.
    pull = "s.stepUp(); s.dispatchEvent(new Event('input', { bubbles: true }));"
    slider.evaluate(f"s => {{ for (let k = 0; k < 8; k++) {{ {pull} }} }}")
    pulled = page.evaluate("scene.link()")
    undo.click()
    assert page.get_by_label("Preset").input_value() == "overdamped"
    page.keyboard.press("Control+z")
    assert page.evaluate("scene.changed") == {}
    assert undo.is_disabled()
    redo.click()
    redo.click()
    assert page.evaluate("scene.link()") == pulled
    assert redo.is_disabled()
    settled(page)


def test_a_preset_keeps_its_name_in_the_command(opened: OPEN) -> None:
    page = opened()
    command = page.locator("#command")
    expect(command).to_have_text("dth-hammer run")
    page.get_by_label("Preset").select_option("air_6_inch")
    expect(command).to_have_text("dth-hammer run air_6_inch")
    # Sliders refer to this hammer: the middle of the feed's is its own feed, the end twice that.
    feed = page.get_by_label("Feed force", exact=True)
    own = page.evaluate("scene.get('feed_force')")
    assert feed.input_value() == "0"
    feed.press("End")
    assert page.evaluate("scene.get('feed_force')") == pytest.approx(2 * own, rel=1e-3)
    page.get_by_label("Feed force, kN").fill("9")
    page.keyboard.press("Tab")
    expect(command).to_have_text("dth-hammer run air_6_inch --set feed_force=9000")
    assert page.locator("#preset option:checked").inner_text() == "air 6 inch, changed"
    # The engine's own value differs from the preset's.
    diameter = page.evaluate("scene.variable('hole.diameter').start")
    page.get_by_label("Diameter of the hole, mm").fill(str(diameter))
    page.keyboard.press("Tab")
    expect(command).to_contain_text("--set hole.diameter=0")
    settled(page)


def test_on_a_phone_the_numbers_stay_in_sight_of_every_slider(opened: OPEN) -> None:
    page = opened(size=PHONE)
    sliders = page.locator("#sliders input[type=range]:visible")
    assert sliders.count() > 10
    for slider in sliders.all():
        slider.focus()
        top = """e => {
            const box = e.getBoundingClientRect();
            const at = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
            return [at === e, document.querySelector(".numbers").getBoundingClientRect().y];
        }"""
        slider.evaluate("e => e.scrollIntoView({ block: 'nearest' })")
        free, numbers = slider.evaluate(top)
        name = slider.get_attribute("id")
        assert free, f"{name} is covered"
        assert 0 <= numbers < PHONE[1] / 2, f"the numbers are not in sight of {name}"


def test_who_wants_less_motion_gets_a_still_picture(opened: OPEN) -> None:
    page = opened()
    frames = page.evaluate("laboratory.frames")
    page.wait_for_timeout(400)
    assert page.evaluate("laboratory.frames") == frames
    expect(page.get_by_role("button", name="Play")).to_be_visible()


def test_what_the_engine_only_notes_is_no_warning(opened: OPEN) -> None:
    page = opened()
    assert page.locator("#warnings").is_hidden()
    # A contact far stiffer than an element causes a warning (`hammer`, the machine's warnings).
    page = opened("#contact.stiffness=1e13")
    expect(page.locator("#warnings")).to_contain_text("contact.stiffness")


def test_colours_follow_the_system(opened: OPEN) -> None:
    page = opened()
    light = pixels(page, "hammer", 60, 5, 40, 8).mean(axis=0)
    page.emulate_media(color_scheme="dark")
    wait(page, "palette.paper !== '#ffffff'")
    page.wait_for_timeout(100)
    dark = pixels(page, "hammer", 60, 5, 40, 8).mean(axis=0)
    assert light[:3].mean() > dark[:3].mean() + 80
