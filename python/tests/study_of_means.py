"""How often the stated error of a long-run mean holds: run it, it takes some minutes.

    python python/tests/study_of_means.py 200 10

Each hammer is irregular and has as many restarts as asked for, whose pistons begin with another
speed; `steady` seeks each to 1 %. The truth is a run to a seventh of that, whose error counts too.
The second argument says how many of the hammers; reports/means.md is written hammer by hammer. A
normal deviate is within one and two standard errors in 68 and 95 % of all cases; of 200 restarts
that is known to 3.3 and 1.5 %.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import PRESETS
from dth_hammer.scene.variables import numbers
from dth_hammer.study.longrun import Steady, Wanted, responses

#: Parameters of each hammer, and its preset. The named ones with next to no damping; a rock that
#: creeps, since the reference repeats without feed. Those that cost least come first.
FREE, BARE = {"feed_force": 0.0}, {"material.damping_time": 2e-8}
RIGID, CREEPS = {"fidelity": "Rigid"} | FREE, {"rock.viscosity": 1.7e5} | FREE
HAMMERS = {
    "rigid, no feed": (RIGID, None),
    "the same in hard rock": (RIGID | {"rock.stiffness": 3e8}, None),
    "soft rock, no feed": ({"rock.stiffness": 6e7} | FREE, None),
    "rock that creeps, no feed": (CREEPS, None),
    "rigid in a casing, no feed": (RIGID | {"casing.mass": 20.0}, None),
    "water_hammer, hardly damped": (BARE, "water_hammer"),
    "granite, no feed": (FREE | {"rock": "granite"}, None),
}
MEANS = ("rop", "tip_rate", "blow_energy")
REPORT = Path(__file__).parents[2] / "reports" / "means.md"


def means(scenes: list[dict[str, float]], wanted: Wanted) -> list[Steady]:
    """Long-run responses that do not repeat; a restart may end in a cycle, which has no error."""
    found = responses(scenes, wanted)
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
    rows = []
    long = means([numbers(preset, parameters)], Wanted(error=0.0015, blows=10_000_000))
    if not long:
        # It repeats after all.
        return pd.DataFrame(columns=[*MEANS, "blows"], dtype=float)
    (truth,) = long
    assert truth.reached
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


HEAD = """# How often errors of means hold

`steady` seeks each hammer to 1 % from many starts. A row counts how often the mean is within one
and two of its standard errors of the truth (68 and 95 % of a normal deviate), and the mean of that
deviation in standard errors (0 without bias).
"""


def main(count: int, hammers: int) -> None:
    """Measures and writes the report."""
    heads = ["hammer", "starts", "blows"]
    heads += [f"`{m}` {what}" for m in MEANS for what in ("within 1", "within 2", "mean z")]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    tables = []
    for hammer in [*HAMMERS][:hammers]:
        tables.append(pulls(hammer, count))
        lines.append(line(hammer, tables[-1]))
        print(lines[-1], flush=True)
        together = line(f"all {len(tables)}", pd.concat(tables))
        by = f"Written by `python python/tests/study_of_means.py {count} {hammers}`.\n"
        REPORT.write_text("\n".join([HEAD, by, *lines, together]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    assert {p for _, p in HAMMERS.values() if p} <= {*PRESETS}
    main(*map(int, sys.argv[1:3]))
