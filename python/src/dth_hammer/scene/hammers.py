"""One hammer, however it is given: what every function and every command takes first."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from ..errors import DomainError
from .datasheet import Datasheet
from .rocks import ROCK, ROCKS
from .scene import Scene
from .variables import PRESETS, VARIABLES, Value, numbers


class Simulated(Protocol):
    """What was simulated, such as a `Run`."""

    @property
    def scene(self) -> Scene:
        """What it was made from."""


#: Parameters by name, a preset's name, a scene or the path of its file, a datasheet, a run.
Hammerlike = Mapping[str, Value] | Scene | str | Path | Datasheet | Simulated | None
#: What `dth_hammer.rock` takes, or what it returns.
Rocklike = str | Mapping[str, Value] | None


def scene_of(hammer: Hammerlike, rock: Rocklike = None, preset: str | None = None) -> Scene:
    """The scene of a hammer in a rock; under a mapping lies a preset.

    Numbers of a rock in a mapping go before those of ``rock``, which takes the place of all that a
    scene, a datasheet or a run has of its own.
    """
    found = _read(hammer)
    if preset is not None:
        if found.preset not in (None, preset):
            raise DomainError(f"the hammer is of the preset {found.preset!r}, not of {preset!r}")
        found = replace(found, preset=preset)
    if rock is None:
        return found
    own = found.parameters
    if not isinstance(hammer, Mapping):
        own = {n: v for n, v in own.items() if n.partition(".")[0] != ROCK}
    return replace(found, parameters={**({ROCK: rock} if isinstance(rock, str) else rock), **own})


def _read(hammer: Hammerlike) -> Scene:
    if hammer is None or isinstance(hammer, Scene):
        return hammer or Scene()
    if isinstance(hammer, Mapping):
        return Scene(parameters={str(name): value for name, value in hammer.items()})
    if isinstance(hammer, Datasheet):
        return Scene("Hammer of a datasheet", parameters=dict(hammer.parameters))
    if not isinstance(hammer, str | Path):
        found = getattr(hammer, "scene", None)
        if not isinstance(found, Scene):
            raise DomainError(
                f"hammer = {hammer!r} is not parameters by name, a preset, a scene or its file, "
                "a datasheet or a run"
            )
        return found
    if str(hammer) in PRESETS:
        return Scene(str(hammer).replace("_", " "), preset=str(hammer))
    if Path(hammer).suffix.lower() == ".json" or Path(hammer).is_file():
        return Scene.read(hammer)
    word = str(hammer).strip().lower()
    if any(word in (name, *name.split()) for name in ROCKS):
        raise DomainError(f"{word!r} is a rock: give rock={word!r} beside a hammer")
    names = [v.name for v in VARIABLES.of("parameter", "input")]
    if meant := [name for name in names if re.match(rf"{re.escape(word)}[._]", f"{name}.")]:
        raise DomainError(
            f"{word!r} is set, it is no hammer: give parameters by name, {{{meant[0]!r}: ...}}"
        )
    numbers(str(hammer), None)
    raise DomainError(f"{word!r} is not a hammer")


def numbers_of(
    hammer: Hammerlike, preset: str | None = None, rock: Rocklike = None
) -> dict[str, float]:
    """The checked numbers of a hammer whose inputs do not change."""
    scene = scene_of(hammer, rock, preset)
    fixed = {n: v for n, v in scene.inputs.items() if isinstance(v, (int, float, str))}
    if moving := {*scene.inputs} - {*fixed}:
        raise DomainError(
            f"{', '.join(sorted(moving))} over time: only constant inputs are possible here"
        )
    return scene.numbers | {n: VARIABLES.settable(n).number(v) for n, v in fixed.items()}
