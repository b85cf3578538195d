"""The .fmu file: where it is, what it declares, the presets in it."""

from __future__ import annotations

import atexit
import json
import os
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import fmpy
from fmpy.model_description import ModelDescription

from .errors import FmuNotFoundError, UnknownNameError
from .journal import Journal
from .mesh import Families
from .variables import Variables

FILE = "dth_hammer.fmu"
#: Environment variable that names the FMU to use.
ENVIRONMENT = "DTH_HAMMER_FMU"


def find(fmu: str | Path | None = None) -> Path:
    """The FMU: the argument, else the environment's, else the packaged one.

    A source checkout counts before the packaged copy, so that a fresh ``cargo fmu``
    is what one runs there.
    """
    chosen = fmu or os.environ.get(ENVIRONMENT)
    if chosen:
        path = Path(chosen).expanduser().resolve()
        if not path.is_file():
            origin = "argument" if fmu else ENVIRONMENT
            raise FmuNotFoundError(f"no FMU at {path} (from the {origin})")
        return path
    here = Path(__file__).resolve().parent
    for path in (here.parents[2] / "dist" / FILE, here / "data" / FILE):
        if path.is_file():
            return path
    raise FmuNotFoundError(
        f"no {FILE} found: install the wheel that `cargo wheel` makes, pass the file's path, or "
        f"set {ENVIRONMENT}"
    )


@dataclass(frozen=True)
class Preset:
    """A parameter set from the FMU's resources."""

    name: str
    description: str
    values: Mapping[str, Any]


class Package:
    """An unpacked FMU; removed when the process ends."""

    def __init__(self, path: Path) -> None:
        self.path = path
        #: Where it is unpacked.
        self.folder = tempfile.mkdtemp(prefix="dth-hammer-")
        atexit.register(shutil.rmtree, self.folder, ignore_errors=True)
        self.description: ModelDescription = self._unpack()
        self.variables = Variables(
            self.description, Families(Path(self.folder, "modelDescription.xml"))
        )
        self.presets = self._presets()
        #: Where it tells the blows of a step.
        self.journal = Journal(Path(self.folder, "modelDescription.xml"))

    def _unpack(self) -> ModelDescription:
        try:
            with zipfile.ZipFile(self.path) as archive:
                archive.extractall(self.folder)
        except (zipfile.BadZipFile, OSError) as error:
            raise FmuNotFoundError(f"{self.path} is no FMU: {error}") from None
        try:
            description = fmpy.read_model_description(self.folder)
        except Exception as error:
            text = " ".join(str(error).split()) or type(error).__name__
            raise FmuNotFoundError(f"{self.path} is no FMU that can be read: {text}") from None
        simulation = description.coSimulation
        if simulation is None or simulation.modelIdentifier != Path(FILE).stem:
            raise FmuNotFoundError(f"{self.path} is an FMU, but not of this hammer")
        return description

    def __repr__(self) -> str:
        return f"<Package {self.path} {self.description.version}>"

    @property
    def platforms(self) -> list[str]:
        """What its libraries are compiled for, in the standard's words."""
        return sorted(path.name for path in Path(self.folder, "binaries").iterdir())

    @property
    def version(self) -> str:
        """Version and identity of the model, for provenance."""
        return f"{self.description.version} {self.description.guid}"

    @property
    def step(self) -> float:
        """The communication step that the FMU proposes, s."""
        return float(self.description.defaultExperiment.stepSize)

    @property
    def stop(self) -> float:
        """The duration that the FMU proposes, s."""
        return float(self.description.defaultExperiment.stopTime)

    def preset(self, name: str) -> Preset:
        """A preset by name."""
        try:
            return self.presets[name]
        except KeyError:
            raise UnknownNameError("preset", name, self.presets) from None

    def values(self, preset: str | None, parameters: Mapping[str, Any] | None) -> dict[str, float]:
        """Checked numbers of a preset with parameters laid over it."""
        chosen = dict(self.preset(preset).values) if preset else {}
        chosen |= parameters or {}
        return {name: self.variables.settable(name).number(v) for name, v in chosen.items()}

    def _presets(self) -> dict[str, Preset]:
        found = {}
        for path in sorted(Path(self.folder, "resources").glob("*.json")):
            content = json.loads(path.read_text(encoding="utf-8"))
            if "start_values" in content:
                text = content.get("description", "")
                found[path.stem] = Preset(path.stem, text, content["start_values"])
        return found


@lru_cache(maxsize=8)
def _load(path: Path, _stamp: tuple[int, int]) -> Package:
    return Package(path)


def load(fmu: str | Path | Package | None = None) -> Package:
    """The package, unpacked once a process; again when the file has changed."""
    if isinstance(fmu, Package):
        return fmu
    path = find(fmu)
    status = path.stat()
    return _load(path, (status.st_mtime_ns, status.st_size))
