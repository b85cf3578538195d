"""Warnings of settings that are allowed but probably unintended, each given once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from .. import _native


class Diagnostics:
    """The settings of a hammer so far, and warnings about them."""

    def __init__(self, start: Mapping[str, float]) -> None:
        self._start, self._set = dict(start), {*start}
        self._stepped = False

    def start(self) -> Iterator[str]:
        """Warnings about the scene at its start."""
        yield from (why for _, why in _native.unread(self._start, [*self._start]))
        yield from _native.unlikely(self._start)

    def set(self, names: Iterable[str]) -> list[str]:
        """Warnings about inputs that are set now and not read."""
        fresh = [name for name in names if name not in self._set]
        self._set.update(fresh)
        return [why for _, why in _native.unread(self._start, fresh)] if fresh else []

    def step(self) -> list[str]:
        """At the first step, a warning if no input of the drive was set."""
        if self._stepped:
            return []
        self._stepped = True
        why = _native.starved(self._start, [*self._set])
        return [why] if why else []
