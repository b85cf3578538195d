"""Another project's tests of its controller: the fixtures come with `dth-hammer`.

pytest examples/controller
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from controller import FeedController
from dth_hammer import Hammer, simulate

STEP = 2e-4  # s
WANTED = 1e-3  # m of lift after a blow


def drill(hammer: Hammer, controller: FeedController, blows: int) -> list[float]:
    """Lets the controller act after each blow; returns the lifts."""
    lifts, lift, count = [], 0.0, 0.0
    while len(lifts) < blows:
        hammer.step(STEP)
        now = hammer.get(["blow_count", "tip_depth", "bit_tip_position"])
        lift = max(lift, now["tip_depth"] - now["bit_tip_position"])
        if now["blow_count"] > count:
            count = now["blow_count"]
            hammer.set(feed_force=controller.after_blow(lift, WANTED))
            lifts.append(lift)
            lift = 0.0
    return lifts


@pytest.fixture
def controller() -> FeedController:
    return FeedController(start=3e3, lowest=1e3, highest=2e4, gain=1.5e6)


def test_the_lift_comes_closer_to_what_is_wanted(
    hammer: Hammer, controller: FeedController, assert_energy_balanced: Callable[..., None]
) -> None:
    lifts = drill(hammer, controller, 12)
    assert abs(lifts[-1] - WANTED) < abs(lifts[2] - WANTED)
    assert_energy_balanced(hammer)


@pytest.mark.hammer(rock="granite")
def test_the_feed_stays_in_its_range_in_granite(hammer: Hammer, controller: FeedController) -> None:
    drill(hammer, controller, 6)
    assert controller.lowest <= hammer["feed_force"] <= controller.highest


def test_without_a_controller_the_hammer_settles(assert_periodic: Callable[..., None]) -> None:
    assert_periodic(simulate({"feed_force": 3e3}, until=0.6), relative=1e-4)
