"""Builds the user guide: `cargo docs`, or `python guide/build.py` with the package at hand.

Pages come from guide/pages; figures, the reference and the container's comparison are
made here by the FMU itself; what takes minutes is taken from guide/measured.
"""

from __future__ import annotations

import logging
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure
from mkdocs.commands.build import build
from mkdocs.config import load_config

ROOT = Path(__file__).resolve().parent.parent
GUIDE = ROOT / "guide"
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
sys.path[:0] = [str(GUIDE), str(ROOT / "examples")]

import container  # noqa: E402
import layers  # noqa: E402
import modes  # noqa: E402
import pages_of_reference  # noqa: E402
from dth_hammer import figures, simulate, waves  # noqa: E402

HEADING = "| | two FMUs, fmucontainer | loop in Python | relative difference |"
INSERT = re.compile(r"\{\{ (\S+) \}\}")


def main() -> None:
    """Stages the pages with all that is made for them, and builds the site."""
    stage = TARGET / "guide-pages"
    shutil.rmtree(stage, ignore_errors=True)
    shutil.copytree(GUIDE / "pages", stage)
    shutil.copy(GUIDE / "style.css", stage)
    shutil.copytree(GUIDE / "measured", stage / "measured", ignore=shutil.ignore_patterns("*.md"))
    draw(stage / "figures")
    (stage / "variables.md").write_text(pages_of_reference.variables(), encoding="utf-8")
    (stage / "python.md").write_text(pages_of_reference.python(), encoding="utf-8")
    made = {
        "container": compare_masters,
        "reports": lambda: copy_reports(stage),
        "laboratory": lambda: embed_laboratory(stage),
    }
    for page in stage.glob("*.md"):
        text = INSERT.sub(lambda m: insert(m[1], made), page.read_text(encoding="utf-8"))
        page.write_text(text, encoding="utf-8")
    # Without a handler, mkdocs would stop at a broken link and not say which.
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    site = TARGET / "guide"
    config = load_config(str(GUIDE / "mkdocs.yml"), docs_dir=str(stage), site_dir=str(site))
    config.plugins.on_startup(command="build", dirty=False)
    try:
        build(config)
    finally:
        config.plugins.on_shutdown()
    print(f"guide: {site / 'index.html'}")


def insert(name: str, made: dict[str, Callable[[], str]]) -> str:
    """What stands for ``{{ name }}``: something made here, a page, or a source file."""
    path = Path(name)
    if path.parts[0] == "generated":
        return made[path.stem]()
    folder = GUIDE if path.parts[0] == "measured" else ROOT
    text = (folder / path).read_text(encoding="utf-8")
    return text if path.suffix == ".md" else f"```python\n{text}```"


def draw(folder: Path) -> None:
    """All figures that the FMU makes in seconds."""
    folder.mkdir()
    cycle, run, formation = figures.settled_cycle(until=0.6), simulate(until=0.6), layers.run()
    fine = {"piston.elements": 80, "bit.elements": 80}
    first = simulate({"rock.stiffness": 2e9}, until=1.0, preset="granite")
    drawn: dict[str, Figure] = {
        "overview.png": figures.overview(first),
        "cycle.png": figures.cycle(cycle),
        "rock.png": figures.rock_cycles(cycle),
        "ledger.png": figures.ledger(figures.at_blows(until=0.6)),
        "convergence.png": figures.convergence(run),
        "layers.png": layers.draw(formation),
        "waves.png": figures.wave_diagram(waves(fine, until=0.6)),
        "modes.svg": modes.draw(),
    }
    for name, figure in drawn.items():
        figure.savefig(folder / name, dpi=160)


def compare_masters() -> str:
    """Blows of the container beside those of the loop, as a table."""
    until, step = 0.4, 1e-5
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "coupled.fmu"
        container.build(file, step)
        two, loop = container.run_container(file, until), container.run_loop(until, step)
    rows = [
        f"| `{name}` | {two[name]:.9g} | {loop[name]:.9g} | {abs(two[name] / loop[name] - 1):.0e} |"
        for name in container.COMPARED
    ]
    head = [f"After {until:g} s with a step of {step * 1e6:.0f} µs:", ""]
    return "\n".join([*head, HEADING, "|---|---|---|---|", *rows])


def embed_laboratory(stage: Path) -> str:
    """The laboratory, copied into the guide, as a frame; or what is missing, by name."""
    page = ROOT / "dist" / "lab" / "index.html"
    if not page.is_file():
        print("skipped: the laboratory (dist/lab/index.html); `cargo lab` says what is missing")
        return "This copy of the guide was built without the laboratory: `cargo lab` makes it."
    shutil.copytree(page.parent, stage / "lab")
    return (
        '<iframe src="lab/index.html" title="The laboratory" class="laboratory"></iframe>\n\n'
        '<a href="lab/index.html">The laboratory on a page of its own</a>'
    )


def copy_reports(stage: Path) -> str:
    """The pages of docs/, copied into the guide and listed."""
    pages = sorted((ROOT / "docs").rglob("*.md"))
    if not pages:
        return "There are none yet."
    shutil.copytree(ROOT / "docs", stage / "reports")
    items = []
    for page in pages:
        lines = page.read_text(encoding="utf-8").splitlines()
        title = next((line.lstrip("# ") for line in lines if line.startswith("# ")), page.stem)
        items.append(f"* [{title}](reports/{page.relative_to(ROOT / 'docs').as_posix()})")
    return "\n".join(items)


if __name__ == "__main__":
    main()
