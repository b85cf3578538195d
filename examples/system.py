"""The hammer and the pneumatic drive as one file of SSP 1.0, which libcosim and ecos load.

    python examples/system.py --out dist/pneumatic.ssp

`pythonfmu` makes the drive's FMU. Who runs the file needs what the drive is made of: Python with
this package.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from container import build_drive
from dth_hammer.fmu import write_system
from dth_hammer.models.pneumatic import Air


def build(out: Path, step: float, until: float) -> None:
    """Writes the system."""
    with tempfile.TemporaryDirectory() as folder:
        drive = build_drive(Path(folder))
        scene = Air().parameters()
        for ends in write_system(out, {"drive": drive}, scene, step=step, until=until):
            print(" -> ".join(map(".".join, ends)))


def main() -> None:
    """Builds."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("dist/pneumatic.ssp"))
    parser.add_argument("--until", type=float, default=0.5)
    parser.add_argument("--step", type=float, default=1e-5)
    options = parser.parse_args()
    build(options.out, options.step, options.until)


if __name__ == "__main__":
    main()
