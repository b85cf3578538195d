"""The fixtures, in this project's own tests and in a foreign one's."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from dth_hammer import VARIABLES, Hammer, rock, simulate

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_fixture_is_a_reference_hammer_at_time_0(hammer: Hammer) -> None:
    assert hammer.time == 0.0
    assert hammer["rock.stiffness"] == VARIABLES["rock.stiffness"].start


@pytest.mark.hammer({"drive.source": "Pressure"}, rock="granite")
def test_a_marker_changes_it(hammer: Hammer) -> None:
    assert hammer.label("drive.source") == "Pressure"
    assert hammer["rock.stiffness"] == rock("granite", hole="90 mm")["rock.stiffness"]


def test_many_hammers(make_hammer: Callable[..., Hammer]) -> None:
    one, two = make_hammer(), make_hammer({"feed_force": "8 kN"})
    assert two["feed_force"] > one["feed_force"]


def test_the_assertions_are_fixtures_too(
    assert_energy_balanced: Callable[..., None], assert_periodic: Callable[..., None]
) -> None:
    frame = simulate(until=0.6)
    assert_energy_balanced(frame)
    assert_periodic(frame)


def test_a_foreign_project_finds_the_plugin_by_itself(tmp_path: Path) -> None:
    # Elsewhere, without this project's settings: only what is installed counts.
    for file in (EXAMPLES / "controller").glob("*.py"):
        (tmp_path / file.name).write_text(file.read_text(encoding="utf-8"), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "--strict-markers", "-W", "error"]
    done = subprocess.run(
        [*command, str(tmp_path)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout
