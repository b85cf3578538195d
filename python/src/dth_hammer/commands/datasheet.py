"""`dth-hammer datasheet`: finds the hammer that a datasheet or a catalogue describes."""

import argparse
import json
from collections.abc import Sequence
from typing import Any

from .. import _native
from ..errors import DomainError
from ..scene.datasheet import from_datasheet
from . import common
from .options import SN, UNITS, WRITE_ROCK, Call, Written, assignments, file

EXAMPLES = {
    "od": ', as "124 mm"',
    "pressure": ', as "24 bar" or "350 psi"',
    "blow_energy": ', as "350 ft.lbf"',
    "air_flow": ', as "436 cfm", or by pressure, repeated: "17 bar=13 m3/min"',
    "rop": ', as "18 m/h"',
}


def air(texts: Sequence[str]) -> Any:
    """Reads the free air: one number, or one number per pressure."""
    return texts[0] if len(texts) == 1 and "=" not in texts[0] else assignments(texts)


def _number(name: str, unit: str, meaning: str) -> Written:
    """Returns the option for a number that the engine's table of datasheets lists."""
    text = meaning[0].lower() + meaning[1:] + (f"; in {unit} or with a unit" if unit != "1" else "")
    text += EXAMPLES.get(name, "")
    if name == "air_flow":
        return Written("", air, help=text, metavar="VALUE", action="append")
    return Written(help=text, metavar="VALUE")


CALL = Call(
    from_datasheet,
    {},
    specific_energy=_number("", "J/m3", "work per volume that drilling the rock takes"),
    **{name: _number(name, unit, text) for name, unit, *_, text in _native.datasheet_numbers()},
)


ALSO = (
    file("-o --out", "scene to write: .json, for run and report", ".json"),
    file("--report", "HTML page about the hammer to write", ".html", ".htm"),
    Written("--title", default="", help="name of the hammer on the page"),
    Written("--customer", default="", help="whom the page is for"),
    UNITS,
    WRITE_ROCK,
    SN,
)


def run(options: argparse.Namespace) -> Any:
    """Finds the hammer, prints it and writes the requested files."""
    given = CALL.given(options)
    if not given:
        raise DomainError("nothing is given: see dth-hammer datasheet --help")
    sheet = from_datasheet(**given)
    print(sheet)
    common.write_rock(options, sheet.ground)
    if options.out:
        words = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in given.items())
        scene = {"description": words, "start_values": dict(sheet.parameters)}
        options.out.write_text(json.dumps(scene, indent=2) + "\n", encoding="utf-8")
    if options.report:
        from ..figures.page import report  # noqa: PLC0415

        curve = SN.read(options.sn) if options.sn else None
        header = {"title": options.title, "customer": options.customer, "curve": curve}
        units = common.printed_units(options.units)
        page = report(sheet, options.report, units=units, progress=True, **header)
        print(f"{page}: {page.stat().st_size / 1e6:.1f} MB")
    return {
        "found": sheet.to_frame(),
        "parameters": sheet.parameters,
        "assumed": sheet.assumed,
        "contradictions": sheet.contradictions,
    }
