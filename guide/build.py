"""Builds the user guide: `cargo docs`, or `python guide/build.py` with the package at hand.

Pages come from guide/pages; their code is run here, and what it prints and draws stands under it.
The reference and the container's comparison are made here by the FMU itself; what takes minutes is
taken from guide/measured.
"""

from __future__ import annotations

import json
import logging
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mkdocs.commands.build import build
from mkdocs.config import load_config

ROOT = Path(__file__).resolve().parent.parent
GUIDE = ROOT / "guide"
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
sys.path[:0] = [str(GUIDE), str(ROOT / "examples")]

import blocks  # noqa: E402
import container  # noqa: E402
import layers  # noqa: E402
import modes  # noqa: E402
import pages_of_reference  # noqa: E402
from dth_hammer.figures import darken  # noqa: E402

#: A line that stands for an inserted file. In the page's source it is a link to that file.
INSERT = re.compile(r"^.*<!-- insert (\S+) -->$", re.MULTILINE)
#: Targets of links in the pages' sources, and on the site.
MOVED = {"../measured/": "measured/", "../../reports/": "reports/", "../../docs/": "reports/"}
CAPTION = re.compile(r"<!-- (\S+\.png): (.*?) -->\n*")


def main() -> None:
    """Collects the pages and everything made for them, and builds the site."""
    stage, site = TARGET / "guide-pages", TARGET / "guide"
    shutil.rmtree(stage, ignore_errors=True)
    gather(stage)
    draw(stage / "figures")
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        pages = sorted(stage.glob("*.md"))
        list(threads.map(fill, pages, (stage / "made" / page.stem for page in pages)))
    complete(stage, compare_masters)
    build_site(stage, site)
    print(f"guide: {site / 'index.html'}")


def gather(stage: Path) -> None:
    """Copies the pages, and the files that they include."""
    shutil.copytree(GUIDE / "pages", stage)
    shutil.copy(GUIDE / "style.css", stage)
    shutil.copytree(GUIDE / "vendor", stage, dirs_exist_ok=True)
    shutil.copytree(GUIDE / "measured", stage / "measured", ignore=shutil.ignore_patterns("*.md"))
    for page in stage.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for written, there in MOVED.items():
            text = text.replace(f"]({written}", f"]({there}")
        page.write_text(text, encoding="utf-8")


def complete(stage: Path, container_page: Callable[[], str]) -> None:
    """Replaces the placeholders, and adds the reference pages."""
    made = {
        "container": container_page,
        "reports": lambda: copy_reports(stage),
        "laboratory": lambda: embed_laboratory(stage),
    }
    for page in stage.glob("*.md"):
        text = INSERT.sub(lambda m: insert(m[1], made), page.read_text(encoding="utf-8"))
        page.write_text(text, encoding="utf-8")
    for name, (_, text) in (pages_of_reference.variables() | pages_of_reference.python()).items():
        (stage / name).write_text(text, encoding="utf-8")


def build_site(stage: Path, site: Path, *, strict: bool = True) -> None:
    """Writes the pages as HTML."""
    # Without a handler, mkdocs would stop at a broken link and not say which.
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    config = load_config(
        str(GUIDE / "mkdocs.yml"), docs_dir=str(stage), site_dir=str(site), strict=strict
    )
    reference = next(part["Reference"] for part in config.nav if "Reference" in part)
    for title, pages in {
        "Variables": pages_of_reference.variables(),
        "Python": pages_of_reference.python(),
    }.items():
        reference.append({title: [{entry: file} for file, (entry, _) in pages.items()]})
    config.plugins.on_startup(command="build", dirty=False)
    try:
        build(config)
    finally:
        config.plugins.on_shutdown()


def insert(name: str, made: dict[str, Callable[[], str]]) -> str:
    """Returns the text for ``<!-- insert name -->``: generated, of a page, or of a source file."""
    path = Path(name)
    if path.parts[0] == "generated":
        return made[path.stem]()
    folder = GUIDE if path.parts[0] == "measured" else ROOT
    text = (folder / path).read_text(encoding="utf-8")
    # A report begins with a title, but the page has its own.
    return re.sub(r"\A# .*\n+", "", text) if path.suffix == ".md" else f"```python\n{text}```"


def fill(page: Path, folder: Path) -> None:
    """Runs a page's blocks in this folder, and writes under each what it prints and draws."""
    text = page.read_text(encoding="utf-8")
    if not blocks.parse(text):
        return
    folder.mkdir(parents=True)
    for example in (ROOT / "examples").glob("*.py"):
        shutil.copy(example, folder)
    (folder / "dist").symlink_to(ROOT / "dist", target_is_directory=True)
    # Commands that set up the environment are skipped, because it is already set up.
    skip = ["--skip", "cargo", "--skip", "pip"]
    command = [sys.executable, GUIDE / "blocks.py", page, folder / "blocks.json", "--dark", *skip]
    programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    subprocess.run(command, cwd=folder, env=os.environ | {"PATH": programs}, check=True)
    found = json.loads((folder / "blocks.json").read_text(encoding="utf-8"))
    captions = dict(CAPTION.findall(text))
    ran = [blocks.Block(**row) for row in found]
    parts, end = [], 0
    for block in ran:
        parts += [text[end : block.end], *results(block, folder, captions)]
        end = block.end
    for other in folder.iterdir():
        if other.suffix not in blocks.FIGURES:
            shutil.rmtree(other) if other.is_dir() and not other.is_symlink() else other.unlink()
    page.write_text(CAPTION.sub("", "".join([*parts, text[end:]])), encoding="utf-8")
    print(f"guide: {page.stem}", flush=True)


def results(block: blocks.Block, folder: Path, captions: dict[str, str]) -> list[str]:
    """Returns the text under a block: its output, then its figures."""
    parts = [f"\n\n```text\n{block.output.rstrip()}\n```\n"] if block.output.strip() else []
    for name in block.figures:
        path = folder / name
        if path.stem.endswith("-dark"):
            continue
        where, words = f"made/{folder.name}", captions.get(name, path.stem)
        if path.suffix == ".html":
            parts.append(f"\n\n[{name}]({where}/{name})\n")
            continue
        dark = path.with_stem(f"{path.stem}-dark")
        shades = {name: "#only-light", dark.name: "#only-dark"} if dark.exists() else {name: ""}
        parts += ["\n\n", *(f"![{words}]({where}/{f}{s})" for f, s in shades.items()), "\n"]
    return parts


def draw(folder: Path) -> None:
    """Draws the figures that no page's code makes, for light and dark pages."""
    folder.mkdir()
    drawn = {"layers.png": layers.draw(layers.run()), "modes.svg": modes.draw()}
    for name, figure in drawn.items():
        path = folder / name
        figure.savefig(path)
        darken(figure).savefig(path.with_stem(f"{path.stem}-dark"))


def compare_masters() -> str:
    """Returns a table of the container's blows and those of the loop."""
    until, step = 0.4, 1e-3
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "coupled.fmu"
        container.build(file, step)
        two, loop = container.run_container(file, until), container.run_loop(until, step)
    rows = [
        f"| `{name}` | {two[name]:.9g} | {loop[name]:.9g} | {abs(two[name] / loop[name] - 1):.0e} |"
        for name in container.COMPARED
    ]
    head = [f"After {until:g} s with a step of {step * 1e3:g} ms:", ""]
    head += ["| | two FMUs, fmucontainer | loop in Python | relative difference |"]
    return "\n".join([*head, "|---|---|---|---|", *rows])


def embed_laboratory(stage: Path) -> str:
    """Copies the laboratory into the guide and returns its frame, or says that it is missing."""
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
    """Copies the pages of reports/ and docs/ into the guide, and returns a list of them."""
    shutil.copytree(ROOT / "reports", stage / "reports")
    shutil.copytree(ROOT / "docs", stage / "reports", dirs_exist_ok=True)
    items = []
    for page in sorted((stage / "reports").rglob("*.md")):
        lines = page.read_text(encoding="utf-8").splitlines()
        title = next((line.lstrip("# ") for line in lines if line.startswith("# ")), page.stem)
        items.append(f"* [{title}](reports/{page.relative_to(stage / 'reports').as_posix()})")
    return "\n".join(items)


if __name__ == "__main__":
    main()
