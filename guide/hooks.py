"""Equations as MathML, typeset by the browser itself: no script, nothing from elsewhere."""

from __future__ import annotations

import re
from html import unescape
from typing import Any

from latex2mathml.converter import convert

INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)


def on_page_content(html: str, **_: Any) -> str:
    """Called by mkdocs with the HTML of each page."""
    html = BLOCK.sub(lambda m: convert(unescape(m[1]), display="block"), html)
    return INLINE.sub(lambda m: convert(unescape(m[1])), html)
