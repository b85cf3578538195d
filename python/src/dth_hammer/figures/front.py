"""The page of a report that is handed on: one sheet, A4, that says what the hammer is and does."""

import datetime
import math
from collections.abc import Mapping
from html import escape

import pandas as pd

from .. import _native
from ..run.run import Run
from ..scene.band import ranged, sentence, to_digits
from ..scene.datasheet import Datasheet
from ..scene.rocks import ROCK, described
from ..scene.variables import PRESETS, VARIABLES, whole

#: The six numbers, by their names in the table of what an engineer hands on.
NUMBERS = (
    *("rate of penetration", "frequency", "blow energy"),
    *("impact speed", "power to the rock", "largest rock force"),
)
#: What to give the hammer, beside feed and pressure.
USE = (
    *("free air", "oil or water taken", "up-hole velocity of the air"),
    *("rotation for 10 to 19 mm of advance per turn", "advance per turn"),
)
#: The head of a bit of one section, as a part of it.
HEAD = 0.3
SCALES = (1, 2, 5, 10, 20, 50)
#: A casing's outside diameter over the hole's where only its mass is known: the hole that is usual.
CASED = 1 / 1.15
#: Room of the drawing on the sheet, mm.
WIDTH, HEIGHT = 176.0, 44.0
COLOURS = {"piston": "#d55e00", "bit": "#0072b2"}
STYLE = """
.front { max-width: 178mm; } .front h1 { margin: 0 0 .3rem; }
.front .who { display: flex; justify-content: space-between; border-bottom: 2px solid; }
.front .sides { display: flex; flex-wrap: wrap; gap: 0 2rem; }
.front .sides > * { flex: 1 1 18rem; }
.front svg { width: 100%; height: auto; background: white; color: #222; }
.front .figure img { max-height: 70mm; }
.front ul { margin: .2rem 0; padding-left: 1.2rem; }
@page { size: A4; margin: 13mm 16mm; }
@media print {
  :root { color-scheme: light; }
  body { font-size: 9pt; line-height: 1.3; max-width: none; margin: 0; padding: 0; }
  h1 { font-size: 15pt; } h2 { font-size: 11pt; margin: .6rem 0 .2rem; break-after: avoid; }
  table { display: table; width: 100%; overflow: visible; } thead { display: table-header-group; }
  td, th { padding: .1rem .4rem; overflow-wrap: break-word; }
  table.wide td, table.wide th { font-size: 6.5pt; padding: .05rem .15rem; }
  tr, figure, .front { break-inside: avoid; } .appendix { break-before: page; }
  .appendix img { max-height: 105mm; } figure { margin: .3rem 0; }
  .front .sides { flex-wrap: nowrap; }
}
"""


def front(
    run: Run, table: pd.DataFrame, sheet: Datasheet | None, *, who: tuple[str, str], image: str
) -> str:
    """The sheet, as HTML.

    Args:
        run: of the hammer.
        table: its numbers, as displayed.
        sheet: what it was found from.
        who: the hammer's name, that of the run if empty, and whom the sheet is for.
        image: a figure, as an element.
    """
    given, (name, customer), scene = whole(run.parameters), who, run.scene
    when = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    assumed = [sentence(run.parameters), *(sheet.assumed if sheet else ())]
    if sheet is None and scene.preset:
        assumed.append(f"{PRESETS[scene.preset].description}.")
    if sheet is None and ROCK in scene.parameters:
        rock = str(scene.parameters[ROCK])
        assumed += [f"The rock is {rock}.", *described(rock)[1]]
    figure = f'<div class="figure">{image}</div>'
    parts = [
        f'<p class="who"><span>{escape(customer) or "Hammer"}</span><span>{when}</span></p>',
        f"<h1>{escape(name or scene.title)}</h1>",
        drawing(given),
        '<div class="sides">',
        f"<div><h2>What it does</h2>{_rows(table, NUMBERS)}</div>",
        f"<div><h2>What it is given</h2>{_rows(table, USE, _supply(given))}</div></div>",
        f"<h2>Rock force against penetration</h2>{figure}" if image else "",
        "<h2>What is assumed</h2><ul>",
        *(f"<li>{escape(text)}</li>" for text in assumed),
        "</ul>",
    ]
    return f'<section class="front">{"".join(parts)}</section>'


def _supply(given: Mapping[str, float]) -> list[tuple[str, str]]:
    """Feed and pressure, in the units of the trade."""
    rows = [("feed", f"{1e-3 * given['feed_force']:.3g} kN")]
    source = VARIABLES["drive.source"].labels[int(given["drive.source"])]
    if source == "Air":
        over = given["supply_pressure"] - given["exhaust_pressure"]
        rows.insert(0, ("pressure of the air over the exhaust's", f"{1e-5 * over:.3g} bar"))
    return rows


def _rows(
    table: pd.DataFrame, names: tuple[str, ...], first: list[tuple[str, str]] | None = None
) -> str:
    """Numbers in words, to the digits that their ranges leave."""
    rows = list(first or ())
    for name in names:
        if name not in table:
            continue
        value, low, high = table[name]
        unit, sides = table.attrs["units"][name], ranged(low, high)
        text = f"{to_digits(value, low, high)} {'' if unit == '1' else unit}".strip()
        if name == "feed":
            rows = [row for row in rows if row[0] != "feed"]
        rows.append((name, f"{text} ({sides})" if sides else text))
    lines = (f"<tr><td>{escape(name)}</td><td>{escape(value)}</td></tr>" for name, value in rows)
    return f"<table>{''.join(lines)}</table>"


def sections(given: Mapping[str, float], body: str) -> list[tuple[float, float]]:
    """Length and diameter of each section of a body, mm: of full sections with its areas."""
    parts = _native.bodies(given)[body]["sections"]
    return [(1e3 * length, 2e3 * math.sqrt(area / math.pi)) for length, area in parts]


def casing(given: Mapping[str, float]) -> list[tuple[float, float]]:
    """Length and outside diameter of the casing's sections, mm, about a bore as wide as the piston.

    Of a mass alone, one as thick as the hole lets it be, and as long as it then has to be.
    """
    bore = max(diameter for _, diameter in sections(given, "piston"))
    if given["casing.segments"]:
        return [(x, math.hypot(bore, steel)) for x, steel in sections(given, "casing")]
    outside = max(CASED * 1e3 * given["hole.diameter"], 1.05 * bore)
    area = 1e-6 * math.pi / 4 * (outside**2 - bore**2)
    long = 1e3 * given["casing.mass"] / (given["material.density"] * area)
    return [(long, outside)] if long else []


def scale_of(long: float, wide: float) -> int:
    """The largest scale at which so many millimetres fit, ``1 : n``."""
    fits = (n for n in SCALES if long / n <= WIDTH - 6 and wide / n <= HEIGHT - 14)
    return next(fits, SCALES[-1])


def drawing(given: Mapping[str, float]) -> str:
    """Casing, piston and bit in the hole, lying, to scale: an SVG in millimetres of the sheet."""
    bodies, cased = {body: sections(given, body) for body in COLOURS}, casing(given)
    hole = 1e3 * given["hole.diameter"]
    inside = sum(length for parts in bodies.values() for length, _ in parts)
    # The casing ends where the bit's head begins.
    below = sum(length for length, _ in bodies["bit"][1:]) or HEAD * bodies["bit"][0][0]
    before = max(0.0, sum(length for length, _ in cased) - (inside - below))
    wide = max(hole, *(d for parts in (*bodies.values(), cased) for _, d in parts))
    scale = scale_of(before + inside, wide)
    middle, begin, shapes = (HEIGHT - 9) / 2, (WIDTH - (before + inside) / scale) / 2, []
    x, end = begin + before / scale, begin + (before + inside - below) / scale
    bore = max(diameter for _, diameter in bodies["piston"])
    for length, outside in reversed(cased):
        end -= length / scale
        wall = (outside - bore) / scale / 2
        for edge in (middle - outside / scale / 2, middle + bore / scale / 2):
            outline = (
                f"M{end:.3f} {edge:.3f}h{length / scale:.3f}v{wall:.3f}h{-length / scale:.3f}z"
            )
            shapes.append(f'<path d="{outline}" fill="#a9adb3" stroke="#555" stroke-width=".2"/>')
    words = []
    for body, parts in bodies.items():
        for length, diameter in parts:
            size = f'width="{length / scale:.3f}" height="{diameter / scale:.3f}"'
            place = f'x="{x:.3f}" y="{middle - diameter / scale / 2:.3f}"'
            colour = f'fill="{COLOURS[body]}33" stroke="{COLOURS[body]}" stroke-width=".4"'
            shapes.append(f"<rect {place} {size} {colour}/>")
            x += length / scale
        own = sum(length for length, _ in parts)
        label = f"{body} {own:.0f} mm, &#8960; {max(d for _, d in parts):.0f} mm"
        words.append(f'<tspan fill="{COLOURS[body]}">{label}</tspan>')
    for side in (-1, 1):
        y = middle + side * hole / scale / 2
        shapes.append(
            f'<line x1="{begin - 2:.2f}" x2="{x + 2:.2f}" y1="{y:.2f}" y2="{y:.2f}"'
            ' stroke="#8c6d31" stroke-width=".4" stroke-dasharray="2 1"/>'
        )
    if cased:
        made = "" if given["casing.segments"] else ", as long as its mass makes it"
        words.append(f"grey: the casing{made}")
    last = f"Dashed: the hole of {hole:.0f} mm. Scale 1 : {scale}, full sections."
    for line, y in (("; ".join(words), HEIGHT - 6), (last, HEIGHT - 2)):
        shapes.append(f'<text x="{WIDTH / 2}" y="{y}">{line}</text>')
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" style="max-width:{WIDTH:g}mm" role="img" '
        f'aria-label="The hammer to scale" font-size="3.2" text-anchor="middle" '
        f'font-family="sans-serif">{"".join(shapes)}</svg>'
    )
