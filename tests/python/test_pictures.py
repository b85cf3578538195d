"""Every committed picture was drawn by the present code from its scene."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pictures
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
FOLDERS = ("reports", "guide/measured")


def test_every_committed_picture_is_listed() -> None:
    found = {f"{d}/{f.name}" for d in FOLDERS for f in (ROOT / d).glob("*.png")}
    assert found == {*pictures.PICTURES}


@pytest.mark.parametrize("name", [*pictures.PICTURES])
def test_a_picture_has_its_scene_and_is_not_stale(name: str) -> None:
    with Image.open(ROOT / name) as picture:
        assert json.loads(picture.info["scene"]) == pictures.scene(name)
    assert not pictures.stale(name), f"draw it anew: python guide/pictures.py {name}"


def test_other_code_or_another_scene_is_another_hash(monkeypatch: pytest.MonkeyPatch) -> None:
    name = "reports/waves.png"
    before = pictures.hash_of(name)
    source = pictures._source
    monkeypatch.setattr(pictures, "_source", lambda place: source(place) + "\nmore = 1")
    assert pictures.hash_of(name) != before
    monkeypatch.setattr(pictures, "_source", source)
    own = pictures.scene(name)
    own["reference"]["rock.stiffness"] *= 1.01
    monkeypatch.setattr(pictures, "scene", lambda _: own)
    assert pictures.hash_of(name) != before


# Screenshots depend on the machine's fonts; pictures of speeds use committed numbers.
REDRAWN = [name for name, each in pictures.PICTURES.items() if each.drawn != "laboratory"]


@pytest.mark.weekly
@pytest.mark.parametrize("name", REDRAWN)
def test_a_picture_drawn_anew_is_the_same_to_the_eye(name: str, tmp_path: Path) -> None:
    drawn = [
        np.asarray(Image.open(path).convert("L"), float)
        for path in (ROOT / name, pictures.redraw(name, tmp_path))
    ]
    assert drawn[0].shape == drawn[1].shape
    # Results agree to 1e-6, so lines do not move by a pixel, and only their soft edges differ.
    assert (np.abs(drawn[0] - drawn[1]) > 64).mean() < 1e-3
