"""Every public function raises only errors of this package on wrong arguments."""

import inspect
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import dth_hammer as dth
import numpy as np
import pandas as pd
import pytest
from dth_hammer.errors import DthHammerError
from dth_hammer.study import longrun

RIGID = {"fidelity": "Rigid"}
#: Values that no argument, or not every argument, may have. None is missing, since it means an
#: argument that is not given.
WRONG: tuple[Any, ...] = (
    object(),
    "nonsense",
    "",
    b"bytes",
    -1,
    0,
    np.nan,
    np.inf,
    1j,
    [],
    [1, "two"],
    ["nonsense"],
    {"nonsense": 1.0},
    {1: 2},
    {"rock.stiffness": "soft"},
    {"rock.stiffness": None},
    {"rock.stiffness": (1.0, 2.0, 3.0)},
    {"rop": 0.01},
    {"rop": "fast"},
    np.zeros((2, 2)),
    pd.Series([1.0, "x"]),
    pd.DataFrame({"nonsense": [1.0]}),
    lambda *_: "nonsense",
    Path("/nowhere/at/all"),
)


class Model:
    """A drive without force."""

    def advance(self, step: float, motion: object) -> None: ...

    def outputs(self) -> dict[str, float]:
        return {}

    def save(self) -> None: ...

    def restore(self, state: object) -> None: ...


def functions(folder: Path) -> dict[Callable[..., Any], dict[str, Any]]:
    """Returns every public function and class that users call, with valid and quick arguments."""
    samples = pd.Series([0.0, 0.1], [0.0, 1e-3])
    hammer = dth.Hammer(RIGID)
    scene = dth.Scene(parameters=RIGID, until=0.05)
    sheet = dth.from_datasheet(piston_mass=3.4, blow_energy=220, frequency=20)
    curve = dth.SNCurve("300 MPa", 1e7, 8)
    log = pd.DataFrame({"depth": [1.0], "rop": [5e-3], "pressure": ["20 bar"]})
    return {
        dth.Hammer: {"hammer": RIGID},
        dth.Scene: {"title": "a", "parameters": RIGID},
        dth.Record: {"signal": "rock_force", "samples": samples, "error": 0.1},
        dth.SNCurve: {"strength": "300 MPa", "cycles": 1e7, "slope": 8},
        dth.Coupling: {"hammer": hammer, "partner": Model(), "step": 1e-3},
        dth.simulate: {"hammer": RIGID, "until": 0.01},
        dth.steady: {"hammer": RIGID, "limit": 0.1},
        dth.sweep: {"hammers": {"feed_force": [4e3]}, "until": 0.01, "base": RIGID},
        dth.trend: {"hammer": RIGID, "widths": {"feed_force": 0.05}, "outputs": ["rop"]},
        dth.calibrate: {
            "hammer": RIGID,
            "measured": {"tip_rate": (0.03, 0.001)},
            "free": {"feed_force": (4e3, 6e3)},
        },
        dth.optimise: {"hammer": RIGID, "goal": "rop", "free": {"feed_force": (4e3, 6e3)}},
        dth.waves: {"until": 2e-3},
        dth.life: {"hammer": RIGID, "curve": curve},
        dth.mesh_for: {"error": 0.05},
        dth.rock: {"name": "kuru granite", "inserts": 8, "insert_radius": "6 mm"},
        # Refused after all checks: too little is known, or a rigid body has no stress.
        dth.from_datasheet: {},
        dth.compare: {"a": sheet, "b": sheet},
        dth.specific_energy: {"sheet": sheet, "log": log},
        dth.report: {"hammer": scene, "out": folder / "page.html"},
    }


#: Not called: types of answers, errors, and tables.
ANSWERS = {
    "Datasheet", "Motion", "Partner", "Run", "Snapshot", "Steady", "DomainError", "DthHammerError",
    "Calibration", "Life", "Mesh", "Optimum", "Rock", "Trend", "Waves",
    "HammerWarning", "RefusedError", "UnknownNameError", "PRESETS", "ROCKS", "VARIABLES", "fmu",
}  # fmt: skip


#: Functions that start another program or show a progress bar.
OTHERS = {"progress"}


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes all hammers respond alike, and draws nothing: only arguments are tested."""
    answer = dth.steady(RIGID)

    def finished(points: Sequence[object], *_: object, **__: object) -> Iterator[Any]:
        return ((k, answer) for k in range(len(points)))

    monkeypatch.setattr(longrun, "finished", finished)
    monkeypatch.setattr("dth_hammer.simulation.answers.image", lambda *_: "")


def test_every_public_name_is_tried_or_an_answer(tmp_path: Path) -> None:
    tried = {function.__name__ for function in functions(tmp_path)}
    assert tried | ANSWERS == set(dth.__all__)
    assert not tried & ANSWERS


@pytest.mark.usefixtures("quick")
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", sorted({*dth.__all__} - ANSWERS))
def test_wrong_arguments_are_told(name: str, tmp_path: Path) -> None:
    function, right = next((f, r) for f, r in functions(tmp_path).items() if f.__name__ == name)
    longest = max(inspect.signature(function).parameters, key=len)
    misspelt = right | {f"{longest[:-1]}x{longest[-1]}": 1}
    with pytest.raises(dth.UnknownNameError, match=f"no argument of {name} is called"):
        function(**misspelt)
    with pytest.raises(dth.DomainError, match=name):
        function(*[1] * 40)
    refused = 0
    for argument in {*inspect.signature(function).parameters} - OTHERS:
        for value in WRONG:
            try:
                function(**{**right, argument: value})
            except DthHammerError:
                refused += 1
            except Exception as error:
                raise AssertionError(f"{name}({argument}={value!r})") from error
    # Most values are wrong for an argument, but not all.
    assert refused > len(WRONG) // 2


def wrong() -> Iterator[tuple[Callable[[], object], str]]:
    """Yields mistakes that people have made, with the helpful part of the message."""
    yield lambda: dth.steady([{"feed_force": 1.0}], starts=2), "call steady for each"  # type: ignore[call-overload]
    yield lambda: dth.calibrate({}, {"rop": 0.034}, ["feed_force"]), "give .value, standard error"
    yield lambda: dth.calibrate({}, {"rop": (1.0, 0.1)}, "feed_force"), "free = 'feed_force' is not"
    yield lambda: dth.trend(None, {"feed_force": "5 %"}), r"widths\['feed_force'\] = '5 %' is not a"  # type: ignore[dict-item]
    yield lambda: dth.optimise({}, ["rop"], {}), "goal = .'rop'. is not text or a function"  # type: ignore[arg-type]
    yield lambda: dth.mesh_for(error={}), "error = {} is not a number"  # type: ignore[arg-type]
    yield lambda: dth.simulate("granite"), "'granite' is a rock: give rock='granite' beside"
    yield lambda: dth.simulate("feed"), "'feed' is set, it is no hammer: .* {'feed_force': ...}"
    yield lambda: dth.steady("piston"), "by name, {'piston.length': ...}"
    yield lambda: dth.steady(Path("feed_force")), "is set, it is no hammer"
    yield lambda: dth.Coupling(dth.Hammer(RIGID), object(), 1e-3), "lacks advance, outputs"  # type: ignore[arg-type]


def unknown() -> Iterator[tuple[Callable[[], object], str]]:
    """Yields unknown names, for every place that takes a name."""
    run = dth.simulate(RIGID, 0.05)
    yield lambda: run["ropp"], "no output of the run is called 'ropp'; did you mean 'rop'"
    yield lambda: dth.steady(RIGID)["ropp"], "no mean is called 'ropp'; did you mean 'rop'"
    yield lambda: dth.Hammer(RIGID)["ropp"], "did you mean 'rop'"
    yield lambda: dth.Hammer(RIGID).set(feed=1), "did you mean 'feed_force'"
    yield lambda: dth.VARIABLES["ropp"], "did you mean 'rop'"
    yield lambda: dth.simulate("rnu"), "no preset is called 'rnu'; there is .*reference"
    yield lambda: dth.from_datasheet(presure="24 bar"), "did you mean 'pressure'"  # type: ignore[call-arg]
    yield lambda: dth.rock("marble"), 'there is no rock "marble": there are .*kuru granite'


@pytest.mark.parametrize(("call", "remedy"), [*unknown()])
def test_a_name_that_nothing_has_is_told_with_the_nearest(
    call: Callable[[], object], remedy: str
) -> None:
    with pytest.raises(dth.UnknownNameError, match=remedy):
        call()


@pytest.mark.parametrize(("call", "remedy"), [*wrong()])
def test_a_mistake_is_told_with_its_remedy(call: Callable[[], object], remedy: str) -> None:
    with pytest.raises(dth.DomainError, match=remedy):
        call()
