"""Piston and bit as the FMU's parameters make them: sections, and where the mesh has nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .variables import Array

PISTON, BIT = "piston", "bit"


@dataclass(frozen=True)
class Section:
    """A uniform part of a body."""

    #: m
    length: float
    #: m2
    area: float


def sections(numbers: Mapping[str, float], body: str) -> list[Section]:
    """The sections of a body from top to bottom; numbers of all its parameters are needed."""
    count = int(numbers.get(f"{body}.segments", 0))
    if count == 0:
        return [Section(numbers[f"{body}.length"], numbers["cross_section"])]
    return [
        Section(numbers[f"{body}.segment[{k}].length"], numbers[f"{body}.segment[{k}].area"])
        for k in range(1, count + 1)
    ]


def length(numbers: Mapping[str, float], body: str) -> float:
    """Length of a body, m."""
    return sum(section.length for section in sections(numbers, body))


def mass(numbers: Mapping[str, float], body: str) -> float:
    """Mass of a body, kg."""
    volume = sum(section.length * section.area for section in sections(numbers, body))
    return numbers["material.density"] * volume


def elements(numbers: Mapping[str, float], body: str) -> int:
    """Spans of a body's mesh: its elements, at least one a section."""
    return max(int(numbers[f"{body}.elements"]), int(numbers.get(f"{body}.segments", 0)))


def nodes(numbers: Mapping[str, float], body: str) -> Array:
    """Distances of the mesh's nodes below the body's upper face, m.

    The spans are shared as the FMU does it: one a section, then each of the rest to the
    section whose spans are longest.
    """
    parts = sections(numbers, body)
    spans = [1] * len(parts)
    for _ in range(len(parts), elements(numbers, body)):
        sizes = [part.length / count for part, count in zip(parts, spans, strict=True)]
        spans[int(np.argmax(sizes))] += 1
    marks, top = [np.zeros(1)], 0.0
    for part, count in zip(parts, spans, strict=True):
        marks.append(top + part.length * np.arange(1, count + 1) / count)
        top += part.length
    return np.concatenate(marks)
