"""The hammer and its compressor as one file of SSP 1.0, which libcosim and ecos load.

    python examples/system.py --out dist/compressor.ssp

`pythonfmu` makes the compressor's FMU. A host that runs the file needs what this FMU uses: Python
with this package.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from container import SCENE, build_compressor
from dth_hammer.fmu import write_system


def build(out: Path, step: float, until: float) -> None:
    """Writes the system."""
    with tempfile.TemporaryDirectory() as folder:
        partners = {"compressor": build_compressor(Path(folder))}
        for ends in write_system(SCENE, out, partners, step=step, until=until):
            print(" -> ".join(map(".".join, ends)))


def main() -> None:
    """Builds."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("dist/compressor.ssp"))
    parser.add_argument("--until", type=float, default=0.5)
    parser.add_argument("--step", type=float, default=1e-3)
    options = parser.parse_args()
    build(options.out, options.step, options.until)


if __name__ == "__main__":
    main()
