"""Reads the first argument of every function and command: a hammer, in any accepted form."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

from ..errors import DomainError, warn
from .datasheet import Datasheet
from .rocks import ROCK, ROCKS
from .scene import Scene
from .variables import PRESETS, VARIABLES, Value, numbers


class Simulated(Protocol):
    """A result of a simulation, such as a `Run`, that knows its scene."""

    @property
    def scene(self) -> Scene:
        """The scene that was simulated."""


class Row(Protocol):
    """A row of a table of pandas."""

    def to_dict(self) -> Mapping[Any, Any]:
        """Returns its values by column."""

    def to_frame(self) -> Any:
        """Returns the row as a table. Tables have no such method, so it identifies a row."""


#: Parameters by name or as a row of a table, the name of a preset, a scene or the path of its file,
#: a datasheet, or a run.
Hammerlike = Mapping[str, Value] | Row | Scene | str | Path | Datasheet | Simulated | None
#: A rock: the name that `dth_hammer.rock` takes, or the parameters that it returns.
Rocklike = str | Mapping[str, Value] | None


def scene_of(hammer: Hammerlike, rock: Rocklike = None, preset: str | None = None) -> Scene:
    """Returns the scene of a hammer in a rock.

    ``preset`` provides the parameters that ``hammer`` does not give. ``rock`` replaces all rock
    parameters of a scene, a datasheet or a run; rock parameters that a mapping gives explicitly
    take precedence over ``rock``, with a warning that names them.
    """
    scene = _read(hammer)
    if preset is not None:
        if scene.preset not in (None, preset):
            raise DomainError(f"the hammer is of the preset {scene.preset!r}, not of {preset!r}")
        scene = replace(scene, preset=preset)
    if rock is None:
        return scene
    parameters = scene.parameters
    of_rock = [name for name in parameters if name.partition(".")[0] == ROCK]
    if not isinstance(hammer, Mapping):
        parameters = {n: v for n, v in parameters.items() if n not in of_rock}
    elif of_rock:
        warn(
            f"{', '.join(of_rock)} of the mapping take precedence over rock={rock!r}: leave them "
            "out to drill that rock"
        )
    return replace(
        scene, parameters={**({ROCK: rock} if isinstance(rock, str) else rock), **parameters}
    )


def _read(hammer: Hammerlike) -> Scene:
    if hammer is None or isinstance(hammer, Scene):
        return hammer or Scene()
    if isinstance(hammer, Mapping):
        return Scene(parameters={str(name): value for name, value in hammer.items()})
    if isinstance(hammer, Datasheet):
        return Scene("Hammer of a datasheet", parameters=dict(hammer.parameters))
    if hasattr(hammer, "to_dict") and hasattr(hammer, "to_frame"):
        # A row of a pandas table. A row from a sweep also has results, which are ignored.
        known = {v.name for v in VARIABLES.of("parameter", "input")}
        cells = {str(n): x for n, x in hammer.to_dict().items()}
        swept = "run" in cells
        return Scene(parameters={n: x for n, x in cells.items() if not swept or n in known})
    if not isinstance(hammer, str | Path):
        scene = getattr(hammer, "scene", None)
        if not isinstance(scene, Scene):
            raise DomainError(
                f"hammer = {hammer!r} is not parameters by name, a preset, a scene or its file, "
                "a datasheet or a run"
            )
        return scene
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
    """Returns the checked numbers of a hammer whose inputs are constant."""
    scene = scene_of(hammer, rock, preset)
    fixed = {n: v for n, v in scene.inputs.items() if isinstance(v, (int, float, str))}
    if moving := {*scene.inputs} - {*fixed}:
        raise DomainError(
            f"{', '.join(sorted(moving))} over time: only constant inputs are possible here"
        )
    return scene.numbers | {n: VARIABLES.settable(n).number(v) for n, v in fixed.items()}
