"""`dth-hammer demo`: prints and draws the settled cycle of the reference hammer."""

import argparse
from pathlib import Path

from .. import outputs
from ..scene.band import with_band
from ..simulation.run import Run
from .options import HAMMER, Written

NEEDS = ("matplotlib",)


FILE = Path("dth-hammer.png")
ALSO = (
    HAMMER,
    Written(
        "-o --out",
        type=Path,
        default=FILE,
        help=f"figure to write (default: {FILE})",
        check=outputs.check_figure,
    ),
)


def run(options: argparse.Namespace) -> None:
    """Simulates until the cycle repeats, prints it, draws it."""
    from ..figures import cycle, settled_cycle  # noqa: PLC0415

    settled = settled_cycle(options.hammer)
    print(table(settled))
    cycle(settled).savefig(options.out)
    print(f"figure: {options.out}")


def table(settled: Run) -> str:
    """Returns the numbers of the last blow as text, in field units."""
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
