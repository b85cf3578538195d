"""Hammers as environments of gymnasium, for controllers that learn: `pip install dth-hammer[gym]`.

At each step an environment sets inputs and tunable parameters, simulates for a fixed time, and
reads outputs. Actions and observations are scaled to -1 and 1 at stated bounds, and clipped there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native, quantities
from .errors import DomainError, RefusedError
from .extras import need
from .longrun import Hammerlike, numbers_of
from .variables import STEP, VARIABLES, Array, Value
from .workers import cores

if TYPE_CHECKING:
    import gymnasium
    from gymnasium import vector
else:
    gymnasium, vector = need("gymnasium", "gym"), need("gymnasium.vector", "gym")

#: Bounds by name.
Bounds = Mapping[str, tuple[Value, Value]]
#: Pay for a step: from values by name in SI units, one for each hammer.
Reward = Callable[[Mapping[str, Array]], Array]
#: Always read: whether the piston lies on the bit for good.
STALLED = "stalled"


@dataclass(frozen=True)
class Task:
    """What a controller may set and sees, and what it is paid for."""

    #: Inputs and tunable parameters that are set at each step.
    actions: Bounds
    #: Variables that are observed after it.
    observations: Bounds
    #: Of actions, observations and ``stalled`` by name. What is not a number counts as 0.
    reward: Reward
    #: The hammer: a `Scene`, or parameters by name.
    scene: Hammerlike = None
    #: Parameter set to start from.
    preset: str | None = None
    #: Parameters and inputs that each episode draws, uniformly.
    drawn: Bounds = field(default_factory=dict)
    #: Time between actions, s or as ``"1 ms"``.
    step: float | str = STEP
    #: Steps of an episode.
    steps: int = 1000


class _Hammers:
    """Hammers of a task, scaled."""

    def __init__(self, task: Task, count: int, threads: int) -> None:
        if task.steps < 1:
            raise DomainError(f"steps = {task.steps} must be 1 or more")
        if not task.actions or not task.observations:
            raise DomainError("a task needs actions and observations")
        self.task, self.given = task, numbers_of(task.scene, task.preset)
        self.size = quantities.duration(task.step, "step")
        self.names = [*dict.fromkeys([*task.actions, *task.observations, STALLED])]
        self.low, self.high = _bounds(task.actions, VARIABLES.settable)
        self.floor, self.top = _bounds(task.observations, VARIABLES.__getitem__)
        self.drawn = _bounds(task.drawn, VARIABLES.settable)
        selection = _native.Selection(self.names)
        self._fleet = _native.Fleet(count, [*task.actions], selection, threads)
        self._seen = [self.names.index(name) for name in task.observations]
        self.taken = np.zeros(count, dtype=int)
        self.rows, self.refused = np.full((count, len(self.names)), np.nan), dict[int, str]()

    def start(self, which: Array, random: np.random.Generator) -> None:
        """Begins episodes, each with a hammer of its own."""
        drawn = random.uniform(*self.drawn, size=(len(which), len(self.task.drawn)))
        scenes = [
            [*(self.given | dict(zip(self.task.drawn, map(float, row), strict=True))).items()]
            for row in drawn
        ]
        self.taken[which] = 0
        self._read(self._fleet.restart([*zip(map(int, which), scenes, strict=True)]))
        if bad := [k for k in map(int, which) if k in self.refused]:
            raise RefusedError(self.refused[bad[0]])

    def step(self, actions: Array) -> None:
        """Sets, simulates and reads."""
        part = 0.5 + 0.5 * np.clip(np.asarray(actions, dtype=float), -1.0, 1.0)
        self._read(self._fleet.step(self.size, self.low + part * (self.high - self.low)))
        self.taken += 1

    def _read(self, answer: tuple[Array, list[tuple[int, str]]]) -> None:
        self.rows, self.refused = answer[0], dict(answer[1])

    @property
    def observed(self) -> Array:
        """Scaled; -1 of what is not a number."""
        part = (self.rows[:, self._seen] - self.floor) / (self.top - self.floor)
        scaled: Array = np.clip(np.nan_to_num(2.0 * part - 1.0, nan=-1.0), -1.0, 1.0)
        return scaled.astype(np.float32)

    @property
    def values(self) -> dict[str, Array]:
        """What was read, by name, in SI units."""
        return dict(zip(self.names, self.rows.T, strict=True))

    @property
    def ended(self) -> tuple[Array, Array]:
        """Which hammers stalled or were refused, and whose time is over."""
        stalled = self.rows[:, self.names.index(STALLED)]
        return ~(stalled == 0.0), self.taken >= self.task.steps

    def reward(self) -> Array:
        """For the last step."""
        given = np.asarray(self.task.reward(self.values), dtype=float)
        return np.where(np.isnan(given), 0.0, given)


def _bounds(given: Bounds, variable: Callable[[str], Any]) -> tuple[Array, Array]:
    """Lower and upper bounds, checked."""
    rows = [[variable(name).number(bound) for bound in pair] for name, pair in given.items()]
    for name, (low, high) in zip(given, rows, strict=True):
        if not low < high:
            raise DomainError(f"{name} from {low:g} to {high:g}: the first must be less")
    low, high = np.array(rows, dtype=float).reshape(len(rows), 2).T
    return low, high


def _space(count: int) -> Any:
    return gymnasium.spaces.Box(-1.0, 1.0, (count,), np.float32)


class HammerEnv(gymnasium.Env[Array, Array]):
    """One hammer. An episode ends early where the hammer stalls or the engine refuses it."""

    def __init__(self, task: Task) -> None:
        self._hammers = _Hammers(task, 1, 1)
        self.action_space = _space(len(task.actions))
        self.observation_space = _space(len(task.observations))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begins an episode."""
        super().reset(seed=seed)
        self._hammers.start(np.zeros(1, dtype=int), self.np_random)
        return self._hammers.observed[0], self._info()

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Sets the action and simulates."""
        self._hammers.step(np.asarray(action)[None])
        (over,), (late,) = self._hammers.ended
        reward = float(self._hammers.reward()[0])
        return self._hammers.observed[0], reward, bool(over), bool(late), self._info()

    def _info(self) -> dict[str, Any]:
        values = {name: float(column[0]) for name, column in self._hammers.values.items()}
        why = self._hammers.refused.get(0)
        return {**values, "refused": why} if why else values


class HammerVectorEnv(vector.VectorEnv[Array, Array, Array]):
    """Many hammers side by side on threads; each begins anew at the step after its end.

    Args:
        task: the same for all.
        num_envs: how many.
        threads: as many as there are cores if not given.
    """

    def __init__(self, task: Task, num_envs: int, threads: int | None = None) -> None:
        self.metadata = {"autoreset_mode": vector.AutoresetMode.NEXT_STEP}
        self.num_envs = num_envs
        self._hammers = _Hammers(task, num_envs, threads or cores())
        #: Time between actions, s.
        self.size = self._hammers.size
        self._over = np.zeros(num_envs, dtype=bool)
        self.single_action_space = _space(len(task.actions))
        self.single_observation_space = _space(len(task.observations))
        batch = vector.utils.batch_space
        self.action_space = batch(self.single_action_space, num_envs)
        self.observation_space = batch(self.single_observation_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begins all episodes."""
        super().reset(seed=seed)
        self._hammers.start(np.arange(self.num_envs), self.np_random)
        self._over[:] = False
        return self._hammers.observed, self._hammers.values

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Sets the actions and simulates; a hammer that has ended begins anew instead."""
        hammers, again = self._hammers, self._over
        hammers.step(actions)
        if again.any():
            hammers.start(np.flatnonzero(again), self.np_random)
        over, late = hammers.ended
        rewards = np.where(again, 0.0, hammers.reward())
        self._over = over | late
        return hammers.observed, rewards, over, late, hammers.values
