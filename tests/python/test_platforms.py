"""The libraries for other machines, each run by a small host in C: the same bits on all.

They are there after `cargo suite --all-platforms`; otherwise all is skipped.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZipFile

import pytest
from fmpy import read_model_description
from programs import ran

SOURCES = Path(__file__).parents[1] / "platforms"
ZIG = Path(sys.prefix).with_name("venv-cross") / "bin" / "python"
# Folder in which Debian's libc6-arm64-cross puts the C library for aarch64.
AARCH64_SYSTEM = Path("/usr/aarch64-linux-gnu")
STEP, STEPS = 1e-3, 100
# Blows of the reference hammer in that time.
BLOWS = 2


@dataclass(frozen=True)
class Standard:
    """A host in C for one version of FMI, the libraries that it loads, and its number of lines."""

    source: str
    archive: str
    real: str
    linux: str
    windows: str
    aarch64: tuple[str, str]
    rows: int


STANDARDS = {
    "fmi2": Standard(
        source="host.c",
        archive="dth_hammer.fmu",
        real="Real",
        linux="binaries/linux64/dth_hammer.so",
        windows="binaries/win64/dth_hammer.dll",
        aarch64=("dth_hammer-aarch64.fmu", "binaries/linux64/dth_hammer.so"),
        rows=1 + STEPS,  # the start, and communication points
    ),
    "fmi3": Standard(
        source="host3.c",
        archive="dth_hammer_fmi3.fmu",
        real="Float64",
        linux="binaries/x86_64-linux/dth_hammer.so",
        windows="binaries/x86_64-windows/dth_hammer.dll",
        aarch64=("dth_hammer_fmi3.fmu", "binaries/aarch64-linux/dth_hammer.so"),
        rows=STEPS + BLOWS,  # wherever a step ends: at communication points, early at blows
    ),
}


def needs(program: str, package: str) -> str:
    path = shutil.which(program)
    if path is None:
        pytest.skip(f"{program} is not installed: apt install {package}")
    return path


def build(*command: str | Path) -> None:
    assert ran(command) == ""


@pytest.fixture(scope="module", params=STANDARDS)
def standard(request: pytest.FixtureRequest) -> Standard:
    return STANDARDS[request.param]


@pytest.fixture(scope="module")
def folder(standard: Standard, fmu_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Unpacks the archive for x86-64 into a folder, in which hosts are built."""
    folder = tmp_path_factory.mktemp("platforms")
    with ZipFile(fmu_path.with_name(standard.archive)) as archive:
        if standard.windows not in archive.namelist():
            pytest.skip("only this machine's library: `cargo suite --all-platforms` has all")
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def numbers(standard: Standard, folder: Path) -> list[str]:
    """Returns the results of the library for Linux on x86-64, on this processor."""
    return run(host(standard, folder, "x86_64-linux-gnu.2.17"), standard, folder, standard.linux)


def host(standard: Standard, folder: Path, target: str) -> list[str | Path]:
    """Builds the host in C, with the zig that linked the library."""
    program = folder / f"host-{target}"
    compiler = [ZIG, "-m", "ziglang", "cc", "-target", target, "-Wall", "-Wextra", "-Werror"]
    build(*compiler, SOURCES / standard.source, "-o", program, "-ldl", "-lm")
    return [program]


def run(
    command: Sequence[str | Path],
    standard: Standard,
    folder: Path,
    library: str,
    **environment: str,
) -> list[str]:
    """Returns one line of bits for each reading of the host."""
    description = read_model_description(str(folder))
    outputs = [v for v in description.modelVariables if v.causality == "output"]
    scalars = [v for v in outputs if v.type == standard.real and not v.dimensions]
    references = [str(v.valueReference) for v in scalars]
    arguments = [folder / library, description.guid, str(STEP), str(STEPS), *references]
    lines = ran([*command, *arguments], env=os.environ | environment).split("\n")[:-1]
    assert len(lines) == standard.rows
    assert all(len(line.split()) == len(references) for line in lines)
    return lines


def test_blows_are_in_the_numbers(numbers: list[str]) -> None:
    """Makes sure that the comparisons below compare something."""
    assert len(set(numbers)) == len(numbers)


@pytest.mark.parametrize("processor", ["qemu64", "Haswell", "max"])
def test_linux64_on_other_processors(
    standard: Standard, folder: Path, numbers: list[str], processor: str
) -> None:
    """From a processor without AVX on: the width of vectors and the functions of glibc differ."""
    emulator = [needs("qemu-x86_64", "qemu-user"), "-cpu", processor]
    program = host(standard, folder, "x86_64-linux-gnu.2.17")
    assert run([*emulator, *program], standard, folder, standard.linux) == numbers


def test_win64_under_wine(
    standard: Standard, folder: Path, numbers: list[str], tmp_path: Path
) -> None:
    wine, compiler = needs("wine", "wine"), "x86_64-w64-mingw32-gcc"
    strict = [needs(compiler, "gcc-mingw-w64-x86-64"), "-Wall", "-Wextra", "-Werror"]
    build(*strict, SOURCES / standard.source, "-o", folder / "host.exe")
    shim = "bcryptprimitives"
    build(*strict, "-shared", SOURCES / f"{shim}.c", "-o", folder / f"{shim}.dll")
    found = run(
        [wine, folder / "host.exe"],
        standard,
        folder,
        standard.windows,
        WINEPREFIX=str(tmp_path),
        WINEDEBUG="-all",
        WINEDLLOVERRIDES="mscoree=;mshtml=",
        DISPLAY="",
    )
    assert found == numbers


@pytest.mark.parametrize("settings", [{}, {"HOST_ROUNDING": "upward"}])
def test_aarch64_under_qemu(
    standard: Standard,
    fmu_path: Path,
    numbers: list[str],
    tmp_path: Path,
    settings: dict[str, str],
) -> None:
    """The library works with any rounding mode of the host, and restores it."""
    emulator = [needs("qemu-aarch64", "qemu-user"), "-L", AARCH64_SYSTEM]
    if not AARCH64_SYSTEM.is_dir():
        pytest.skip("no C library for aarch64: apt install libc6-arm64-cross")
    name, library = standard.aarch64
    with ZipFile(fmu_path.with_name(name)) as archive:
        archive.extractall(tmp_path)
    command = [*emulator, *host(standard, tmp_path, "aarch64-linux-gnu.2.17")]
    assert run(command, standard, tmp_path, library, **settings) == numbers
