"""The motions that a hammer settles to from several starts."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ..errors import DomainError
from ..scene.variables import whole
from .longrun import Steady

#: How a start is chosen.
VELOCITY, GAP = "piston.initial_velocity", "contact.initial_gap"
#: Two motions are one if these means of them agree: those of cycles to this part, others within so
#: many standard errors of their difference.
COMPARED = ["period", "tip_rate", "blow_speed"]
SAME, DEVIATIONS = 1e-6, 4.0


def drawn(
    given: Mapping[str, float], speed: float, count: int, seed: int
) -> list[dict[str, float]]:
    """Returns a hammer for each start that is drawn: the piston anywhere above the bit, up to the
    gap of its own start, with any speed up to that of a blow.
    """
    if seed < 0:
        raise DomainError(f"seed = {seed} must be 0 or more")
    noise = np.random.default_rng(seed)
    velocities = noise.uniform(-speed, speed, count)
    gaps = noise.uniform(0.0, whole(given)[GAP], count)
    starts = zip(velocities.tolist(), gaps.tolist(), strict=True)
    return [{**given, VELOCITY: velocity, GAP: gap} for velocity, gap in starts]


def same(one: Steady, other: Steady) -> bool:
    """Returns whether two responses are of one motion, as far as their errors tell."""
    if one.kind != other.kind or one.kind == "stalled":
        return one.kind == other.kind
    means = one.mean[COMPARED] - other.mean[COMPARED]
    errors = np.hypot(one.error[COMPARED], other.error[COMPARED])
    allowed = DEVIATIONS * errors + SAME * one.mean[COMPARED].abs()
    return bool((means.abs() <= allowed).all())


def met(own: Steady, others: Sequence[Steady | str]) -> tuple[pd.DataFrame, list[str]]:
    """Returns one row per motion, and what is to be warned of.

    A row has the motion's kind, its share of the starts, and its means. The first is that of the
    hammer's own start, the others follow by their shares.
    """
    answers = [own, *(other for other in others if not isinstance(other, str))]
    motions: list[list[Steady]] = []
    for answer in answers:
        known = next((m for m in motions if same(m[0], answer)), None)
        if known is None:
            motions.append([answer])
        else:
            known.append(answer)
    motions[1:] = sorted(motions[1:], key=len, reverse=True)
    rows = [
        {"kind": m[0].kind, "starts": len(m), "share": len(m) / len(answers), **m[0].mean}
        for m in motions
    ]
    refused = [other for other in others if isinstance(other, str)]
    texts = [f"{len(refused)} of {len(others)} starts are refused: {refused[0]}"] if refused else []
    if len(rows) > 1:
        texts.append(f"where this hammer settles depends on its start: {_listed(rows)}")
    return pd.DataFrame(rows), texts


def _listed(motions: Sequence[Mapping[str, Any]]) -> str:
    """Returns shares and rates of motions, in words."""
    texts = []
    for row in motions:
        rate = "" if row["kind"] == "stalled" else f" at {1e3 * row['tip_rate']:.4g} mm/s (tip)"
        texts.append(f"{100 * row['share']:.0f} % {row['kind']}{rate}")
    return ", ".join(texts)
