"""A scene in a JSON file, as the laboratory and `dth-hammer datasheet` write it.

    {
      "description": "Granite, with a feed that rises",
      "preset": "air_4_inch",
      "rock": "granite",
      "start_values": {"feed_force": "6 kN", "piston.length": 0.18},
      "inputs": {"feed_force": {"0 s": "4 kN", "1 s": "8 kN"}},
      "until": "1 s"
    }

Every entry is optional. Inputs may be in a file, ``"inputs": "feed.csv"``, with a column ``time``
and one for each input. The FMU's presets and the laboratory's files are also scenes.
"""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import InitVar, dataclass, field
from pathlib import Path
from typing import Any

from .. import _native, outputs
from ..contract import typed
from ..errors import DomainError
from ..frames import pd
from . import quantities
from .rocks import ROCK
from .signals import Signal, of_file
from .variables import VARIABLES, Value, numbers

KEYS = ("description", "preset", "rock", "start_values", "inputs", "until")


@typed()
@dataclass(frozen=True)
class Scene:
    """A hammer, what acts on it, and for how long.

    Example:
        >>> from dth_hammer import Scene
        >>> scene = Scene(rock="granite", parameters={"feed_force": "8 kN"}, until="1 s")
        >>> print(scene.numbers["feed_force"])
        8000.0
    """

    title: str = ""
    description: str = ""
    preset: str | None = None
    parameters: Mapping[str, Value] = field(default_factory=dict)
    inputs: Mapping[str, Signal] = field(default_factory=dict)
    until: float | str | None = None
    #: Stored among the parameters.
    rock: InitVar[str | None] = None

    def __post_init__(self, rock: str | None) -> None:
        """Adds the rock to the parameters."""
        own = {} if rock is None else {ROCK: rock}
        object.__setattr__(self, "parameters", {**self.parameters, **own})

    @property
    def numbers(self) -> dict[str, float]:
        """Checked numbers of the preset, overridden by the parameters."""
        return self.over({})

    def over(self, under: Mapping[str, float]) -> dict[str, float]:
        """Returns the scene's numbers, which override the given ones."""
        return numbers(self.preset, self.parameters, under)

    def _repr_html_(self) -> str:
        """Returns the scene's settings for notebooks."""
        beside = {"preset": self.preset, "inputs": ", ".join(self.inputs), "until": self.until}
        rows = {name: VARIABLES[name].text(number) for name, number in self.numbers.items()}
        table = pd.Series({**{n: str(v) for n, v in beside.items() if v}, **rows}, name="value")
        return f"<p>{html.escape(self.title or 'scene')}</p>{table.to_frame().to_html()}"

    @property
    def damping_ratio(self) -> float:
        """Damping ratio ``beta omega / 2`` of the piston's first elastic mode."""
        return _native.damping(self.numbers, 0.0)[1]

    def damping_time(self, ratio: Value) -> float:
        """Returns the ``material.damping_time`` (s) for a damping ratio of the first elastic mode.

        It is the piston's mode: ``beta = 2 zeta / omega``. The reference's 2e-8 s is 0.1 % of
        critical damping, with which the blows of stepped bodies never repeat. The named hammers
        have 0.5 %.

        Args:
            ratio: damping as a share of critical damping, 0 to 0.5.
        """
        return _native.damping(self.numbers, quantities.read(ratio, "1", "ratio"))[0]

    @classmethod
    def read(cls, path: str | Path) -> Scene:
        """Reads a scene from a file. Error messages name the place in the file."""
        path = Path(path)
        content = outputs.read_object(path, KEYS, "part of a scene")
        if isinstance(file := content.get("inputs"), str):
            content["inputs"] = of_file(path.parent / file)
        values, inputs = (_object(content, key, path) for key in ("start_values", "inputs"))
        rock = content.get("rock")
        if rock is not None and not isinstance(rock, str):
            raise DomainError(
                f"rock of {path.name} must be a name, a class, a strength, or the path of a rock's "
                'file: write its numbers into a file of their own, and "rock": "own.json"'
            )
        if rock is not None and rock.endswith(".json"):
            rock = str(path.parent / rock)
        return cls(
            title=path.stem,
            description=str(content.get("description", "")),
            preset=content.get("preset"),
            parameters=values,
            inputs={name: _signal(name, value) for name, value in inputs.items()},
            until=content.get("until"),
            rock=rock,
        )


def _object(content: Mapping[str, Any], key: str, path: Path) -> dict[str, Any]:
    found = content.get(key, {})
    if not isinstance(found, dict):
        raise DomainError(f"{key} of {path.name} must be an object in braces")
    return found


def _signal(name: str, value: Any) -> Signal:
    if isinstance(value, dict):
        if not value:
            raise DomainError(f"the input {name} has no instants")
        return pd.Series([*value.values()], index=[*value], dtype=object)
    if isinstance(value, (int, float, str, pd.Series)):
        return value
    raise DomainError(f"the input {name} must be a value, or values by instant in braces")
