"""Measures what the guide tells of coupling, feed and scaling: `cargo docs --measure`.

The results are committed in guide/measured, with the machine they were measured on.
"""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MEASURED = ROOT / "guide" / "measured"
sys.path.insert(0, str(ROOT / "examples"))


def coupling() -> None:
    """Which step a coupled hammer needs."""
    import coupling_steps  # noqa: PLC0415

    for name in coupling_steps.MODELS:
        table = coupling_steps.measure(name)
        picture = MEASURED / f"{name}.png"
        coupling_steps.draw(table).savefig(picture, dpi=160)
        text = coupling_steps.report(table, f"measured/{picture.name}")
        (MEASURED / f"{name}.md").write_text(text, encoding="utf-8")


def feed() -> None:
    """The feed force that drills fastest."""
    import best_feed  # noqa: PLC0415

    table = best_feed.run(scheduler="threads")
    best_feed.draw(table).savefig(MEASURED / "feed.png", dpi=160)
    lines = [
        "| rock | best feed kN | mean ROP mm/s | ROP at the least feed mm/s |",
        "|---|---|---|---|",
    ]
    for row in best_feed.best(table).itertuples():
        edge = " (end of the range)" if row.feed_force == table["feed_force"].max() else ""
        least = table[table["rock"] == row.rock].nsmallest(1, "feed_force")["rop_mean"].iloc[0]
        lines.append(
            f"| {row.rock} | {row.feed_force / 1e3:.0f}{edge} | {row.rop_mean * 1e3:.1f} "
            f"| {least * 1e3:.1f} |"
        )
    (MEASURED / "feed.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def scale() -> None:
    """One worker and two."""
    import scaling  # noqa: PLC0415

    runs, until, cores = 100, 1.0, os.cpu_count() or 1
    before = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    text = scaling.report(scaling.measure(runs, until), runs, until)
    text += f"\n{cores} cores ({platform.machine()}), load average before it {before:.1f}.\n"
    if before > 0.5:
        text += "Other work had the cores too, so the speed-up is no measure of scaling.\n"
    (MEASURED / "scaling.md").write_text(text, encoding="utf-8")


def main(chosen: list[str]) -> None:
    """Measures what is named, or all."""
    MEASURED.mkdir(exist_ok=True)
    for name, task in {"feed": feed, "scaling": scale, "coupling": coupling}.items():
        if not chosen or name in chosen:
            print(f"measuring {name}")
            task()


if __name__ == "__main__":
    main(sys.argv[1:])
