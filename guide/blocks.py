"""Runs the code blocks of a page, in order, and says what each printed and which figures it made.

    python guide/blocks.py PAGE.md OUT.json [--dark] [--skip WORD] [WORD=FOLDER]

Needs nothing but Python, so that it runs where a user's commands do. In a page

* a block with ``title="name"`` is written to that file;
* a block of ``python`` is run, all of a page in one interpreter;
* a block of ``console`` is commands for a shell, run as they stand;
* a block of ``text`` is shown: it is what the block before it printed, or something to read;
* a block of ``rust`` is shown: doctests run it.

No other block is known, so that none escapes.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import re
import subprocess
import sys
import traceback
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

FENCE = re.compile(r"^```(\w*)(?: title=\"([^\"]+)\")?\n(.*?)^```$", re.DOTALL | re.MULTILINE)
KINDS = ("python", "console", "text", "rust")
#: File types that count as a block's figures.
FIGURES = (".png", ".svg", ".html")


@dataclass
class Block:
    """A block of a page, and what running it printed and drew."""

    kind: str
    code: str
    #: Offset of the block's end in the page.
    end: int
    title: str = ""
    output: str = ""
    figures: list[str] = field(default_factory=list)
    failed: bool = False


def parse(text: str) -> list[Block]:
    """Returns the blocks of a page; an unknown kind is an error."""
    found = [Block(m[1], m[3], m.end(), m[2] or "") for m in FENCE.finditer(text)]
    strange = {block.kind for block in found if not block.title} - {*KINDS}
    # Opening and closing fences: two per block.
    if strange or len(re.findall(r"^\s*```", text, re.MULTILINE)) != 2 * len(found):
        raise ValueError(f"a page has blocks of {', '.join(KINDS)} only, not {strange or '?'}")
    if re.search(r"\n\n    (?!\*|-|\d)[a-z]", FENCE.sub("", text)):
        raise ValueError("code stands in fences, not indented")
    return found


def run(text: str, where: dict[str, Path] | None = None, skip: tuple[str, ...] = ()) -> list[Block]:
    """Runs a page's blocks in this process and this folder; stops at the first that fails.

    Args:
        text: the page.
        where: folders for commands that begin with a word, for instance those of cargo.
        skip: words; a block of commands that begin with them is not run.
    """
    names: dict[str, Any] = {"__name__": "__page__"}
    blocks = parse(text)
    for number, block in enumerate(blocks, 1):
        before = _pictures()
        if block.title:
            Path(block.title).write_text(block.code, encoding="utf-8")
        elif block.kind == "python":
            block.output, block.failed = _execute(block.code, f"block {number}", names)
        elif block.kind == "console" and {c.split()[0] for c in commands(block.code)} <= {*skip}:
            continue
        elif block.kind == "console":
            block.output, block.failed = _shell(block.code, where or {})
        after = _pictures()
        block.figures = [name for name in after if after[name] != before.get(name)]
        if block.failed:
            break
    return blocks


def commands(code: str) -> Iterator[str]:
    """Yields the commands of a console block, without comments; continued lines are joined."""
    for line in code.replace("\\\n", " ").splitlines():
        command = re.sub(r"\s+#.*", "", line).strip()
        if command and not command.startswith("#"):
            yield command


def _execute(code: str, name: str, names: dict[str, Any]) -> tuple[str, bool]:
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            exec(compile(code, name, "exec"), names)
        except Exception:
            traceback.print_exc()
            return said.getvalue(), True
    return said.getvalue(), False


def _shell(code: str, where: dict[str, Path]) -> tuple[str, bool]:
    said = ""
    for command in commands(code):
        folder = where.get(command.split()[0])
        done = subprocess.run(
            command,
            shell=True,
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            check=False,
        )
        said += done.stdout
        if done.returncode:
            return f"{said}\n{command}: {done.returncode}", True
    return said, False


def _pictures() -> dict[str, int]:
    return {p.name: p.stat().st_mtime_ns for p in sorted(Path().iterdir()) if p.suffix in FIGURES}


def save_twice() -> None:
    """Makes each saved figure be saved for a dark page too, as NAME-dark.png."""
    from dth_hammer.figures import darken  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    plain = Figure.savefig

    def save(figure: Figure, name: Any, *arguments: Any, **named: Any) -> None:
        plain(figure, name, *arguments, **named)
        if isinstance(name, (str, Path)):
            path = Path(name)
            plain(darken(figure), path.with_stem(f"{path.stem}-dark"), *arguments, **named)

    Figure.savefig = save  # type: ignore[method-assign]


def main() -> None:
    """Runs a page, and writes what it found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("where", nargs="*", metavar="WORD=FOLDER")
    parser.add_argument("--skip", action="append", default=[], metavar="WORD")
    parser.add_argument("--dark", action="store_true", help="save figures for dark pages too")
    options = parser.parse_args()
    # Imports look in this folder first, as for a script in it.
    sys.path[0] = str(Path.cwd())
    if options.dark:
        save_twice()
    where = {word: Path(folder) for word, _, folder in (a.partition("=") for a in options.where)}
    blocks = run(options.page.read_text(encoding="utf-8"), where, tuple(options.skip))
    options.out.write_text(json.dumps([asdict(block) for block in blocks]), encoding="utf-8")
    failed = [block for block in blocks if block.failed]
    if failed:
        sys.exit(f"{options.page.name}:\n{failed[0].code}\n{failed[0].output}")


if __name__ == "__main__":
    main()
