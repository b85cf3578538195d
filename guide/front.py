"""Writes the README's part on speed and exactness, from the reports: `cargo front`.

The reports are those of reports/; each names the processor that it was measured on.
"""

from __future__ import annotations

import json
import re
import textwrap
from itertools import takewhile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
MARKS = ("<!-- measured: cargo front -->\n", "<!-- end of measured -->")
#: Our row of speed-against-error.md, and the error at which solvers are compared.
OURS, ERROR, ELEMENTS = "this engine", "1e-6", 20


def main() -> None:
    """Replaces the part of the README between the two marks."""
    before, after = split(README.read_text(encoding="utf-8"))
    README.write_text(before + text() + after, encoding="utf-8")


def split(page: str) -> tuple[str, str]:
    """Returns the text before and after the part, including the marks."""
    start, end = page.index(MARKS[0]) + len(MARKS[0]), page.index(MARKS[1])
    return page[:start], page[end:]


def text() -> str:
    """Returns the part."""
    lines = [*speed(), *face(), *costs(), *checks(), *engines()]
    return "".join(
        textwrap.fill(line, 100, subsequent_indent="  ", break_on_hyphens=False) + "\n"
        for line in lines
    )


def speed() -> list[str]:
    """Returns the lines on one cycle: its time, its first time, and the compared solvers."""
    data = json.loads((ROOT / "reports" / "speed-against-error.json").read_text(encoding="utf-8"))
    (engine,) = [p for p in data["points"] if p["solver"] == OURS]
    steel, air = (factors(number) for number in (0, 1))
    ahead = "below 1 the other is faster, and " if min(air.values()) < 1 else ""
    setup = factors(0, f"{ERROR}, with set-up")
    return [
        f"* On one {data['processor']}, a pressure cycle of the preset `overdamped` "
        f"({ELEMENTS} elements per bar, {data['events']} events) takes {engine['cpu'] * 1e3:.2f} "
        f"ms with an error of {engine['verdict']['error']:.0e} mm and m/s; the first one takes "
        f"{engine['setup'] * 1e3:.1f} ms, because it also computes the modes of each system."
        " Measured by `cargo bench-report speed`.",
        f"* At an error of {ERROR} mm and m/s, the fastest general solvers take longer by these "
        f"factors: {named(steel)}; with the set-up of all, {named(setup)}. "
        f"Under air with rigid bodies: {named(air)}; {ahead}heyoka's time is that of its own "
        "loop alone. "
        "All were measured in the same run, on one core.",
    ]


def named(solvers: dict[str, float]) -> str:
    """Names the three fastest of the other solvers."""
    fastest = sorted(solvers.items(), key=lambda item: item[1])[:3]
    return ", ".join(f"{ratio:g} ({name})" for name, ratio in fastest)


def factors(number: int, column: str = ERROR) -> dict[str, float]:
    """Returns how many times as long other solvers take, on steel (table 0) or under air (1)."""
    page = (ROOT / "reports" / "speed-against-error.md").read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")]
    first = [k for k, row in enumerate(rows) if row[0] == "solver" and column in row][number]
    cell = rows[first].index(column)
    table = takewhile(lambda row: len(row) == len(rows[first]), rows[first + 1 :])
    found = ((row[0], re.search(r"\(([\d.]+)x\)", row[cell])) for row in table)
    return {name: float(match[1]) for name, match in found if match and name != OURS}


def face() -> list[str]:
    """Returns the line on a call through the C interface."""
    data = json.loads((ROOT / "reports" / "face-cost.json").read_text(encoding="utf-8"))
    row = data["rows"][0]
    whole, engine = (1e9 * row[part] for part in ("fmu", "engine"))
    return [
        f"* On one {data['processor']}, a step without an event costs {whole:.0f} ns through the "
        f"C interface, {whole - engine:.0f} ns more than in the engine: `cargo bench-report face`."
    ]


def costs() -> list[str]:
    """Returns the line on the cost of other presets, in instructions per blow."""
    data = json.loads((ROOT / "reports" / "cost.json").read_text(encoding="utf-8"))
    scenes = {name: row[0] / data["blows"] for name, row in data["counts"]["scenes"].items()}
    reference = scenes.pop("reference")
    others = ", ".join(f"{name} {scenes[name]:.2g}" for name in scenes)
    actions = {name: row[0] for name, row in data["counts"]["actions"].items()}
    second, means, gradient = (
        next(actions[name] for name in actions if name.startswith(begin))
        for begin in ("a run of 1 s, new rock", "long-run means", "gradient")
    )
    return [
        f"* In a new rock a second of the reference takes {second:.0f} million instructions in "
        f"AVX2 vectors, its long-run means {means:.0f}, a second with its gradient by two "
        f"parameters {gradient:.0f}. A blow of it takes {reference:.2g}, one of others, in the "
        f"same unit: {others}. Measured by `cargo bench-report cost`."
    ]


def engines() -> list[str]:
    """Returns the line that names the engine of these figures."""
    path = ROOT / "reports" / "engine.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    stages = ("speed", "face", "cost", "verify")
    of = {stage: known.get(stage, {}).get("hammer/src", "not noted")[:12] for stage in stages}
    if {*of.values()} == {"not noted"}:
        return ["* All of this is of engines before the present one: `.ci/evidence` makes it anew."]
    if len({*of.values()}) == 1:
        return [f"* All of this is of one engine, {of['speed']} (`git rev-parse HEAD:hammer/src`)."]
    parts = ", ".join(f"{stage} {engine}" for stage, engine in of.items())
    return [f"* These figures are of several engines (`git rev-parse HEAD:hammer/src`): {parts}."]


def checks() -> list[str]:
    """Returns the lines on the simulator's verification."""
    page = (ROOT / "reports" / "verification.md").read_text(encoding="utf-8")
    held = re.search(r"^(\d+) of (\d+) checks hold", page, re.MULTILINE)
    drawn = re.search(
        r"(?P<scenes>\d+) scenes, (?P<whole>\d+) decided to their end, (?P<refused>\d+) refused, "
        r"(?P<events>\d+) events, .*?: (?P<unexplained>\d+) unexplained; excused (?P<rough>\d+) by "
        r"their rough bases, (?P<rest>\d+) after a guard at rest, (?P<unseen>\d+) below",
        page,
    )
    excused = sum(int(drawn[name]) for name in ("rough", "rest", "unseen"))
    return [
        f"* {held[1]} of {held[2]} checks hold, against closed forms, exact waves, extended "
        "precision and published benchmarks: `cargo verify`.",
        f"* Of {drawn['scenes']} random scenes with {drawn['events']} events, {drawn['whole']} are "
        f"decided to their end, {drawn['refused']} refused; the engine and one in extended "
        f"precision differ by more than is allowed in {excused}, excused as the report says, and "
        f"in {drawn['unexplained']} unexplained: `cargo compare --keep`.",
    ]


if __name__ == "__main__":
    main()
