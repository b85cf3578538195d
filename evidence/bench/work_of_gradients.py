"""Instructions of a settled reference cycle with derivatives by 0, 1, 5 and 20 parameters.

    cargo work-per-cycle --example gradients
    python evidence/bench/work_of_gradients.py target/release/examples/gradients

Runs the example under callgrind with 2 and with 8 cycles; the difference over 6 is a cycle, the
first ones make what is made once. Needs valgrind.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

CYCLES = (2, 8)
PARAMETERS = (0, 1, 5, 20)


def count(program: Path, cycles: int, parameters: int) -> int:
    """Instructions of a run."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out"]
        run = subprocess.run(
            [*command, str(program), str(cycles), str(parameters)],
            check=True,
            capture_output=True,
            text=True,
        )
    found = re.search(r"Collected : (\d+)", run.stderr)
    if found is None:
        raise SystemExit(run.stderr)
    return int(found[1])


def main() -> None:
    """Prints the table."""
    program = Path(sys.argv[1])
    rows = []
    for parameters in PARAMETERS:
        few, more = (count(program, cycles, parameters) for cycles in CYCLES)
        rows.append((parameters, (more - few) / (CYCLES[1] - CYCLES[0])))
    alone = rows[0][1]
    print(
        "| parameters | instructions per cycle | over the cycle alone | per parameter, in cycles |"
    )
    print("|---:|---:|---:|---:|")
    for parameters, work in rows:
        each = f"{(work / alone - 1.0) / parameters:.2f}" if parameters else ""
        print(f"| {parameters} | {work:,.0f} | {work / alone:.2f} | {each} |")


if __name__ == "__main__":
    main()
