"""`dth-hammer datasheet`: finds the hammer that a datasheet or a catalogue describes."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from .. import _native, outputs
from ..datasheet import UNITS, Datasheet, from_datasheet
from ..errors import DomainError
from . import common

HELP = "find the hammer that a datasheet or a catalogue describes, and report on it"
#: Numbers that may be given, as options, and examples of some.
NUMBERS = (*UNITS, "specific_energy")
EXAMPLES = {
    "od": ', as "124 mm"',
    "pressure": ', as "24 bar" or "350 psi"',
    "blow_energy": ', as "350 ft.lbf"',
    "air_flow": ', as "436 cfm", or by pressure, repeated: "17 bar=13 m3/min"',
    "rop": ', as "18 m/h"',
}


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    for name, unit, *_, meaning in _native.datasheet_numbers():
        parser.add_argument(
            f"--{name.replace('_', '-')}",
            action="append" if name == "air_flow" else "store",
            metavar="VALUE",
            help=meaning
            + (f"; in {unit} or with a unit" if unit != "1" else "")
            + EXAMPLES.get(name, ""),
        )
    parser.add_argument(
        "--specific-energy",
        help="Work per volume that drilling the rock takes; in J/m3 or with a unit",
    )
    parser.add_argument("--rock", help="rock to drill, as listed by `dth-hammer rock`")
    parser.add_argument(
        "--preset", help="preset whose rock is drilled, as listed by `dth-hammer info`"
    )
    parser.add_argument("-o", "--out", type=Path, help="scene to write: .json, for run and report")
    parser.add_argument("--report", type=Path, help="HTML page about the hammer to write")
    common.add_units(parser)
    common.add_curve(parser)


def run(options: argparse.Namespace) -> None:
    """Finds the hammer, prints it and writes the requested files."""
    out = outputs.check(options.out, (".json",)) if options.out else None
    page = outputs.check(options.report, (".html", ".htm")) if options.report else None
    given = {name: getattr(options, name) for name in NUMBERS}
    given = {name: value for name, value in given.items() if value is not None}
    if not given:
        raise DomainError("nothing is given: see dth-hammer datasheet --help")
    if air := given.get("air_flow"):
        given["air_flow"] = _air(air)
    sheet = from_datasheet(**given, rock=options.rock, preset=options.preset)
    print(sheet)
    if out:
        scene = {"description": _words(given, options), "start_values": dict(sheet.parameters)}
        out.write_text(json.dumps(scene, indent=2) + "\n", encoding="utf-8")
    if page:
        _report(page, sheet, _words(given, options), options)


def _air(texts: list[str]) -> Any:
    """Parses free air: one number, or one per pressure."""
    if len(texts) == 1 and "=" not in texts[0]:
        return texts[0]
    return common.assignments(texts)


def _words(given: dict[str, Any], options: argparse.Namespace) -> str:
    """Returns the given data as one line."""
    parts = [f"{name.replace('_', ' ')} {value}" for name, value in given.items()]
    return ", ".join([*parts, *(text for text in (options.rock, options.preset) if text)])


def _report(page: Path, sheet: Datasheet, words: str, options: argparse.Namespace) -> None:
    from ..fatigue import SNCurve  # noqa: PLC0415
    from ..page import report  # noqa: PLC0415
    from ..scene import Scene  # noqa: PLC0415

    scene = Scene("Hammer of a datasheet", words, None, dict(sheet.parameters))
    curve = SNCurve.read(options.sn) if options.sn else None
    report(scene, page, units=common.systems(options.units), curve=curve, sheet=sheet)
    print(f"{page}: {page.stat().st_size / 1e6:.1f} MB")
