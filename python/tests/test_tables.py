"""Tables as written by rigs, loggers and spreadsheets, intact and damaged."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from dth_hammer import DomainError, HammerWarning, calibrate, from_datasheet, simulate
from dth_hammer.scene.signals import of_file
from dth_hammer.study.drilling import FIELDS, suspicions
from dth_hammer.tables import columns_of

#: The same two metres from four rigs, each with its peculiarities, and from a LAS file.
RIGS = {
    "german.csv": "sep=;\nBohrung 12;;\nTiefe;Bohrfortschritt;Luftdruck;Andruckkraft;Schlagzahl\n"
    "[m];[m/h];[bar];[kN];[1/min]\n1.010,5;18,0;24;19,6;1.750\n1.011,5;24,0;22;19,6;1.700\n",
    "american.csv": "# Rig 7\nDEPTH,ROP,AIR PRESSURE,WOB,BPM\nFT,FPH,PSI,LBS,\n"
    '"3,315.29",59.06,348.1,"4,409",1750\n"3,318.57",78.74,319.1,"4,409",1700\n',
    "swedish.tsv": "Borrdjup (m)\tTid\tSjunkning [min/m]\tLufttryck, MPa\tThrust (t)\tBPM\n"
    "1010,5\t10:02\t3,3333\t2,4\t2,0\t1750\n1011,5\t10:06\t2,5\t2,2\t2,0\t1700\n",
    "logger.csv": "LengthTag (m);PenetrRate (m/min);PercPressure (bar);Feed force (daN);blows/min\n"
    "1010.5;0.3;24;1961;1750\n1011.5;0.4;22;1961;1700\nTotal;;;;\n",
    "hole.las": "~Version\n VERS. 2.0:\n WRAP. NO:\n~Well\n NULL. -111:\n~Curve\n DEPT.M:\n"
    " ROP.M/HR:\n PRES.KPA:\n WOB.KLBF:\n BPM.1/MIN:\n~A\n1010.5 18 2400 4.409 1750\n"
    "1011 -111 2400 4.4 1700\n"
    "1011.5 24 2200 4.409 1700\n",
}


@pytest.mark.parametrize("name", RIGS)
def test_a_log_is_read_as_a_person_reads_it(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(RIGS[name], encoding="utf-16" if name == "swedish.tsv" else "utf-8-sig")
    column = {"rop": "Sjunkning [min/m]"} if name == "swedish.tsv" else {}
    numbers, others, grid = columns_of(path, FIELDS, columns=column)
    found = numbers.dropna(subset=["depth", "rop"])
    # Equal to the digits that each rig prints.
    right = {"depth": [1010.5, 1011.5], "rop": [18 / 3600, 24 / 3600], "pressure": [24e5, 22e5]}
    right |= {"feed": [19613.3] * 2, "frequency": [1750 / 60, 1700 / 60]}
    assert {n: found[n].to_numpy() for n in right} == {
        n: pytest.approx(values, rel=7e-4) for n, values in right.items()
    }
    assert list(others) == (["Tid"] if name == "swedish.tsv" else [])
    assert ("'Total'" in str(grid.problems)) == (name == "logger.csv")


@pytest.mark.parametrize("kind", [".csv", ".xlsx", ".parquet"])
def test_every_kind_of_file_has_the_same_numbers(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"log{kind}"
    table = pd.DataFrame({"Depth [m]": [1.5, 2.5], "ROP [m/h]": [18.25, 19.75]})
    table["Rock"] = ["gneiss", "mica"]
    write = {".csv": table.to_csv, ".xlsx": table.to_excel, ".parquet": table.to_parquet}
    write[kind](path, index=False)
    numbers, others, grid = columns_of(path, FIELDS)
    assert numbers.to_numpy() == pytest.approx(np.array([[1.5, 18.25 / 3600], [2.5, 19.75 / 3600]]))
    assert others["Rock"].tolist() == ["gneiss", "mica"]
    assert "'Rock' is not used: not known here" in grid.notes
    path.write_bytes(b"PK\x03\x04 no table at all")
    with pytest.raises(DomainError, match="log"):
        columns_of(path, FIELDS)


@pytest.mark.parametrize(
    ("head", "name", "unit"),
    [
        ("Air pressure [kPa(g)]", "pressure", "kPa(g)"),
        ("ROP (average) [m/h]", "rop", "m/h"),
        ("Depth (MD) [m]", "depth", "m"),
        ("WOB, t", "feed", "t"),
        ("Rate of Penetration ft/hr", "rop", "ft/hr"),
        ("Feed pressure [bar]", "", ""),
        ("Rotation speed [1/min]", "", ""),
    ],
)
def test_a_heading_is_a_word_and_a_unit(head: str, name: str, unit: str) -> None:
    found = {of.name: pair[1] for of in FIELDS if (pair := of.in_heading(head))}
    assert found == ({name: unit} if name else {})


HEADS = "Depth [m];ROP [m/h];Air pressure [bar];Feed [kN];Blows [1/min]"
HOLE = [
    [
        f"{10 + k}.5",
        f"{18 + np.sin(3 * k):.2f}",
        f"{24 + 0.2 * np.cos(k):.2f}",
        f"{19 + k % 3}.5",
        f"{1740 + 7 * (k % 5)}",
    ]
    for k in range(30)
]
Rows = list[list[str]]


def _cell(to: Callable[[str], str]) -> Callable[[np.random.Generator, Rows], str]:
    """Damages one cell below the headings."""

    def damage(random: np.random.Generator, rows: Rows) -> str:
        row = rows[random.integers(1, len(rows))]
        k = random.integers(len(row))
        row[k] = to(row[k])
        return _text(rows)

    return damage


def _row(to: Callable[[Rows, int], object]) -> Callable[[np.random.Generator, Rows], str]:
    def damage(random: np.random.Generator, rows: Rows) -> str:
        to(rows, int(random.integers(1, len(rows))))
        return _text(rows)

    return damage


def _text(rows: Rows) -> str:
    return "\n".join(";".join(row) for row in rows) + "\n"


def _head(old: str, new: str) -> Callable[[np.random.Generator, Rows], str]:
    return lambda _, rows: _text(rows).replace(old, new, 1)


DAMAGES: list[Callable[[np.random.Generator, Rows], str]] = [
    *map(_cell, (lambda c: c.replace(".", "") + "00", lambda c: f"0.0{c.replace('.', '')}")),
    *map(_cell, (lambda c: "-" + c, lambda _: "", lambda _: "-999.25", lambda _: "9999")),
    *map(
        _cell,
        (lambda _: "1e30", lambda _: "broken", lambda c: c.replace(".", ","), lambda _: "---"),
    ),
    *map(
        _cell,
        (lambda c: c.replace("1", "l"), lambda c: f'"{c}"', lambda c: f"  {c} ", lambda c: c + ";"),
    ),
    *map(
        _cell,
        (lambda c: c.replace(".", ".."), lambda c: c + " bar", lambda _: "#N/A", lambda c: c[:1]),
    ),
    *map(
        _row,
        (
            lambda rows, k: rows.insert(k, rows[0]),
            lambda rows, k: rows.insert(k, [""] * 5),
            lambda rows, k: rows.insert(k, rows[k]),
            lambda rows, k: rows.insert(k, ["pause"]),
            lambda rows, k: rows[k].pop(2),
            lambda rows, _: rows.insert(0, ["Hole 12", "", "", "", ""]),
            lambda rows, _: rows.append(["Mean", "18", "24", "20", "1750"]),
        ),
    ),
    *(
        _head(*pair)
        for pair in (("[m/h]", ""), ("[m/h]", "[bar]"), ("[bar]", "[MPa]"), ("[m/h]", "[m/min]"))
    ),
    *(
        _head(*pair)
        for pair in (
            ("ROP", "Rpo"),
            ("Feed [kN]", "ROP [m/h]"),
            ("[kN]", "[N]"),
            ("Blows", "Bolws"),
        )
    ),
    lambda _, rows: _text(rows).replace(";", "\t").replace(".", ","),
    lambda _, rows: _text(rows).replace(";", ","),
    lambda _, rows: _text(rows).replace("\n", "\r\n"),
    lambda _, rows: "sep=;\n" + _text(rows),
    lambda _, rows: _text([row[::-1] for row in rows]),
    lambda random, rows: _text(rows)[: -int(random.integers(2, 60))],
]


def test_every_damage_of_a_log_is_told_or_harmless(tmp_path: Path) -> None:
    sheet = from_datasheet(od="124 mm", pressure="24 bar", hole="140 mm")
    random, path = np.random.default_rng(7), tmp_path / "log.csv"
    path.write_text(_text([HEADS.split(";"), *HOLE]), encoding="utf-8")
    whole, _, clean = columns_of(path, FIELDS)
    assert not clean.problems | suspicions(sheet.parameters, whole)
    silent = []
    for draw in range(4 * len(DAMAGES)):
        damage = DAMAGES[draw % len(DAMAGES)]
        text = damage(random, [HEADS.split(";"), *map(list, HOLE)])
        code = ("utf-8", "utf-8-sig", "utf-16", "cp1252")[draw // len(DAMAGES)]
        path.write_bytes(text.replace("Depth", "Depth", 1).encode(code))
        try:
            numbers, _, grid = columns_of(path, FIELDS)
        except DomainError:
            continue
        if not {"depth", "rop", "pressure"} <= {*numbers}:
            continue
        left = numbers.dropna(subset=["depth", "rop", "pressure"]).drop_duplicates()
        same = left.set_index("depth").reindex(whole["depth"], axis=0)
        right = whole.set_index("depth")
        harmless = len(left) == len(whole) and same.shape == right.shape
        harmless = harmless and np.allclose(same[[*right]], right, rtol=1e-12)
        lost = any(name not in numbers for name in whole) and any(
            "not used" in s for s in grid.notes
        )
        nulls = numbers.isna().any().any() and len(numbers) == len(whole)
        reported = grid.problems or suspicions(sheet.parameters, numbers)
        if not (harmless or reported or lost or nulls):
            silent.append(text)
    assert len(silent) == 0, silent[0]


def test_a_value_that_no_hammer_has_is_left_out_of_a_mean_and_told(tmp_path: Path) -> None:
    rigid, random = {"fidelity": "Rigid"}, np.random.default_rng(3)
    good = [f"{x:.2f} m/h" for x in 11 + 0.3 * random.standard_normal(40)]
    for slip, word in (
        ("999 m/h", "no hammer has"),
        ("112 m/h", "far from all other rop and left"),
    ):
        with pytest.warns(HammerWarning, match=f"{word}.*value 41 of 41 = {slip}"):
            found = calibrate(rigid, {"rop": [*good, slip]}, ["rock.specific_energy"])
        own = np.mean([float(text.split()[0]) for text in good]) / 3600
        assert found.residuals.loc["rop", "measured"] == pytest.approx(own, rel=1e-12)
    # Values from two motions are not outliers.
    with pytest.warns(HammerWarning, match="is it another motion"):
        found = calibrate(rigid, {"rop": [*good, *["99 m/h"] * 15]}, ["rock.specific_energy"])
    assert found.residuals.loc["rop", "measured"] > 20 / 3600
    path = tmp_path / "log.csv"
    path.write_text(
        "\n".join(["Depth [m],ROP [m/h]", *(f"{k},{t[:-4]}" for k, t in enumerate(good))])
    )
    with pytest.warns(HammerWarning, match="'ROP .m/h.' is rop in m/h"):
        found = calibrate(rigid, path, ["rock.specific_energy"])
    assert found.residuals.loc["rop", "measured"] == pytest.approx(own, rel=1e-12)


def test_inputs_over_time_are_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "feed.csv"
    path.write_text("Time [ms];Feed force [kN]\n0;4,5\n100;8\n", encoding="utf-8")
    inputs = of_file(path)
    depths = [
        simulate(until=0.1, step=0.05, inputs=given, outputs=["feed_force", "tip_depth"]).frame
        for given in (inputs, {"feed_force": pd.Series([4500.0, 8000.0], index=[0.0, 0.1])})
    ]
    assert depths[0].equals(depths[1])
