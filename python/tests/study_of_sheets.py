"""How often the 80 % ranges of a sheet contain makers' numbers, each held out in turn.

    python python/tests/study_of_sheets.py

Reads `reports/makers.csv` and writes `reports/sheets.md`. Of a hammer one number is held out (the
piston's mass, air at one pressure, power, blows a minute, middle of the feed's range), and the rest
of its rows is the sheet. Of its hammers of 3.5 to 6 inches at 24 bar Sandvik prints 35 to 45 Hz
together: the range of each must overlap with that, which is told and not counted.

A range is of the hammer, and what is printed of it scatters about that by the errors that a sheet
assumes of what it is given: how often the range with this scatter holds is told beside.

Ratios are held out too: of the power of two hammers whose air is given, of the air of two hammers
at one pressure of which no air is given, and of the air of one hammer at two pressures, of which
that at the lower is given.
"""

import itertools
import warnings
from collections.abc import Iterator
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd
from dth_hammer import Datasheet, HammerWarning, _native, compare, from_datasheet

REPORTS = Path(__file__).parents[2] / "reports"
KGF = 9.80665
#: Relative scatter of makers' numbers, by name.
SCATTER = {row[0]: row[5] for row in _native.datasheet_numbers()}
#: Standard deviations from the middle to an end of an 80 % range.
END = NormalDist().inv_cdf(0.9)
#: A printed range of blows per minute, and the hammers for which it is printed.
TOGETHER = (2100.0, 2700.0), [f"Sandvik {size} inch" for size in ("3.5", "4", "5", "6")]


def sheet(rows: pd.DataFrame) -> dict[str, Any]:
    """Returns the sheet from all rows of a hammer."""
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
    """Yields per number: name, printed value, sheet of the rest, name there, size of unit."""
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
    """Returns a row per number that is held out."""
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


#: The compared ratios, with the text of the report.
POWERS, SIZES, PRESSURES = (
    "power of two hammers",
    "air of two hammers at one pressure",
    "air of one hammer at two pressures",
)
#: Pressures that differ by less are equal; printed pressures below belong to another kind of
#: hammer.
ONE_PRESSURE, LOW = 0.03, 9.0


def ratios() -> pd.DataFrame:
    """Returns a row per printed ratio that is held out."""
    makers, found = pd.read_csv(REPORTS / "makers.csv"), []
    powers, alone = {}, {}
    warnings.simplefilter("ignore", HammerWarning)

    def add(kind: str, names: tuple[str, str], printed: float, ratio: pd.Series) -> None:
        holds = ratio["low"] <= printed <= ratio["high"]
        row = {"kind": kind, "a": names[0], "b": names[1], "printed": printed, **ratio}
        found.append(row | {"holds": holds})

    for model, rows in makers[makers["outside_mm"].notna()].groupby("model", sort=False):
        whole = sheet(rows)
        base = {n: x for n, x in whole.items() if n not in ("power", "frequency", "air_flow")}
        if "power" in whole and len(whole["air_flow"]) > 2:
            rest = {n: x for n, x in whole.items() if n != "power"}
            powers[model] = from_datasheet(**rest), float(rows["power_kw"].max())
        pairs = [(float(p.split()[0]), q) for p, q in whole["air_flow"].items()]
        for pressure, air in pairs:
            at = base | {"pressure": f"{pressure} bar"}
            alone[model, pressure] = from_datasheet(**at), float(air.split()[0])
            for higher, more in pairs:
                if higher > pressure:
                    one = from_datasheet(**at, air_flow=air)
                    ratio = compare(one.but(at=f"{higher} bar"), one).loc["free air"]
                    names = f"{model} at {higher:g} bar", f"at {pressure:g} bar"
                    add(PRESSURES, names, float(more.split()[0]) / float(air.split()[0]), ratio)
    for (a, (one, p)), (b, (other, q)) in itertools.combinations(powers.items(), 2):
        add(POWERS, (a, b), p / q, compare(one, other).loc["power of the blows"])
    for (a, (one, p)), (b, (other, q)) in itertools.combinations(alone.items(), 2):
        if a[0] != b[0] and abs(a[1] / b[1] - 1.0) < ONE_PRESSURE and a[1] > LOW:
            names = f"{a[0]} at {a[1]:g} bar", b[0]
            add(SIZES, names, p / q, compare(one, other).loc["free air"])
    return pd.DataFrame(found)


def report_of_ratios(found: pd.DataFrame) -> str:
    """Returns a line per kind of ratio, and the ratios outside their ranges."""
    lines = ["## Ratios that makers print, held out of both sheets", ""]
    lines += ["| ratio of | pairs | held | half of the range | off, root of the mean square |"]
    lines += ["|---" * 5 + "|"]
    for kind, rows in found.groupby("kind", sort=False):
        half = np.log(rows["high"] / rows["low"]).median() / 2
        off = np.sqrt((np.log(rows["printed"] / rows["ratio"]) ** 2).mean())
        count, held = len(rows), int(rows["holds"].sum())
        lines.append(f"| {kind} | {count} | {held} ({held / count:.0%}) | {half:.2f} | {off:.2f} |")
    lines += ["", "Half ranges and distances are of logarithms. Missed:", ""]
    lines += ["| ratio of | over | printed | told |", "|---" * 4 + "|"]
    for row in found[~found["holds"].astype(bool)].to_dict("records"):
        sides = f"{row['low']:.3g} to {row['high']:.3g}"
        lines.append(f"| {row['a']} | {row['b']} | {row['printed']:.3g} | {sides} |")
    return "\n".join(lines) + "\n"


def report(found: pd.DataFrame) -> str:
    """Returns the table, under its own heading."""
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
    text = report(table()) + "\n" + report_of_ratios(ratios())
    (REPORTS / "sheets.md").write_text(text, encoding="utf-8")
    print(text, end="")
