"""Figures: the quantities on the axes, with their units."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import matplotlib.image as mpimg
import numpy as np
import pytest
from dth_hammer import DthHammerError, Hammer, Run, figures, simulate, steady
from dth_hammer.errors import TooFewBlowsError
from dth_hammer.figures import marks
from dth_hammer.figures.dark import ON_COLOUR
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text


@pytest.fixture(scope="module")
def cycle() -> Run:
    return figures.settled_cycle(until=0.25, fine=1e-5)


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(until=0.4)


def labels(figure: Figure) -> list[str]:
    axes = figure.get_axes()
    return [text for a in axes for text in (a.get_xlabel(), a.get_ylabel()) if text]


@pytest.mark.parametrize("draw", [figures.cycle, figures.rock_cycles])
def test_figures_of_a_cycle_have_units_and_say_what_they_need(
    draw: Callable[[Run], Figure], cycle: Run, run: Run, tmp_path: Path
) -> None:
    figure = draw(cycle)
    figure.savefig(tmp_path / "figure.png", dpi=40)
    assert all("(" in label or "mode" in label for label in labels(figure))
    with pytest.raises(DthHammerError, match="give it what settled_cycle makes"):
        draw(run)


def test_a_cycle_starts_at_its_impact_and_lasts_a_period(cycle: Run) -> None:
    period = cycle.notes["period"]
    assert cycle.time[0] < 0.0 < period < cycle.time[-1]
    forces = cycle["contact_force"]
    assert forces[cycle.time < -1e-5].max() == 0.0
    assert forces[(cycle.time > 0.0) & (cycle.time < 6e-5)].max() > 0.0


def harder_below(hammer: Hammer) -> None:
    """While the bit is in loaded rock, another stiffness changes the energy."""
    hammer.set({"rock.stiffness": "240 kN/mm" if hammer.time > 0.1 else "120 kN/mm"})


@pytest.mark.parametrize(("control", "works"), [(None, 3), (harder_below, 4)])
def test_the_bars_of_the_ledger_are_of_equal_height(
    control: Callable[[Hammer], None] | None, works: int, tmp_path: Path
) -> None:
    run = figures.at_blows(until=0.25)
    if control:
        times = [*run.time[:2], run.time[2] + 2e-4, *run.time[3:]]
        run = simulate(times=times, control=control)
    figure = figures.ledger(run)
    figure.savefig(tmp_path / "ledger.png", dpi=40)
    for axes in figure.get_axes():
        heights: dict[float, float] = {}
        for bar in axes.patches:
            place = round(bar.get_x() + bar.get_width() / 2, 3)
            heights[place] = heights.get(place, 0.0) + bar.get_height()
        left, right = np.array([heights[p] for p in sorted(heights)]).reshape(-1, 2).T
        np.testing.assert_allclose(left, right, rtol=1e-9)
    # The labels are percentages, each rounded to a tenth.
    said = [text.get_text() for text in figure.get_axes()[1].texts]
    shares = [float(text.split(", ")[-1].rstrip(" %")) for text in said]
    assert len(shares) == works + 4
    assert sum(shares[:works]) == pytest.approx(100.0, abs=0.05 * works + 1e-9)
    assert sum(shares[works:]) == pytest.approx(100.0, abs=0.05 * 4 + 1e-9)


@pytest.mark.parametrize("wanted", [[0.0, 0.1, 0.2], [5.0, 9.0, 9.5, 9.5], [3.0, 1.0, 8.0]])
def test_labels_are_pushed_apart_and_stay_below_the_top(wanted: list[float]) -> None:
    places = marks.apart(wanted, 1.0, 10.0)
    rising = sorted(places)
    assert np.argsort(places, kind="stable").tolist() == np.argsort(wanted, kind="stable").tolist()
    assert (np.diff(rising) >= 1.0 - 1e-12).all()
    assert rising[-1] <= 10.0


def test_no_blow_no_figure() -> None:
    short = simulate(until=0.005)
    for ask in (
        lambda: figures.settled_cycle(until=0.005),
        lambda: figures.at_blows(until=0.005),
        lambda: figures.convergence(short),
        lambda: figures.ledger(replace(short, frame=short.frame.iloc[:1])),
    ):
        with pytest.raises(TooFewBlowsError, match="too few"):
            ask()
    assert short.plot().get_axes()


def test_a_figure_is_written_with_200_dots_an_inch(run: Run, tmp_path: Path) -> None:
    figure = run.plot()
    figure.savefig(tmp_path / "figure.png")
    height, width = mpimg.imread(tmp_path / "figure.png").shape[:2]
    assert (width, height) == tuple(200 * size for size in figure.get_size_inches())


@pytest.mark.parametrize("draw", [Run.plot, figures.ledger, figures.convergence])
def test_every_letter_of_a_file_is_in_the_font_of_the_style(
    draw: Callable[[Run], Figure], run: Run, tmp_path: Path
) -> None:
    figure = draw(run)
    assert labels(figure)
    # A notebook or script may have set another font when it saves.
    with mpl.rc_context({"font.family": "sans-serif", "mathtext.fontset": "cm"}):
        figure.savefig(tmp_path / "figure.pdf")
    written = (tmp_path / "figure.pdf").read_bytes()
    fonts = set(re.findall(rb"/BaseFont /(?:[A-Z]{6}\+)?([\w-]+)", written))
    assert fonts
    assert all(font.startswith(b"STIX") for font in fonts), fonts
    # In TrueType fonts, unlike matplotlib's default outlines, a journal can search the letters.
    assert b"/Subtype /Type3" not in written


def contrast(one: object, two: object) -> float:
    """Returns the contrast of two colours, from 1 to 21, as defined by WCAG 2."""

    def luminance(colour: object) -> float:
        parts = to_rgb(colour)
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return float(np.dot((0.2126, 0.7152, 0.0722), linear))

    light, dark = sorted((luminance(one), luminance(two)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_a_figure_for_a_dark_page_can_be_read(run: Run) -> None:
    figure = figures.darken(run.plot())
    ground = figure.get_facecolor()
    assert contrast(ground, "black") < 2.0
    figure.draw_without_rendering()
    # WCAG 2 requires 4.5 for text, and 3 for everything else that must be distinguished.
    texts = [t for t in figure.findobj(Text) if t.get_text() and t.get_gid() != ON_COLOUR]
    assert len(texts) > 10
    for text in texts:
        assert contrast(text.get_color(), ground) >= 4.5, text.get_text()
    for axes in figure.get_axes():
        assert contrast(axes.get_facecolor(), "black") < 2.0
        for line in axes.get_lines():
            assert contrast(line.get_color(), ground) >= 3.0


#: The relay switches between two samples 50 us apart, in which the piston moves 0.5 mm of the 50 to
#: which the work is proportional. The title is rounded to a joule: one of a hundred, or of some
#: more with air.
@pytest.mark.parametrize(("preset", "part"), [(None, 0.02), ("air_4_inch", 5e-3)])
def test_the_area_of_the_indicator_diagram_is_the_work_of_the_drive(
    preset: str | None, part: float
) -> None:
    run = figures.settled_cycle(preset, "500 ms")
    *above, force = figures.indicator(run).axes
    area = float(force.get_title(loc="left").split()[0])
    assert area == pytest.approx(steady(preset)["energy_drive"], rel=part)
    # With air, the chambers' pressures are in the panels above.
    found = {line.get_label(): line.get_ydata() for axes in above for line in axes.lines}
    assert [*found] == (["drive chamber", "return chamber"] if preset else [])
    for bars in found.values():
        # Pressures go from the exhaust's to a little above the supply's, where a chamber is
        # compressed.
        assert 1.0 < np.min(bars) < np.max(bars) < 1.1 * 25.2
