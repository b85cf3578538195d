"""What is accepted but is likely not meant: told once, as a warning, in the engine's words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from . import _native


class Diagnostics:
    """What was set on a hammer so far, and what of it is not read."""

    def __init__(self, start: Mapping[str, float]) -> None:
        self._start, self._set = dict(start), {*start}
        self._stepped = False

    def start(self) -> Iterator[str]:
        """What is doubtful of the scene as it was given."""
        yield from (why for _, why in _native.unread(self._start, [*self._start]))
        yield from _native.unlikely(self._start)

    def set(self, names: Iterable[str]) -> list[str]:
        """What is not read of what is set now."""
        fresh = [name for name in names if name not in self._set]
        self._set.update(fresh)
        return [why for _, why in _native.unread(self._start, fresh)] if fresh else []

    def step(self) -> list[str]:
        """Before the first step: whether the drive gets an input that it needs."""
        if self._stepped:
            return []
        self._stepped = True
        why = _native.starved(self._start, [*self._set])
        return [why] if why else []
