"""The .fmu file: its path and its declarations."""

import os
import zipfile
from functools import lru_cache
from pathlib import Path, PureWindowsPath
from xml.etree import ElementTree as ET

from ..errors import DomainError, FmuNotFoundError, reading

#: The archives, by the version of FMI.
FILES = {2: "dth_hammer.fmu", 3: "dth_hammer_fmi3.fmu"}
#: Name of the identity in a description, by the version of FMI.
IDENTITY = {2: "guid", 3: "instantiationToken"}
DESCRIPTION = "modelDescription.xml"
#: Environment variable that names the FMU of FMI 2.0 to use.
ENVIRONMENT = "DTH_HAMMER_FMU"


def find(fmu: str | Path | None = None, *, fmi: int = 2) -> Path:
    """Finds the FMU: the argument, else ``DTH_HAMMER_FMU``, else the packaged one.

    In a source checkout the file that ``cargo fmu`` wrote comes before the packaged copy.

    Example:
        >>> from dth_hammer import fmu
        >>> print(fmu.find(fmi=3).name)
        dth_hammer_fmi3.fmu
    """
    if fmi not in FILES:
        raise DomainError(f"fmi = {fmi} is not 2 or 3")
    chosen = fmu or (os.environ.get(ENVIRONMENT) if fmi == 2 else None)
    if chosen:
        path = Path(chosen).expanduser().resolve()
        if not path.is_file():
            origin = "argument" if fmu else ENVIRONMENT
            raise FmuNotFoundError(f"no FMU at {path} (from the {origin})")
        return path
    here = Path(__file__).resolve().parents[1]
    file = FILES[fmi]
    for path in (here.parents[2] / "dist" / file, here / "data" / file):
        if path.is_file():
            return path
    raise FmuNotFoundError(
        f"no {file} found: install the wheel that `cargo wheel` makes, pass the file's path, or "
        f"set {ENVIRONMENT}"
    )


#: More entries than the FMU of the hammer has for all platforms (40 entries, 10 MB).
MOST_ENTRIES = 1000
MOST_BYTES = 100_000_000
#: A partner's FMU may be this many times larger, because some contain a runtime.
PARTNER = 10


def inspect(archive: zipfile.ZipFile, times: int = 1) -> None:
    """Checks the directory of an archive without unpacking anything.

    Args:
        archive: an FMU.
        times: how many times as large as one of the hammer it may be.

    Raises:
        BadZipFile: it has too many entries, would unpack to too much, or to outside a folder.
    """
    entries = archive.infolist()
    size = sum(entry.file_size for entry in entries)
    if len(entries) > times * MOST_ENTRIES:
        raise zipfile.BadZipFile(f"it has {len(entries)} entries, more than {times * MOST_ENTRIES}")
    if size > times * MOST_BYTES:
        limit = f"more than {times * MOST_BYTES / 1e6:.0f} MB"
        raise zipfile.BadZipFile(f"it would unpack to {size / 1e6:.0f} MB, {limit}")
    names = [entry.filename for entry in entries]
    for name in names:
        path = PureWindowsPath(name)  # Knows both slashes, and drives.
        if path.drive or path.root or ".." in path.parts:
            raise zipfile.BadZipFile(f"it would unpack {name!r} outside its folder")
    if len({*names}) < len(names):
        raise zipfile.BadZipFile("it has two entries of one name")


class Package:
    """An FMU of the hammer, as its description declares it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with reading(path, "an FMU", FmuNotFoundError):
            with zipfile.ZipFile(path) as archive:
                inspect(archive)
                self.text = archive.read(DESCRIPTION)
            root = ET.fromstring(self.text)
        node = root.find("CoSimulation")
        #: The version of FMI: 2 or 3.
        self.fmi = 3 if root.get("fmiVersion", "").startswith("3") else 2
        names = [root.get(name) for name in ("modelName", "version", IDENTITY[self.fmi])]
        identifier = None if node is None else node.get("modelIdentifier")
        if None in names or identifier != Path(FILES[2]).stem:
            raise FmuNotFoundError(f"{path} is not an FMU of this hammer")
        #: Name of the model; its version and identity, for provenance.
        self.name, self.version = str(names[0]), f"{names[1]} {names[2]}"

    @property
    def description(self) -> ET.Element:
        """Returns a copy of its model description as a tree."""
        return ET.fromstring(self.text)

    def __repr__(self) -> str:
        return f"<Package {self.path} {self.version}>"


@lru_cache(maxsize=8)
def _load(path: Path, _stamp: tuple[int, int]) -> Package:
    return Package(path)


def load(fmu: str | Path | Package | None = None, *, fmi: int = 2) -> Package:
    """Reads the FMU that `find` finds. A process reads a file again only if it has changed.

    Args:
        fmu: file to use in place of the one in the package.
        fmi: version of FMI, 2 or 3, of the one in the package.

    Example:
        >>> import dth_hammer
        >>> from dth_hammer import fmu
        >>> print(fmu.load().version.split()[0] == dth_hammer.__version__)
        True
    """
    if isinstance(fmu, Package):
        return fmu
    path = find(fmu, fmi=fmi)
    status = path.stat()
    return _load(path, (status.st_mtime_ns, status.st_size))


def provenance(fmu: str | Path | Package | None = None, *, fmi: int = 2) -> str:
    """Returns name, version and path of the FMU that `load` reads, or why there is none."""
    try:
        package = load(fmu, fmi=fmi)
    except FmuNotFoundError as error:
        return str(error)
    return f"{package.name} {package.version}\n{package.path}"
