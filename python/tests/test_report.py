"""The report on a scene: one page with everything in it."""

import base64
import io
import json
import re
import zipfile
from pathlib import Path
from typing import Any

import matplotlib.image as mpimg
import numpy as np
import pytest
from dth_hammer import (
    PRESETS,
    VARIABLES,
    DomainError,
    HammerWarning,
    Scene,
    UnknownNameError,
    report,
    simulate,
    steady,
)
from dth_hammer.cli import main
from dth_hammer.fmu import find
from dth_hammer.scene.variables import model
from lxml import html

GIVEN = {"feed_force": "6 kN", "piston.length": 0.18}
SCENE: dict[str, Any] = {
    "description": "Granite <hard>, with a feed of 6 kN",
    "rock": "granite",
    "start_values": GIVEN,
    "until": "300 ms",
}


def write(folder: Path, content: Any) -> Path:
    path = folder / "my scene.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Any:
    scene = write(tmp_path_factory.mktemp("report"), SCENE)
    assert main(["report", str(scene)]) == 0
    return html.fromstring(scene.with_suffix(".html").read_text(encoding="utf-8"))


def test_it_needs_nothing_from_elsewhere(page: Any) -> None:
    sources = [image.get("src") for image in page.iter("img")]
    assert len(sources) == 7
    for source in sources:
        picture = io.BytesIO(base64.b64decode(source.removeprefix("data:image/png;base64,")))
        assert min(mpimg.imread(picture).shape[:2]) > 300
    assert not [*page.iter("script"), *page.iter("link")]
    assert all(image.get("alt") for image in page.iter("img"))


def test_it_says_what_the_run_gives(page: Any) -> None:
    run = simulate(SCENE["start_values"], "300 ms", rock="granite")
    last = run.frame.iloc[-1]
    rows = {cells[0]: cells[1:] for row in page.iter("tr") if (cells := texts(row))}
    assert rows["rop"][:2] == [f"{3600 * last['rop']:.4g}", "m/h"]
    assert rows["blow_energy"][:2] == [f"{last['blow_energy']:.4g}", "J"]
    assert rows["feed_force"][:2] == ["6000 N", ""]
    assert rows["drive.amplitude"][1] == "default"
    assert rows["drive.source"][0] == "Relay"
    # The rate comes first.
    assert [*rows].index("rate of penetration") < [*rows].index("blow energy")
    # One row per blow.
    assert str(int(last["blow_count"])) in rows
    assert model() in page.text_content()


def texts(row: Any) -> list[str]:
    return [cell.text_content() for cell in row.iter("td")]


def test_what_a_user_wrote_is_text_and_no_markup(page: Any) -> None:
    assert "Granite <hard>, with" in page.text_content()
    assert page.find(".//title").text == "my scene"


def test_inputs_over_time_act_and_what_is_doubtful_is_there(tmp_path: Path) -> None:
    inputs = {"feed_force": {"0 s": "4 kN", "100 ms": "8 kN"}, "drive_force": 1e3}
    scene = write(tmp_path, {"inputs": inputs, "until": 0.1})
    with pytest.warns(HammerWarning, match="drive_force is ignored"):
        out = report(scene, tmp_path / "page.html", units=["us", {"rop": "mm/s"}])
    text = out.read_text(encoding="utf-8")
    assert "drive_force is ignored" in text
    # A system of units, and one unit chosen for an output.
    assert re.search(r"<td>rop</td><td class=\"number\">[\d.]+</td><td>mm/s</td>", text)
    assert "rop (mm/s)" in text
    assert "blow_energy (ft.lbf)" in text
    # Two blows are too few to converge, which stands in place of the figure.
    assert "Not drawn: 2 blows" in text


def test_a_scene_of_the_laboratory_and_a_preset_are_scenes(tmp_path: Path) -> None:
    with zipfile.ZipFile(find()) as archive:
        files = [name for name in archive.namelist() if name.startswith("resources/")]
        archive.extractall(tmp_path, files)
    scenes = [tmp_path / name for name in files if name.endswith(".json")]
    assert {p.stem for p in scenes} >= {*PRESETS}
    for path in scenes:
        if "start_values" in path.read_text(encoding="utf-8"):
            assert Scene.read(path).parameters == PRESETS[path.stem].values
    laboratory = write(tmp_path, {"description": "x", "start_values": {"rock.stiffness": 2e8}})
    assert Scene.read(laboratory).parameters == {"rock.stiffness": 2e8}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], "must be an object"),
        ({"values": {}}, "there is description, preset, rock, start_values"),
        ({"start_values": []}, "start_values of my scene.json must be an object"),
        ({"inputs": {"feed_force": []}}, "the input feed_force must be a value"),
        ({"inputs": {"feed_force": {}}}, "the input feed_force has no instant"),
    ],
)
def test_a_wrong_scene_is_refused_in_words(tmp_path: Path, content: Any, message: str) -> None:
    with pytest.raises((DomainError, UnknownNameError), match=message):
        Scene.read(write(tmp_path, content))


def test_a_trend_is_the_slope_between_responses_on_both_sides(tmp_path: Path) -> None:
    values: dict[str, Any] = {**GIVEN, "fidelity": "Rigid"}
    scene = write(tmp_path, SCENE | {"start_values": values, "until": 0.2})
    by = ["feed_force", "drive.amplitude"]
    assert main(["report", str(scene), "--gradient", ", ".join(by)]) == 0
    page = html.fromstring(scene.with_suffix(".html").read_text(encoding="utf-8"))
    table = next(t for t in page.iter("table") if "long-run" in t.text_content())
    trends = {cells[0]: cells[1:] for row in table.iter("tr") if (cells := texts(row))}
    # A trend: the long-run responses 5 % to both sides. There the fit is a straight line to second
    # order, (0.05)^2, and its error.
    told, error = (float(x) for x in trends["rop"][2].split(" ± "))
    force = VARIABLES["drive.amplitude"].start
    ends = [
        steady(values | {"drive.amplitude": f * force}, rock="granite")["rop"]
        for f in (1.0 / 1.05, 1.05)
    ]
    slope = np.log(ends[1] / ends[0]) / (2.0 * np.log(1.05))
    assert told == pytest.approx(slope, abs=3.0 * error + 0.0025 * abs(slope) + 5e-4)


def test_elasticities_that_there_are_not_are_named(tmp_path: Path) -> None:
    forced = {"start_values": {"drive.source": "Force", "drive_force": 500}, "until": 0.02}
    out = report(Scene.read(write(tmp_path, forced)), tmp_path / "a.html", gradient=["gravity"])
    text = out.read_text(encoding="utf-8")
    assert "Not computed" in text
    assert "drive.source" in text
    # Parameters of the air are not shown for another drive.
    assert "air.return.exhaust" not in text
    with pytest.raises(UnknownNameError, match="did you mean 'gravity'"):
        report(Scene.read(write(tmp_path, {})), tmp_path / "b.html", gradient=["gravty"])
    assert not (tmp_path / "b.html").exists()
