"""The motions that a hammer settles to from several initial states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import DomainError
from ..frames import np, pd
from ..scene.variables import whole
from .longrun import Steady

VELOCITY, GAP = "piston.initial_velocity", "contact.initial_gap"
#: Two responses are of the same motion if these means agree: within `DEVIATIONS` standard errors of
#: the difference, plus the relative difference `SAME`, which alone counts for cycles.
COMPARED = ["period", "tip_rate", "blow_speed"]
SAME, DEVIATIONS = 1e-6, 4.0


def random_starts(
    given: Mapping[str, float], speed: float, count: int, seed: int
) -> list[dict[str, float]]:
    """Returns hammers with random initial states of the piston.

    Its gap to the bit is drawn between 0 and the hammer's own initial gap, its velocity between
    ``-speed`` and ``speed``, m/s.
    """
    if seed < 0:
        raise DomainError(f"seed = {seed} must be 0 or more")
    noise = np.random.default_rng(seed)
    velocities = noise.uniform(-speed, speed, count)
    gaps = noise.uniform(0.0, whole(given)[GAP], count)
    starts = zip(velocities.tolist(), gaps.tolist(), strict=True)
    return [{**given, VELOCITY: velocity, GAP: gap} for velocity, gap in starts]


def same(first: Steady, second: Steady) -> bool:
    """Returns whether two responses are of the same motion, within their errors."""
    if first.kind != second.kind or first.kind == "stalled":
        return first.kind == second.kind
    means = first.mean[COMPARED] - second.mean[COMPARED]
    errors = np.hypot(first.error[COMPARED], second.error[COMPARED])
    allowed = DEVIATIONS * errors + SAME * first.mean[COMPARED].abs()
    return bool((means.abs() <= allowed).all())


def motions_of(own: Steady, others: Sequence[Steady | str]) -> tuple[pd.DataFrame, list[str]]:
    """Returns a table with one row per motion, and warnings.

    A row has the motion's kind, its number and share of the starts, and its means. The first motion
    is that from the hammer's own start; the others follow, the most frequent first.
    """
    answers = [own, *(other for other in others if not isinstance(other, str))]
    motions: list[list[Steady]] = []
    for answer in answers:
        motion = next((m for m in motions if same(m[0], answer)), None)
        if motion is None:
            motions.append([answer])
        else:
            motion.append(answer)
    motions[1:] = sorted(motions[1:], key=len, reverse=True)
    rows = [
        {"kind": m[0].kind, "starts": len(m), "share": len(m) / len(answers), **m[0].mean}
        for m in motions
    ]
    refused = [other for other in others if isinstance(other, str)]
    warnings = (
        [f"{len(refused)} of {len(others)} starts are refused: {refused[0]}"] if refused else []
    )
    if len(rows) > 1:
        warnings.append(f"where this hammer settles depends on its start: {_in_words(rows)}")
    return pd.DataFrame(rows), warnings


def _in_words(motions: Sequence[Mapping[str, Any]]) -> str:
    """Returns shares and rates of the motions as text."""
    texts = []
    for row in motions:
        rate = "" if row["kind"] == "stalled" else f" at {1e3 * row['tip_rate']:.4g} mm/s (tip)"
        texts.append(f"{100 * row['share']:.0f} % {row['kind']}{rate}")
    return ", ".join(texts)
