"""A page as a Jupyter notebook: its words, its blocks as cells, what they gave as outputs."""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any

import blocks
import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output

#: What a page takes in when it is built, and captions: no part of a notebook.
BUILT = re.compile(r"<!--.*?-->\n*|\{\{.*?\}\}\n*|!\[[^\]]*\]\([^)]*\)\n*", re.DOTALL)


def notebook(text: str, found: list[blocks.Block], folder: Path) -> Any:
    """The notebook of a page.

    Args:
        text: the page.
        found: its blocks, run.
        folder: where their figures are.
    """
    cells, end = [], 0
    for block in found:
        words = BUILT.sub("", text[end : start(text, block)]).strip()
        if words:
            cells.append(new_markdown_cell(words))
        end = block.end
        if block.kind == "text" and not block.title:
            cells.append(new_markdown_cell(f"```text\n{block.code}```"))
        else:
            cells.append(new_code_cell(source(block), outputs=[*outputs(block, folder)]))
    words = BUILT.sub("", text[end:]).strip()
    if words:
        cells.append(new_markdown_cell(words))
    for number, cell in enumerate(cells):
        # The same page makes the same file.
        cell["id"] = f"cell-{number}"
    made = new_notebook(cells=cells)
    made.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3"}
    made.metadata["language_info"] = {"name": "python"}
    nbformat.validate(made)
    return made


def start(text: str, block: blocks.Block) -> int:
    """Where a block begins in its page."""
    return text.rindex(f"```{block.kind}", 0, block.end - len(block.code) - len("```"))


def source(block: blocks.Block) -> str:
    """A block as a cell: files are written, commands go to the shell."""
    if block.title:
        return f"%%writefile {block.title}\n{block.code}".rstrip()
    if block.kind == "console":
        return "\n".join(f"!{command}" for command in blocks.commands(block.code))
    return block.code.rstrip()


def outputs(block: blocks.Block, folder: Path) -> list[Any]:
    """What a cell shows."""
    outputs = [new_output("stream", name="stdout", text=block.output)] if block.output else []
    for name in block.figures:
        path = folder / name
        if path.suffix == ".png" and not path.stem.endswith("-dark"):
            picture = base64.b64encode(path.read_bytes()).decode("ascii")
            outputs.append(new_output("display_data", data={"image/png": picture}))
    return outputs
