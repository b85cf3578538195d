"""A dictionary for a table's ``attrs``, which pandas copies at every operation."""

from __future__ import annotations

from typing import Any


class Fixed(dict[str, str]):
    """An immutable dictionary of texts: copies share it."""

    def __deepcopy__(self, _memo: dict[int, Any]) -> Fixed:
        return self
