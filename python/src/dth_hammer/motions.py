"""The motions that a hammer settles to from several starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from .errors import DomainError, warn
from .longrun import MEANS, Steady
from .variables import whole

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


def met(answers: Sequence[Steady]) -> pd.DataFrame:
    """Returns one row per motion: its kind, its share of the starts, and its means.

    The first is that of the first answer, the others follow by their shares.
    """
    motions: list[list[Steady]] = []
    for answer in answers:
        known = next((m for m in motions if same(m[0], answer)), None)
        if known is None:
            motions.append([answer])
        else:
            known.append(answer)
    motions[1:] = sorted(motions[1:], key=len, reverse=True)
    rows = [
        {"kind": m[0].kind, "starts": len(m), "share": len(m) / len(answers), **m[0].mean[[*MEANS]]}
        for m in motions
    ]
    return pd.DataFrame(rows)


def beside(found: Steady, others: Sequence[Steady | str]) -> Steady:
    """Returns a response with the motions of other starts; warns if there is more than one."""
    motions = met([found, *(other for other in others if not isinstance(other, str))])
    refused = [other for other in others if isinstance(other, str)]
    texts = [f"{len(refused)} of {len(others)} starts are refused: {refused[0]}"] if refused else []
    if len(motions) > 1:
        listed = ", ".join(
            f"{100 * row['share']:.0f} % {row['kind']}"
            + (f" at {1e3 * row['tip_rate']:.4g} mm/s (tip)" if row["kind"] != "stalled" else "")
            for row in motions.to_dict("records")
        )
        texts.append(f"where this hammer settles depends on its start: {listed}")
    for text in texts:
        warn(text)
    return replace(found, motions=motions, warnings=(*found.warnings, *texts))
