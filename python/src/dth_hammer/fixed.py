"""A dictionary that tables carry along: pandas copies what a table carries at every operation."""

from __future__ import annotations

from typing import Any


class Fixed(dict[str, str]):
    """Texts by name that nobody changes: a copy shares them."""

    def __deepcopy__(self, _memo: dict[int, Any]) -> Fixed:
        return self
