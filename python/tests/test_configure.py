"""One file is one hammer: the FMU starts with the scene in any host."""

from collections.abc import Callable
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import fmpy
import numpy as np
import pytest
from dth_hammer import VARIABLES, DomainError, DthHammerError, simulate
from dth_hammer.errors import FmuNotFoundError
from dth_hammer.fmu import configure, find, load
from fmpy.validation import validate_fmu

SCENE = {
    "drive.source": "Pressure",
    "rock.stiffness": "3e8 N/m",
    "bit.elements": 9,
    "drive_pressure": "12 bar",
    "return_pressure": 2e5,
}
NAMES = ["piston_position", "tip_depth", "rock_impulse"]
END, STEP = 0.03, 1e-3


def outputs(fmu: Path) -> list[float]:
    """Returns the results in a host that sets nothing."""
    message = fmpy.simulate_fmu(
        str(fmu), stop_time=END, step_size=STEP, output_interval=STEP, output=NAMES
    )
    return [value for name in NAMES for value in message[name]]


def expected(**more: float) -> list[float]:
    frame = simulate(SCENE | more, END, step=STEP, outputs=NAMES)
    return [value for name in NAMES for value in frame[name]]


def test_a_host_that_sets_nothing_simulates_the_scene(tmp_path: Path) -> None:
    file = tmp_path / "my.fmu"
    assert configure(SCENE, file) == 0
    assert validate_fmu(str(file)) == []
    assert outputs(file) == pytest.approx(expected(), rel=1e-9)
    nodes = load(file).description.iterfind("ModelVariables/ScalarVariable")
    starts = {node.attrib["name"]: float(node[0].get("start", "nan")) for node in nodes}
    assert starts["drive.source"] == 3
    assert starts["drive_pressure"] == 1.2e6
    assert starts["rock.stiffness"] == 3e8
    with ZipFile(file) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "drive.source = Pressure" in page


def test_the_fmu_in_a_host_gives_the_numbers_of_the_native_module_to_the_last_bit() -> None:
    # Steps of 2^-9 s have exact sums, so both advance to exactly the same instants.
    size, end = 2.0**-9, 0.25
    scene = {"feed_force": 6e3, "rock.stiffness": 2e8, "bit.elements": 7}
    names = [variable.name for variable in VARIABLES.of("output")]
    run = simulate(scene, end, step=size, outputs=names)
    message = fmpy.simulate_fmu(
        str(find()),
        start_values=scene,
        stop_time=end,
        step_size=size,
        output_interval=size,
        output=names,
    )
    assert (message["time"] == run.time).all()
    for name in message.dtype.names[1:]:
        np.testing.assert_array_equal(message[name], run[name].to_numpy(float), err_msg=name)


def test_a_configured_fmu_can_be_configured_further(tmp_path: Path) -> None:
    one, two = tmp_path / "one.fmu", tmp_path / "two.fmu"
    configure(SCENE, one)
    configure({"feed_force": 7e3}, two, fmu=one)
    assert outputs(two) == pytest.approx(expected(feed_force=7e3), rel=1e-9)
    with pytest.raises(DthHammerError, match="would overwrite"):
        configure({}, two, fmu=two)


def test_a_wrong_scene_writes_nothing(tmp_path: Path) -> None:
    file = tmp_path / "my.fmu"
    with pytest.raises(DomainError, match=r"rock\.stiffness"):
        configure({"rock.stiffness": -1.0}, file)
    assert not list(tmp_path.iterdir())


def test_the_command(tmp_path: Path, cli: Callable[..., str]) -> None:
    file = tmp_path / "my.fmu"
    words = [f"--set={name}={value}" for name, value in SCENE.items()]
    assert "5 start values" in cli("configure", "-o", file, *words)
    assert outputs(file) == pytest.approx(expected(), rel=1e-9)


EVENTS = {"event.positions": 2, "event.position[1]": "-30 mm", "event.blow": "false"}


def test_an_fmu_of_fmi_3_starts_with_its_events_too(tmp_path: Path) -> None:
    file = tmp_path / "my.fmu"
    configure(SCENE | EVENTS | {"waves.stations": 7}, file, fmi=3, arrays=True)
    assert validate_fmu(str(file)) == []
    assert outputs(file) == pytest.approx(expected(), rel=1e-9)
    starts = {v.name: v.start for v in fmpy.read_model_description(file).modelVariables}
    assert float(starts["event.position[1]"]) == -0.03
    assert [starts[n] for n in ("event.positions", "event.blow", "waves.stations")] == [
        "2",
        "false",
        "7",
    ]
    # Results of the plain FMU would be wrong for this one, so they are left out.
    with ZipFile(file) as archive:
        assert not [name for name in archive.namelist() if name.startswith("extra/")]


def test_the_library_has_the_events_that_an_fmu_of_fmi_3_starts_with(tmp_path: Path) -> None:
    file = tmp_path / "my.fmu"
    configure({"event.positions": 1, "event.position[1]": -0.03, "event.blow": 0}, file, fmi=3)
    result = fmpy.simulate_fmu(
        str(file),
        stop_time=0.1,
        step_size=0.05,
        output_interval=0.05,
        output=["relative_position"],
        use_event_mode=True,
        early_return_allowed=True,
    )
    at = [x for t, x in zip(result["time"], result["relative_position"], strict=True) if t % 0.05]
    assert len(at) > 2
    # 10 m/s times some units of the last place of the time.
    assert np.abs(np.array(at) + 0.03).max() < 1e-14


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"event.positions": 9}, r"event\.positions = 9 is not within 0 and 8"),
        ({"waves.stations": 0}, r"waves\.stations = 0 is not within 1 and"),
        ({"event.position[1]": "3 s"}, r"event\.position\[1\]"),
        ({"event.blow": "perhaps"}, r"event\.blow"),
    ],
)
def test_events_out_of_their_range_are_refused(
    tmp_path: Path, given: dict[str, int | str], message: str
) -> None:
    with pytest.raises(DthHammerError, match=message):
        configure(given, tmp_path / "my.fmu", fmi=3, arrays=True)
    with pytest.raises(DthHammerError, match="no parameter or input"):
        configure(given, tmp_path / "my.fmu")
    assert not list(tmp_path.iterdir())


def test_arrays_are_in_a_variant_of_fmi_3_alone(tmp_path: Path, cli: Callable[..., str]) -> None:
    file, two = tmp_path / "arrays.fmu", tmp_path / "two.fmu"
    said = cli("configure", "-o", file, "--fmi", "3", "--arrays", "--set=feed_force=6e3")
    assert "1 start values, 14 more outputs" in said
    assert validate_fmu(str(file)) == []
    plain, found = (
        {v.name: v for v in fmpy.read_model_description(path).modelVariables}
        for path in (find(fmi=3), file)
    )
    assert not [v.name for v in plain.values() if v.dimensions]
    arrays = [v.name for v in found.values() if v.dimensions]
    assert "piston_stress" in arrays
    assert "step_blow_time" in arrays
    configure({"waves.stations": 7}, two, fmu=file)
    stress = fmpy.simulate_fmu(str(two), stop_time=0.05, output=["piston_stress"])["piston_stress"]
    assert stress.shape[1] == 7
    assert np.abs(stress).max() > 1e6
    again = ["configure", "--arrays", "-o", tmp_path / "out.fmu"]
    assert "has arrays already" in cli(*again, "--fmi", "3", "--fmu", file, code=2)
    assert "they are of FMI 3.0" in cli(*again, code=2)


BIG = 300_000_000


def bomb(path: Path) -> None:
    """Writes an archive of zeros, which unpack to a thousand times the file's size."""
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        archive.write(find(), "whole.fmu")
        with archive.open("resources/zeros", "w") as entry:
            for _ in range(BIG // 1_000_000):
                entry.write(bytes(1_000_000))


@pytest.mark.parametrize(
    ("entries", "why"),
    [
        (None, r"it would unpack to 30\d MB, more than 100 MB"),
        ([f"resources/{k}" for k in range(1001)], "it has 1001 entries, more than 1000"),
        (["../evil"], r"it would unpack '\.\./evil' outside its folder"),
        (["a/../../evil"], "outside its folder"),
        (["/etc/evil"], "outside its folder"),
        (["C:evil"], "outside its folder"),
        (["a\\..\\..\\evil"], "outside its folder"),
        (["modelDescription.xml"] * 2, "it has two entries of one name"),
    ],
)
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_an_archive_that_would_hurt_is_refused_by_its_directory_alone(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    cli: Callable[..., str],
    entries: list[str] | None,
    why: str,
) -> None:
    file = tmp_path / "evil.fmu"
    if entries is None:
        bomb(file)
    else:
        with ZipFile(file, "w") as archive:
            for name in entries:
                archive.writestr(name, b"")
    assert file.stat().st_size < BIG / 100

    def unpacked(*_: object, **__: object) -> None:
        raise AssertionError("something was unpacked")

    for method in ("open", "read", "extract", "extractall"):
        monkeypatch.setattr(ZipFile, method, unpacked)
    with pytest.raises(FmuNotFoundError, match=why):
        load(file)
    said = cli("configure", "--fmu", file, "-o", tmp_path / "out.fmu", code=2)
    assert "evil.fmu cannot be read as an FMU" in said
