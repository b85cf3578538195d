"""The page of a report that is handed on: one sheet, A4, that says what the hammer is and does."""

from __future__ import annotations

import datetime
import html
import math
from collections.abc import Mapping

import pandas as pd

from ..run.run import Run
from ..scene.band import ranged, sentence, to_digits
from ..scene.datasheet import Datasheet
from ..scene.variables import VARIABLES, whole

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
SCALES = (1, 2, 5, 10, 20, 50)
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
    given, (name, customer) = whole(run.parameters), who
    when = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    assumed = [sentence(run.parameters), *(sheet.assumed if sheet else ())]
    figure = f'<div class="figure">{image}</div>'
    parts = [
        f'<p class="who"><span>{_text(customer) or "Hammer"}</span><span>{when}</span></p>',
        f"<h1>{_text(name or run.scene.title)}</h1>",
        drawing(given),
        '<div class="sides">',
        f"<div><h2>What it does</h2>{_rows(table, NUMBERS)}</div>",
        f"<div><h2>What it is given</h2>{_rows(table, USE, _supply(given))}</div></div>",
        f"<h2>Rock force against penetration</h2>{figure}" if image else "",
        "<h2>What is assumed</h2><ul>",
        *(f"<li>{_text(text)}</li>" for text in assumed),
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
    lines = (f"<tr><td>{_text(name)}</td><td>{_text(value)}</td></tr>" for name, value in rows)
    return f"<table>{''.join(lines)}</table>"


def sections(given: Mapping[str, float], body: str) -> list[tuple[float, float]]:
    """Length and diameter of each section of a body, mm: of full sections with its areas."""
    count = int(given[f"{body}.segments"])
    parts = [
        (given[f"{body}.segment[{k}].length"], given[f"{body}.segment[{k}].area"])
        for k in range(1, count + 1)
    ] or [(given[f"{body}.length"], given["cross_section"])]
    return [(1e3 * length, 2e3 * math.sqrt(area / math.pi)) for length, area in parts]


def scale_of(long: float, wide: float) -> int:
    """The largest scale at which so many millimetres fit, ``1 : n``."""
    fits = (n for n in SCALES if long / n <= WIDTH - 6 and wide / n <= HEIGHT - 14)
    return next(fits, SCALES[-1])


def drawing(given: Mapping[str, float]) -> str:
    """Piston and bit in the hole, lying, to scale: an SVG whose millimetres are the sheet's."""
    bodies = {body: sections(given, body) for body in COLOURS}
    hole = 1e3 * given["hole.diameter"]
    long = sum(length for parts in bodies.values() for length, _ in parts)
    wide = max(hole, *(d for parts in bodies.values() for _, d in parts))
    scale = scale_of(long, wide)
    middle, x, shapes = (HEIGHT - 9) / 2, (WIDTH - long / scale) / 2, []
    begin = x
    for body, parts in bodies.items():
        start = x
        for length, diameter in parts:
            size = f'width="{length / scale:.3f}" height="{diameter / scale:.3f}"'
            place = f'x="{x:.3f}" y="{middle - diameter / scale / 2:.3f}"'
            colour = f'fill="{COLOURS[body]}33" stroke="{COLOURS[body]}" stroke-width=".4"'
            shapes.append(f"<rect {place} {size} {colour}/>")
            x += length / scale
        own = sum(length for length, _ in parts)
        label = f"{body} {own:.0f} mm, &#8960; {max(d for _, d in parts):.0f} mm"
        shapes.append(f'<text x="{(start + x) / 2:.2f}" y="{middle + 1:.2f}">{label}</text>')
    for side in (-1, 1):
        y = middle + side * hole / scale / 2
        shapes.append(
            f'<line x1="{begin - 2:.2f}" x2="{x + 2:.2f}" y1="{y:.2f}" y2="{y:.2f}"'
            ' stroke="#8c6d31" stroke-width=".4" stroke-dasharray="2 1"/>'
        )
    words = (
        f"Scale 1 : {scale}. Full sections of the bodies' areas; dashed, the hole of {hole:.0f} mm."
    )
    shapes.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 2}">{words}</text>')
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" style="max-width:{WIDTH:g}mm" role="img" '
        f'aria-label="Piston and bit to scale" font-size="3.2" text-anchor="middle" '
        f'font-family="sans-serif">{"".join(shapes)}</svg>'
    )


def _text(text: object) -> str:
    return html.escape(str(text))
