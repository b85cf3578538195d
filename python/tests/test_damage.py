"""Files from outside that are damaged in any way: read, or refused in one line by name."""

from __future__ import annotations

import io
import json
import random
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from dth_hammer import PRESETS, Scene, fmu
from dth_hammer.errors import DthHammerError

#: Drawn damages of each kind of file.
DAMAGES = 200


def damaged(content: bytes, draw: random.Random) -> bytes:
    """The content with a run of bytes changed, doubled, left out, or cut off."""
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
    """Whether a file is refused; any other error than this package's own ends the test."""
    try:
        read(path)
    except DthHammerError as error:
        said = str(error)
        assert "\n" not in said, said
        return True
    return False


@pytest.fixture(scope="module")
def archive() -> dict[str, bytes]:
    """What is in the packaged unit."""
    with zipfile.ZipFile(fmu.find()) as unit:
        return {name: unit.read(name) for name in unit.namelist()}


def packed(entries: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return file.getvalue()


def test_drawn_damages_of_an_archive(archive: dict[str, bytes], tmp_path: Path) -> None:
    # Without the library, so that most damages meet the directory or the description.
    small = {name: content for name, content in archive.items() if len(content) < 200_000}
    whole, draw, refused = packed(small), random.Random(1), 0
    for number in range(DAMAGES):
        path = tmp_path / f"{number}.fmu"
        path.write_bytes(damaged(whole, draw))
        refused += is_refused_by_name(fmu.load, path)
    # Where the damage meets another file of the archive, the description is whole.
    assert refused > DAMAGES / 10


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


def test_drawn_damages_of_a_scene(tmp_path: Path) -> None:
    scene = {
        "description": "Granite, with a feed that rises",
        "preset": "air_4_inch",
        "rock": "granite",
        "start_values": {"feed_force": "6 kN", "piston.length": 0.18},
        "inputs": {"feed_force": {"0 s": "4 kN", "1 s": "8 kN"}},
        "until": "1 s",
    }
    assert scene["preset"] in PRESETS
    whole, draw = json.dumps(scene, indent=1).encode(), random.Random(2)
    path = tmp_path / "scene.json"
    for _ in range(DAMAGES):
        path.write_bytes(damaged(whole, draw))
        is_refused_by_name(lambda path: Scene.read(path).numbers, path)


def test_numbers_of_a_rock_in_a_scene_are_told_where_they_belong(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text('{"rock": {"hardness": "1.6 GPa"}}', encoding="utf-8")
    with pytest.raises(DthHammerError, match="write its numbers into a file of their own"):
        Scene.read(path)
