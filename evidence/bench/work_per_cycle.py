"""Instructions of a settled reference cycle, split by purpose, by callgrind.

    cargo build --release -p hammer --example cycles --config profile.release.lto=false
    python evidence/bench/work_per_cycle.py target/release/examples/cycles

Runs the example with 0 and with 10 cycles; the difference over 10 is a cycle. What follows the
program is handed to it: `rigid`, or a number of elements per bar. Needs valgrind.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from pathlib import Path

CYCLES = 10
# Functions whose cost, with all they call, is a purpose; what is called from within an earlier
# one is counted there.
PURPOSES = {
    "search: windows": ("Signal::expand", "window::", "OnGrid", "Watch::window"),
    "forms: barrier, viscous work, losses": ("Form::of", "tip_square", "Barrier::"),
    "search: samples (rotations, bounds, bookkeeping)": ("Search::next", "Machine::run"),
    "search: guards of a new mode": ("Search::arm",),
    "basis": ("Motion::enter", "Basis::", "switch_contact", "switch_rock", "body_state"),
    "ledger": ("Owed::new", "Account::", "Machine::ledger_now"),
    "moving the epoch": ("move_epoch",),
}
# What is compiled for each kind of vectors, with all that is inlined there.
LOOPS = "::vectorize::"
REST = "outputs, memory and the rest"


def profile(program: Path, cycles: int, words: list[str]) -> Path:
    """Callgrind's file of a run."""
    out = Path(tempfile.mkdtemp()) / f"callgrind.{cycles}"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}"]
    run = subprocess.run(
        [*command, str(program), str(cycles), *words], check=True, capture_output=True, text=True
    )
    print(run.stdout.strip(), file=sys.stderr)
    return out


def edges(file: Path) -> tuple[Counter[str], Counter[tuple[str, str]]]:
    """Own cost of each function, and cost of what each calls, with all below."""
    names: dict[str, str] = {}
    own: Counter[str] = Counter()
    below: Counter[tuple[str, str]] = Counter()
    caller = callee = ""
    is_call = False
    for line in file.read_text().splitlines():
        if match := re.match(r"(c?fn)=\((\d+)\)(?: (.*))?", line):
            kind, number, name = match.groups()
            if name:
                names[number] = re.sub(r"[<>]", "", name)
            if kind == "fn":
                caller = names[number]
            else:
                callee = names[number]
        elif line.startswith("calls="):
            is_call = True
        elif re.match(r"[\d+*-]", line):
            cost = int(line.split()[1])
            if is_call:
                below[caller, callee] += cost
            else:
                own[caller] += cost
            is_call = False
    return own, below


def purpose(name: str) -> str | None:
    """The purpose that a function is for, if it says so."""
    return next((p for p, words in PURPOSES.items() if any(w in name for w in words)), None)


def split(own: Counter[str], below: Counter[tuple[str, str]]) -> dict[str, float]:
    """Cost by purpose: a function without one passes its own cost on to its callers, in
    proportion to what they spend in it."""
    callers: dict[str, list[tuple[str, int]]] = {}
    for (caller, callee), cost in below.items():
        if caller != callee:
            callers.setdefault(callee, []).append((caller, cost))
    shares: dict[str, dict[str, float]] = {}

    def share(name: str, above: frozenset[str]) -> dict[str, float]:
        if (found := purpose(name)) is not None:
            return {found: 1.0}
        if name in shares:
            return shares[name]
        lines = [line for line in callers.get(name, []) if line[0] not in above]
        total = sum(cost for _, cost in lines)
        sums: dict[str, float] = defaultdict(float)
        for caller, cost in lines:
            for key, part in share(caller, above | {name}).items():
                sums[key] += part * cost / total
        if not sums:
            sums[REST] = 1.0
        shares[name] = sums
        return sums

    result: dict[str, float] = defaultdict(float)
    for name, cost in own.items():
        for key, part in share(name, frozenset()).items():
            result[key] += part * cost
    return result


def main() -> None:
    """Prints the table."""
    program, *words = sys.argv[1:]
    none, some = (edges(profile(Path(program), cycles, words)) for cycles in (0, CYCLES))
    # Of the cycles alone; `Counter`'s own difference drops what is not above zero.
    whole = split(some[0] - none[0], some[1] - none[1])
    cycle = {key: whole[key] / CYCLES for key in [*PURPOSES, REST]}
    print("| purpose | instructions per cycle |\n|---|---:|")
    for key, cost in cycle.items():
        print(f"| {key} | {cost:,.0f} |")
    print(f"| **all** | **{sum(cycle.values()):,.0f}** |")
    loops = sum(some[0][name] - none[0][name] for name in some[0] if LOOPS in name) / CYCLES
    print(f"\nIn the loops in vectors: {loops:,.0f} ({loops / sum(cycle.values()):.1%})")


if __name__ == "__main__":
    main()
