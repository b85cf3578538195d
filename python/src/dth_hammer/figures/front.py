"""The first page of a report: one A4 sheet with the hammer's drawing, numbers and assumptions."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping
from html import escape

from .. import _native
from ..frames import pd
from ..scene.band import ranged, sentence, to_digits
from ..scene.datasheet import Datasheet
from ..scene.rocks import ROCK, described
from ..scene.variables import PRESETS, VARIABLES, whole
from ..simulation.run import Run

#: The six main results, by their names in the headline table.
NUMBERS = (
    *("rate of penetration", "frequency", "blow energy"),
    *("impact speed", "power to the rock", "largest rock force"),
)
#: What the hammer must be supplied with, in addition to feed and pressure.
USE = (
    *("free air", "oil or water taken", "up-hole velocity of the air"),
    *("rotation for 10 to 19 mm of advance per turn", "advance per turn"),
)
#: Length of the bit's head as a share of the bit, for a bit of one section.
HEAD = 0.3
SCALES = (1, 2, 5, 10, 20, 50)
#: Usual ratio of a casing's outside diameter to the hole's, for a casing given only by its mass.
CASING_TO_HOLE = 1 / 1.15
#: Size of the drawing on the sheet, mm.
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
    run: Run,
    table: pd.DataFrame,
    sheet: Datasheet | None,
    *,
    who: tuple[str, str],
    image: str,
) -> str:
    """Returns the sheet as HTML.

    Args:
        run: a run of the hammer.
        table: the headline table in display units.
        sheet: the datasheet that the hammer was derived from, if any.
        who: name of the hammer (if empty, that of the run's scene) and name of the customer.
        image: the figure of the rock force as an HTML element; may be empty.
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
    """Returns the rows of feed and pressure, in field units."""
    rows = [("feed", f"{1e-3 * given['feed_force']:.3g} kN")]
    source = VARIABLES["drive.source"].labels[int(given["drive.source"])]
    if source == "Air":
        gauge = given["supply_pressure"] - given["exhaust_pressure"]
        rows.insert(0, ("pressure of the air over the exhaust's", f"{1e-5 * gauge:.3g} bar"))
    return rows


def _rows(
    table: pd.DataFrame, names: tuple[str, ...], first: list[tuple[str, str]] | None = None
) -> str:
    """Returns an HTML table of numbers with as many digits as their ranges justify."""
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
    """Returns the length and the diameter (mm) of each section of a body.

    The diameter is that of a solid cylinder with the section's area.
    """
    parts = _native.bodies(given)[body]["sections"]
    return [(1e3 * length, 2e3 * math.sqrt(area / math.pi)) for length, area in parts]


def casing(given: Mapping[str, float]) -> list[tuple[float, float]]:
    """Returns the length and the outside diameter (mm) of each section of the casing.

    Its bore is as wide as the piston. If only the casing's mass is known, its outside diameter is
    the usual one for the hole, and its length follows from the mass.
    """
    bore = max(diameter for _, diameter in sections(given, "piston"))
    if given["casing.segments"]:
        return [(x, math.hypot(bore, steel)) for x, steel in sections(given, "casing")]
    outside = max(CASING_TO_HOLE * 1e3 * given["hole.diameter"], 1.05 * bore)
    area = 1e-6 * math.pi / 4 * (outside**2 - bore**2)
    length = 1e3 * given["casing.mass"] / (given["material.density"] * area)
    return [(length, outside)] if length else []


def scale_of(length: float, width: float) -> int:
    """Returns the ``n`` of the largest scale ``1 : n`` at which a length and a width (mm) fit."""
    fits = (n for n in SCALES if length / n <= WIDTH - 6 and width / n <= HEIGHT - 14)
    return next(fits, SCALES[-1])


def drawing(given: Mapping[str, float]) -> str:
    """Returns a drawing to scale of casing, piston and bit in the hole, top to the left, as SVG."""
    bodies, casing_sections = {body: sections(given, body) for body in COLOURS}, casing(given)
    hole = 1e3 * given["hole.diameter"]
    inside = sum(length for parts in bodies.values() for length, _ in parts)
    # The casing ends where the bit's head begins.
    below = sum(length for length, _ in bodies["bit"][1:]) or HEAD * bodies["bit"][0][0]
    before = max(0.0, sum(length for length, _ in casing_sections) - (inside - below))
    width = max(hole, *(d for parts in (*bodies.values(), casing_sections) for _, d in parts))
    scale = scale_of(before + inside, width)
    middle, begin, shapes = (HEIGHT - 9) / 2, (WIDTH - (before + inside) / scale) / 2, []
    x, end = begin + before / scale, begin + (before + inside - below) / scale
    bore = max(diameter for _, diameter in bodies["piston"])
    for length, outside in reversed(casing_sections):
        end -= length / scale
        wall = (outside - bore) / scale / 2
        for edge in (middle - outside / scale / 2, middle + bore / scale / 2):
            outline = (
                f"M{end:.3f} {edge:.3f}h{length / scale:.3f}v{wall:.3f}h{-length / scale:.3f}z"
            )
            shapes.append(f'<path d="{outline}" fill="#a9adb3" stroke="#555" stroke-width=".2"/>')
    labels = []
    for body, parts in bodies.items():
        for length, diameter in parts:
            size = f'width="{length / scale:.3f}" height="{diameter / scale:.3f}"'
            place = f'x="{x:.3f}" y="{middle - diameter / scale / 2:.3f}"'
            colour = f'fill="{COLOURS[body]}33" stroke="{COLOURS[body]}" stroke-width=".4"'
            shapes.append(f"<rect {place} {size} {colour}/>")
            x += length / scale
        body_length = sum(length for length, _ in parts)
        label = f"{body} {body_length:.0f} mm, &#8960; {max(d for _, d in parts):.0f} mm"
        labels.append(f'<tspan fill="{COLOURS[body]}">{label}</tspan>')
    for side in (-1, 1):
        y = middle + side * hole / scale / 2
        shapes.append(
            f'<line x1="{begin - 2:.2f}" x2="{x + 2:.2f}" y1="{y:.2f}" y2="{y:.2f}"'
            ' stroke="#8c6d31" stroke-width=".4" stroke-dasharray="2 1"/>'
        )
    if casing_sections:
        assumption = "" if given["casing.segments"] else ", as long as its mass makes it"
        labels.append(f"grey: the casing{assumption}")
    note = f"Dashed: the hole of {hole:.0f} mm. Scale 1 : {scale}, full sections."
    for line, y in (("; ".join(labels), HEIGHT - 6), (note, HEIGHT - 2)):
        shapes.append(f'<text x="{WIDTH / 2}" y="{y}">{line}</text>')
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" style="max-width:{WIDTH:g}mm" role="img" '
        f'aria-label="The hammer to scale" font-size="3.2" text-anchor="middle" '
        f'font-family="sans-serif">{"".join(shapes)}</svg>'
    )
