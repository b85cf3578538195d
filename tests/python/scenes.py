"""Scenes that several tests simulate."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from oracle_fe import DATA, reference


@cache
def first_blow() -> dict[str, Any]:
    """The oracle's stored first blow of the reference hammer."""
    return json.loads((DATA / "first_blow.json").read_text())


# Cheap, yet everything happens: the piston is thrown at the bit from close by. The
# penalty is an element's own stiffness, so that collisions are clean.
SHORT = reference() | {
    "piston.elements": 5,
    "bit.elements": 5,
    "contact.stiffness": 1.6e10,
    "contact.initial_gap": 1e-3,
    "piston.initial_velocity": 9.0,
}
SHORT_END = 3e-3
