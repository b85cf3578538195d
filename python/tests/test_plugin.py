"""The fixtures in this project's own tests; test_wheel.py uses them in a foreign project."""

from collections.abc import Callable

import pytest
from dth_hammer import VARIABLES, Hammer, rock, simulate


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
