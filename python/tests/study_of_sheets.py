"""How often the 80 % ranges of a sheet hold what makers print, each number held out in turn.

    python python/tests/study_of_sheets.py

Reads `reports/makers.csv` and writes `reports/sheets.md`. Of a hammer one number is held out (the
piston's mass, air at one pressure, power, blows a minute, middle of the feed's range), and the rest
of its rows is the sheet. Of its hammers of 3.5 to 6 inches at 24 bar Sandvik prints 35 to 45 Hz
together: the range of each must overlap with that, which is told and not counted.

A range is of the hammer, and what is printed of it scatters about that by the errors that a sheet
assumes of what it is given: how often the range with this scatter holds is told beside.
"""

import warnings
from collections.abc import Iterator
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd
from dth_hammer import Datasheet, HammerWarning, _native, from_datasheet

REPORTS = Path(__file__).parents[2] / "reports"
KGF = 9.80665
#: By name, what makers' numbers scatter by.
SCATTER = {row[0]: row[5] for row in _native.datasheet_numbers()}
#: Standard deviations from the middle to an end of a range of 80 %.
END = NormalDist().inv_cdf(0.9)
#: Blows a minute, and of which hammers together.
TOGETHER = (2100.0, 2700.0), [f"Sandvik {size} inch" for size in ("3.5", "4", "5", "6")]


def sheet(rows: pd.DataFrame) -> dict[str, Any]:
    """What all rows of a hammer say."""
    first = rows.iloc[0]
    given: dict[str, Any] = {
        "od": (first["outside_mm"], "mm"),
        "piston_mass": (first["piston_kg"], "kg"),
        "hole": (0.5 * (first["hole_min_mm"] + first["hole_max_mm"]), "mm"),
        "length": (first["length_mm"], "mm"),
        "power": (rows["power_kw"].max(), "kW"),
        "frequency": (rows["blows_per_min"].max(), "1/min"),
        "feed": (0.5 * KGF * (first["feed_min_kgf"] + first["feed_max_kgf"]), "N"),
    }
    texts = {name: f"{float(x)!r} {unit}" for name, (x, unit) in given.items() if np.isfinite(x)}
    air = rows.dropna(subset="air_m3_per_min")
    pairs = zip(air["pressure_bar"], air["air_m3_per_min"], strict=True)
    texts["pressure"] = f"{float(rows['pressure_bar'].max())!r} bar"
    return texts | {"air_flow": {f"{p:g} bar": f"{q:g} m3/min" for p, q in pairs}}


def held_out(rows: pd.DataFrame) -> Iterator[tuple[str, float, Datasheet, str, float]]:
    """Each number in turn: name, printed, sheet of the rest, its name there, size of its unit."""
    whole = sheet(rows)
    printed = {
        "piston_mass": ("piston mass", 1.0),
        "power": ("power of the blows", 1e3),
        "frequency": ("frequency", 1 / 60),
        "feed": ("feed", 1.0),
    }
    for name, (column, size) in printed.items():
        if name in whole and ("od" in whole or name != "piston_mass"):
            rest = {n: x for n, x in whole.items() if n != name and x}
            yield name, float(whole[name].split()[0]), from_datasheet(**rest), column, size
    for pressure, air in whole["air_flow"].items():
        others = {p: q for p, q in whole["air_flow"].items() if p != pressure}
        rest = {n: x for n, x in whole.items() if n != "air_flow"} | {"at": pressure}
        found = from_datasheet(**rest, **({"air_flow": others} if others else {}))
        yield f"air at {pressure}", float(air.split()[0]), found, "free air", 1 / 60


def table() -> pd.DataFrame:
    """A row for each number that is held out."""
    makers, found = pd.read_csv(REPORTS / "makers.csv"), []
    for model, rows in makers.groupby("model", sort=False):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", HammerWarning)
            for name, printed, answer, column, size in held_out(rows):
                low, high = (side / size for side in answer.ranges[column])
                row = {"hammer": model, "held out": name, "printed": f"{printed:.4g}"}
                error = SCATTER["air_flow" if name.startswith("air") else name]
                half = np.log(high / low) / 2
                wide = np.hypot(half, END * error if np.isfinite(error) else 0.0)
                row["scattered"] = abs(np.log(printed / np.sqrt(low * high))) <= wide
                found.append(row | {"low": low, "high": high, "holds": low <= printed <= high})
            if model in TOGETHER[1]:
                (least, most), answer = TOGETHER[0], from_datasheet(**sheet(rows))
                low, high = (60 * side for side in answer.ranges["frequency"])
                row = {
                    "hammer": model,
                    "held out": "frequency",
                    "printed": f"{least:g} to {most:g}",
                }
                found.append(
                    row | {"low": low, "high": high, "holds": low <= most and least <= high}
                )
    return pd.DataFrame(found)


def report(found: pd.DataFrame) -> str:
    """The table, under a heading of its own."""
    counted = found[~found["printed"].str.contains("to")]
    alone, scattered = counted["holds"], counted["scattered"].astype(bool)
    lines = ["# What makers print, held out of their sheets", ""]
    air = f"{SCATTER['air_flow']:.0%}"
    lines += [
        f"{alone.sum()} of {len(alone)} ranges of 80 % hold it: {alone.mean():.1%}.",
        "",
        f"With what makers' numbers scatter by (air by {air}, as a sheet assumes of one given),",
        f"{scattered.sum()} do: {scattered.mean():.1%}.",
        "",
    ]
    lines += ["| hammer | held out | printed | range of 80 % | holds |", "|---" * 5 + "|"]
    for row in found.to_dict("records"):
        number = f"{row['printed']} | {row['low']:.3g} to {row['high']:.3g}"
        holds = "yes" if row["holds"] else "**no**"
        lines.append(f"| {row['hammer']} | {row['held out']} | {number} | {holds} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    text = report(table())
    (REPORTS / "sheets.md").write_text(text, encoding="utf-8")
    print(text, end="")
