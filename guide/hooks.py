"""Equations as MathML, which the browser typesets itself, and a name for the theme's search."""

from __future__ import annotations

import re
from html import unescape
from typing import Any

from latex2mathml.converter import convert

INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
BOLD = re.compile(r'<mi mathvariant="bold">([A-Za-z])</mi>')
BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)


def on_page_content(html: str, **_: Any) -> str:
    """Called by mkdocs with the HTML of each page."""
    html = BLOCK.sub(lambda m: mathml(m[1], "block"), html)
    return INLINE.sub(lambda m: mathml(m[1], "inline"), html)


def on_post_page(output: str, **_: Any) -> str:
    """Called by mkdocs with each page: names the search dialog for screen readers."""
    return output.replace('role="dialog">', 'role="dialog" aria-label="Search">')


def mathml(latex: str, display: str) -> str:
    """Returns an equation as MathML, with bold letters as characters that all browsers know."""
    return BOLD.sub(lambda m: f"<mi>{bold(m[1])}</mi>", convert(unescape(latex), display=display))


def bold(letter: str) -> str:
    """Returns the mathematical bold letter."""
    first = 0x1D400 - ord("A") if letter.isupper() else 0x1D41A - ord("a")
    return chr(first + ord(letter))
