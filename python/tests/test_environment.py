"""Hammers as environments of gymnasium."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from dth_hammer import DomainError, Hammer, UnknownNameError

gymnasium = pytest.importorskip("gymnasium", reason="no gymnasium: pip install dth-hammer[gym]")

from dth_hammer.environment import HammerEnv, HammerVectorEnv, Task  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

FEED = (1e3, 25e3)
TASK = Task(
    actions={"feed_force": FEED},
    observations={"blow_period": (0.03, 0.06), "blow_speed": (0.0, 20.0)},
    reward=lambda outputs: outputs["blow_speed"],
    scene={"fidelity": "Rigid"},
    step="10 ms",
    steps=30,
)


def test_it_passes_the_check_of_gymnasium() -> None:
    drawn = {"rock.stiffness": ("80 MN/m", "300 MN/m")}
    check_env(HammerEnv(dataclasses.replace(TASK, drawn=drawn)), skip_render_check=True)


def test_an_action_is_a_feed_force_and_what_is_seen_are_the_hammers_outputs() -> None:
    env = HammerEnv(TASK)
    env.reset(seed=1)
    feeds = np.linspace(2e3, 20e3, TASK.steps)
    with Hammer({"fidelity": "Rigid"}) as hammer:
        for number, feed in enumerate(feeds):
            action = 2.0 * (feed - FEED[0]) / (FEED[1] - FEED[0]) - 1.0
            observed, reward, over, late, info = env.step(np.array([action]))
            hammer.set(feed_force=feed)
            hammer.step(0.01)
            # The feed of the action is off by rounding, which grows over the blows.
            expected = hammer.get(["blow_period", "blow_speed"])
            assert info["blow_speed"] == pytest.approx(expected["blow_speed"], rel=1e-9)
            assert reward == info["blow_speed"]
            scaled = 2.0 * expected["blow_speed"] / 20.0 - 1.0
            assert observed[1] == pytest.approx(np.clip(scaled, -1.0, 1.0), abs=1e-6)
            assert (over, late) == (False, number + 1 == TASK.steps)


def test_hammers_side_by_side_are_those_alone_on_any_number_of_threads() -> None:
    drawn = {"rock.stiffness": (8e7, 3e8)}
    task = dataclasses.replace(TASK, drawn=drawn, steps=12)
    actions = np.random.default_rng(3).uniform(-1.0, 1.0, (14, 5, 1))
    runs = []
    for threads in (1, 2, 5):
        envs = HammerVectorEnv(task, 5, threads)
        first, _ = envs.reset(seed=7)
        found = [envs.step(a) for a in actions]
        runs.append([first, *(np.column_stack([f[0], *f[1:4]]) for f in found)])
        # Every hammer ends at step 12, begins anew at 13 with another rock, and goes on.
        late = np.array([f[3] for f in found])
        assert late.sum(axis=1).tolist() == [0] * 11 + [5, 0, 0]
        assert (found[12][1] == 0.0).all()
    for other in runs[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(runs[0], other, strict=True))
    speeds = [row[:, 1] for row in runs[0][1:]]
    assert len({float(s) for s in speeds[11]}) == 5


def test_a_hammer_that_stalls_ends_its_episode_and_a_refused_one_is_told() -> None:
    # Heavier than the drive can lift, the piston comes to rest on the bit.
    scene = {"fidelity": "Rigid", "gravity": 100.0, "drive.amplitude": 10.0}
    env = HammerEnv(dataclasses.replace(TASK, scene=scene, step="100 ms", steps=1000))
    env.reset(seed=1)
    ends = [env.step(np.zeros(1)) for _ in range(40)]
    assert [end[4]["stalled"] == 1.0 for end in ends] == [end[2] for end in ends]
    assert ends[-1][2]
    assert not ends[-1][3]
    # A rock of no stiffness is refused, and the episode ends; the next one begins well.
    hard: dict[str, Any] = {"rock.stiffness": (1e-200, 1.2e8)}
    wrong = HammerVectorEnv(dataclasses.replace(TASK, actions=hard), 2)
    wrong.reset(seed=1)
    observed, rewards, over, _, _ = wrong.step(np.array([[-1.0], [1.0]]))
    assert over.tolist() == [True, False]
    assert rewards[0] == 0.0
    assert (observed[0] == -1.0).all()
    observed, _, over, _, _ = wrong.step(np.array([[1.0], [1.0]]))
    assert not over.any()


def test_a_task_that_makes_no_sense_is_refused_by_name() -> None:
    def changed(**what: Any) -> Task:
        return dataclasses.replace(TASK, **what)

    with pytest.raises(UnknownNameError, match="feed_force"):
        HammerEnv(changed(actions={"feed_forc": FEED}))
    with pytest.raises(DomainError, match="first must be less"):
        HammerEnv(changed(actions={"feed_force": FEED[::-1]}))
    with pytest.raises(DomainError, match="while a hammer runs"):
        HammerEnv(changed(actions={"piston.length": (0.1, 0.2)}))
    with pytest.raises(DomainError, match="steps = 0"):
        HammerEnv(changed(steps=0))
    with pytest.raises(DomainError, match="needs actions"):
        HammerEnv(changed(observations={}))
    for count in (0, -1, 10**9):
        with pytest.raises(DomainError, match=f"{count} hammers must be 1 to"):
            HammerVectorEnv(TASK, count)
    with pytest.raises(DomainError, match="-1 threads must be 1 to"):
        HammerVectorEnv(TASK, 2, threads=-1)
    env = HammerEnv(TASK)
    env.reset(seed=1)
    with pytest.raises(DomainError, match="finite"):
        env.step(np.array([np.nan]))
