"""How often the stated error of a long-run mean holds: run it, it takes some minutes.

    python python/tests/study_of_means.py 200

Each hammer is irregular and has as many restarts as asked for, whose pistons begin with another
speed; `steady` seeks each to 1 %. The truth is a run to a fifth of that, and its own error counts.
reports/means.md is written from it. A normal deviate is within one and two standard errors in 68
and 95 % of all cases; of 200 restarts that is known to 3.3 and 1.5 %.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import PRESETS
from dth_hammer.longrun import Steady, Wanted, responses
from dth_hammer.variables import numbers

#: Parameters of each hammer, and its preset. The named ones with next to no damping.
FREE, BARE = {"feed_force": 0.0}, {"material.damping_time": 2e-8}
HAMMERS = {
    "rigid, no feed": ({"fidelity": "Rigid"} | FREE, None),
    "the same in hard rock": ({"fidelity": "Rigid", "rock.stiffness": 3e8} | FREE, None),
    "reference, no feed": (FREE, None),
    "the same in soft rock": ({"rock.stiffness": 6e7} | FREE, None),
    "chambers, no feed": ({"drive.source": "Chambers"} | FREE, None),
    "the same, rigid": ({"drive.source": "Chambers", "fidelity": "Rigid"} | FREE, None),
    "granite, no feed": (FREE, "granite"),
    "hammer_2_inch, hardly damped": (BARE, "hammer_2_inch"),
    "hammer_3_inch, hardly damped": (BARE, "hammer_3_inch"),
    "rigid in a casing, no feed": ({"casing.mass": 20.0, "fidelity": "Rigid"} | FREE, None),
}
MEANS = ("rop", "tip_rate", "blow_energy")
REPORT = Path(__file__).parents[2] / "reports" / "means.md"


def means(scenes: list[dict[str, float]], wanted: Wanted) -> list[Steady]:
    """Long-run responses that do not repeat; a restart may end in a cycle, which has no error."""
    found = [answer for _, answer in sorted(responses(scenes, wanted), key=lambda f: f[0])]
    assert all(isinstance(answer, Steady) for answer in found), found
    return [answer for answer in found if answer.kind == "irregular"]


def restarted(hammer: str, count: int) -> list[dict[str, float]]:
    """The hammer with other speeds of the piston at the start."""
    parameters, preset = HAMMERS[hammer]
    chance = np.random.default_rng(23)
    scene = numbers(preset, parameters)
    return [scene | {"piston.initial_velocity": v} for v in chance.uniform(-0.3, 0.3, count)]


def pulls(hammer: str, count: int) -> pd.DataFrame:
    """A row a restart: how far each mean is off, over its standard error."""
    parameters, preset = HAMMERS[hammer]
    (truth,) = means([numbers(preset, parameters)], Wanted(error=0.002, blows=10_000_000))
    assert truth.reached
    rows = []
    for found in means(restarted(hammer, count), Wanted()):
        off = (found.mean - truth.mean) / np.hypot(found.error, truth.error)
        rows.append({**off[[*MEANS]], "blows": found.blows})
    return pd.DataFrame(rows)


def line(name: str, table: pd.DataFrame) -> str:
    """A row of the report."""
    cells = [name, f"{len(table)}", f"{table['blows'].median():.0f}"]
    for mean in MEANS:
        z = table[mean]
        cells += [f"{(z.abs() < 1).mean():.0%}", f"{(z.abs() < 2).mean():.0%}", f"{z.mean():+.2f}"]
    return f"| {' | '.join(cells)} |"


def main(count: int) -> None:
    """Measures and writes the report."""
    heads = ["hammer", "restarts", "blows"]
    heads += [f"`{m}` {what}" for m in MEANS for what in ("within 1", "within 2", "mean z")]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    tables = []
    for hammer in HAMMERS:
        tables.append(pulls(hammer, count))
        lines.append(line(hammer, tables[-1]))
        print(lines[-1], flush=True)
    lines.append(line("all", pd.concat(tables)))
    command = f"Written by `python python/tests/study_of_means.py {count}`.\n"
    REPORT.write_text("\n".join([command, *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    assert {p for _, p in HAMMERS.values() if p} <= {*PRESETS}
    main(int(sys.argv[1]))
