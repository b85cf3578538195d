"""Files from outside with any damage are read, or refused in one line by name."""

from __future__ import annotations

import io
import json
import random
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import dth_hammer
import pandas as pd
import pytest
from dth_hammer import VARIABLES, Hammer, Scene, Snapshot, fmu, sweep, tables
from dth_hammer.errors import DthHammerError
from dth_hammer.fmu import system
from dth_hammer.scene import rocks
from dth_hammer.study.drilling import FIELDS
from dth_hammer.study.store import Store, filled
from dth_hammer.tables import columns_of

#: Number of random damages to each kind of file.
DAMAGES = 200


def damaged(content: bytes, draw: random.Random) -> bytes:
    """Returns the content with a run of bytes changed, doubled, left out, or cut off."""
    at = draw.randrange(len(content))
    length = min(len(content) - at, 1 + int(draw.expovariate(0.02)))
    run = content[at : at + length]
    kinds: list[Callable[[], bytes]] = [
        lambda: content[:at] + draw.randbytes(length) + content[at + length :],
        lambda: content[:at] + run + content[at:],
        lambda: content[:at] + content[at + length :],
        lambda: content[:at],
        lambda: content[:at] + bytes([run[0] ^ (1 << draw.randrange(8))]) + content[at + 1 :],
    ]
    return draw.choice(kinds)()


def is_refused_by_name(read: Callable[[Path], object], path: Path) -> bool:
    """Returns whether a file is refused; an error from outside this package ends the test."""
    try:
        read(path)
    except DthHammerError as error:
        said = str(error)
        assert "\n" not in said, said
        return True
    return False


@pytest.fixture(scope="module")
def archive() -> dict[str, bytes]:
    """Returns the files in the packaged unit."""
    with zipfile.ZipFile(fmu.find()) as unit:
        return {name: unit.read(name) for name in unit.namelist()}


def packed(entries: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return file.getvalue()


SCENE = {
    "description": "Granite, with a feed that rises",
    "preset": "air_4_inch",
    "rock": "granite",
    "start_values": {"feed_force": "6 kN", "piston.length": 0.18},
    "inputs": {"feed_force": {"0 s": "4 kN", "1 s": "8 kN"}},
    "until": "1 s",
}
LOG = "Depth [m];ROP [m/h];Air pressure [bar];Rock\n" + "".join(
    f"{k};18,5;{20 + k % 5};gneiss\n" for k in range(30)
)
ROWS = "feed_force [kN],rock.stiffness\n4,1e8\n5,2e8\n"


def read_partner(path: Path) -> object:
    """Reads a partner of a system; an undamaged one shares no name with the hammer."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(system, "configure", None)  # Nothing is made of one that is read.
        return fmu.write_system({}, path.with_suffix(".ssp"), {"drive": path})


def read_rows(path: Path) -> object:
    """Checks that rows of wanted runs in the file are those that were written."""
    found = Store(path).whole(STORED["wanted"]) if path.stat().st_size else pd.DataFrame()
    for row in found.to_dict("records"):
        if row["run"] in STORED["wanted"]:
            assert filled(row) == STORED["rows"][row["run"]]
    return found


#: Rows with which `read_rows` compares.
STORED: dict[str, Any] = {}


@pytest.fixture(scope="module")
def whole(archive: dict[str, bytes], tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Returns an undamaged file of each kind."""
    folder = tmp_path_factory.mktemp("whole")
    # The library is left out, so that most damages hit the directory or the description.
    small = {name: content for name, content in archive.items() if len(content) < 200_000}
    description = small["modelDescription.xml"].replace(b' name="', b' name="own_')
    rock = folder / "rock.json"
    rocks.write(rock, Scene(rock="granite").numbers)
    frame = pd.read_csv(io.StringIO(LOG.replace(",", ".")), sep=";")
    frame.to_excel(folder / "log.xlsx", index=False)
    frame.to_parquet(folder / "log.parquet", index=False)
    las = "~Version\n VERS. 2.0:\n WRAP. NO:\n~Curve\n DEPT.M:\n ROP.M/HR:\n~A\n"
    las += "".join(f"{k} 18.5\n" for k in range(30))
    for kind in (".csv", ".parquet"):
        out = folder / f"sweep{kind}"
        sweep({"fidelity": ["Rigid"], "feed_force": [4e3, 5e3]}, "20 ms", out=out)
    rows = Store(out).rows()
    STORED["wanted"] = {run: ["rop", "checksum"] for run in rows["run"]}
    STORED["rows"] = {row["run"]: filled(row) for row in rows.to_dict("records")}
    with Hammer() as hammer:
        hammer.advance(0.02)
        state = hammer.save().to_bytes()
    written = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    return written | {
        "unit.fmu": packed(small),
        "partner.fmu": packed(small | {"modelDescription.xml": description}),
        "scene.json": json.dumps(SCENE, indent=1).encode(),
        "log.csv": LOG.encode(),
        "log.las": las.encode(),
        "rows.csv": ROWS.encode(),
        "state.bin": state,
    }


def read_log(path: Path) -> object:
    return columns_of(path, FIELDS)


#: A reader for each kind of file, and the percentage of damages that it must notice. It cannot
#: notice damage to an archive's other files, words or blanks.
READERS: dict[str, tuple[Callable[[Path], object], int]] = {
    "unit.fmu": (fmu.load, 10),
    "partner.fmu": (read_partner, 100),
    "scene.json": (lambda path: Scene.read(path).numbers, 50),
    "rock.json": (lambda path: dth_hammer.rock(str(path)), 50),
    "log.csv": (read_log, 0),
    "log.las": (read_log, 0),
    "log.xlsx": (read_log, 10),
    "log.parquet": (read_log, 10),
    "rows.csv": (lambda path: tables.rows_of(path, VARIABLES), 0),
    "sweep.csv": (read_rows, 10),
    "sweep.parquet": (read_rows, 10),
    "state.bin": (lambda path: Snapshot.from_bytes(path.read_bytes()), 99),
}


@pytest.mark.parametrize("kind", READERS)
@pytest.mark.filterwarnings("ignore")
def test_drawn_damages(kind: str, whole: dict[str, bytes], tmp_path: Path) -> None:
    (read, least), draw, refused = READERS[kind], random.Random(kind), 0
    for number in range(DAMAGES):
        # Readers cache files by name, time and size.
        path = tmp_path / f"{number}{Path(kind).suffix}"
        path.write_bytes(damaged(whole[kind], draw))
        refused += is_refused_by_name(read, path)
    assert refused >= DAMAGES * least / 100, refused


ALTERED = {
    "no name": lambda text: text.replace(' modelName="', ' model="', 1),
    "no identity": lambda text: text.replace(' guid="', ' id="', 1),
    "no version": lambda text: text.replace(' fmiVersion="', ' fmi="', 1),
    "an encoding that is none": lambda text: text.replace("UTF-8", "klingon", 1),
    "another encoding": lambda text: text.replace("UTF-8", "UTF-16", 1),
    "no text": lambda _: "",
    "no XML": lambda _: "\0" * 100,
    "deep": lambda _: "<a>" * 200_000 + "</a>" * 200_000,
}


@pytest.mark.parametrize("kind", ALTERED)
def test_altered_descriptions(kind: str, archive: dict[str, bytes], tmp_path: Path) -> None:
    text = ALTERED[kind](archive["modelDescription.xml"].decode())
    path = tmp_path / "altered.fmu"
    path.write_bytes(packed(archive | {"modelDescription.xml": text.encode()}))
    # A unit without `fmiVersion` is read as one of FMI 2.0.
    assert is_refused_by_name(fmu.load, path) or kind == "no version"


SCENES = {
    "nested deep": "[" * 100_000,
    "nested objects": '{"start_values":' * 5000 + "1" + "}" * 5000,
    "a long integer": '{"start_values": {"rock.stiffness": ' + "1" * 5000 + "}}",
    "not a number": '{"start_values": {"rock.stiffness": NaN}}',
    "a list of rocks": '{"rock": ["granite"]}',
    "a rock of rocks": '{"rock": {"rock": {}}}',
    "a preset that is an object": '{"preset": {"a": 1}}',
    "a time that is an object": '{"until": {"a": 1}}',
    "no object": "5",
    "nothing": "",
    "a byte that is none": "\udcff",
}


@pytest.mark.parametrize("kind", SCENES)
def test_scenes_that_are_none(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text(SCENES[kind], encoding="utf-8", errors="surrogateescape")
    with pytest.raises(DthHammerError, match=r"^[^\n]*$"):
        Scene.read(path).numbers  # noqa: B018


def test_numbers_of_a_rock_in_a_scene_are_told_where_they_belong(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text('{"rock": {"hardness": "1.6 GPa"}}', encoding="utf-8")
    with pytest.raises(DthHammerError, match="write its numbers into a file of their own"):
        Scene.read(path)
