"""`dth-hammer demo`: prints and draws the settled cycle of the reference hammer."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..run.run import Run
from ..scene.band import with_band
from . import common
from .options import HAMMER

NEEDS = ("matplotlib",)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments to its parser."""
    parser.add_argument("hammer", help=HAMMER.help, nargs="?")
    file = Path("dth-hammer.png")
    parser.add_argument(
        "-o", "--out", type=Path, default=file, help=f"figure to write (default: {file})"
    )


def run(options: argparse.Namespace) -> None:
    """Simulates until the cycle repeats, prints it, draws it."""
    from ..figures import cycle, settled_cycle  # noqa: PLC0415

    common.check_outputs(None, options.out)
    settled = settled_cycle(options.hammer)
    print(table(settled))
    cycle(settled).savefig(options.out)
    print(f"figure: {options.out}")


def table(settled: Run) -> str:
    """The last blow in the units of the field."""
    last = settled.frame.iloc[-1]
    rows = (
        ("blow period", last["blow_period"] * 1e3, "ms"),
        ("frequency", 1 / last["blow_period"], "Hz"),
        ("impact speed", last["blow_speed"], "m/s"),
        ("energy per blow", last["blow_energy"], "J"),
        ("tip's gain per blow", last["blow_penetration"] * 1e3, "mm"),
    )
    rate = f"{'rate of penetration':20} {with_band(last['rop'], settled.parameters)}"
    return "\n".join([rate, *(f"{name:20} {value:8.4g} {unit}" for name, value, unit in rows)])
