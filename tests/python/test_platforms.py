"""The libraries for other machines, each run by a small host in C: the same bits on all.

They are there after `cargo suite --all-platforms`; otherwise all is skipped.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from zipfile import ZipFile

import pytest
from fmpy import read_model_description

SOURCES = Path(__file__).parents[1] / "platforms"
ZIG = Path(sys.prefix).with_name("venv-cross") / "bin" / "python"
# Where Debian's libc6-arm64-cross puts the system that a program on aarch64 loads.
AARCH64_SYSTEM = Path("/usr/aarch64-linux-gnu")
# Two blows of the reference hammer.
STEP, STEPS = 1e-3, 100


def needs(program: str, package: str) -> str:
    path = shutil.which(program)
    if path is None:
        pytest.skip(f"{program} is not installed: apt install {package}")
    return path


def build(*command: str | Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr, done.stderr


@pytest.fixture(scope="module")
def linux(fmu_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the file for x86-64, and its host."""
    folder = tmp_path_factory.mktemp("platforms")
    with ZipFile(fmu_path) as archive:
        if "binaries/win64/dth_hammer.dll" not in archive.namelist():
            pytest.skip("only this machine's library: `cargo suite --all-platforms` has all")
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def numbers(linux: Path, fmu_path: Path) -> list[str]:
    """What linux64 says, on this processor."""
    return run(host(linux, "x86_64-linux-gnu.2.17"), linux, fmu_path)


def host(folder: Path, target: str) -> list[str | Path]:
    """The host in C, by the zig that linked the library."""
    program = folder / f"host-{target}"
    compiler = [ZIG, "-m", "ziglang", "cc", "-target", target, "-Wall", "-Wextra", "-Werror"]
    build(*compiler, SOURCES / "host.c", "-o", program, "-ldl", "-lm")
    return [program]


def run(
    command: Sequence[str | Path],
    folder: Path,
    fmu: Path,
    library: str = "binaries/linux64/dth_hammer.so",
    **environment: str,
) -> list[str]:
    """One line of bits for each communication point."""
    description = read_model_description(str(fmu))
    outputs = [v for v in description.modelVariables if v.causality == "output"]
    references = [str(v.valueReference) for v in outputs if v.type == "Real"]
    arguments = [folder / library, description.guid, str(STEP), str(STEPS), *references]
    done = subprocess.run(
        [*command, *arguments],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | environment,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.split("\n")[:-1]
    assert len(lines) == STEPS + 1
    assert all(len(line.split()) == len(references) for line in lines)
    return lines


def test_two_blows_are_in_the_numbers(numbers: list[str], fmu_path: Path) -> None:
    """The comparisons below are of something."""
    assert len(set(numbers)) == len(numbers)


@pytest.mark.parametrize("processor", ["qemu64", "Haswell", "max"])
def test_linux64_on_other_processors(
    linux: Path, fmu_path: Path, numbers: list[str], processor: str
) -> None:
    """From one without AVX on: the vectors' widths differ, and glibc's ways."""
    emulator = [needs("qemu-x86_64", "qemu-user"), "-cpu", processor]
    assert run([*emulator, *host(linux, "x86_64-linux-gnu.2.17")], linux, fmu_path) == numbers


def test_win64_under_wine(linux: Path, fmu_path: Path, numbers: list[str], tmp_path: Path) -> None:
    wine, compiler = needs("wine", "wine"), "x86_64-w64-mingw32-gcc"
    strict = [needs(compiler, "gcc-mingw-w64-x86-64"), "-Wall", "-Wextra", "-Werror"]
    build(*strict, SOURCES / "host.c", "-o", linux / "host.exe")
    shim = "bcryptprimitives"
    build(*strict, "-shared", SOURCES / f"{shim}.c", "-o", linux / f"{shim}.dll")
    found = run(
        [wine, linux / "host.exe"],
        linux,
        fmu_path,
        "binaries/win64/dth_hammer.dll",
        WINEPREFIX=str(tmp_path),
        WINEDEBUG="-all",
        WINEDLLOVERRIDES="mscoree=;mshtml=",
        DISPLAY="",
    )
    assert found == numbers


@pytest.mark.parametrize("settings", [{}, {"HOST_ROUNDING": "upward"}])
def test_aarch64_under_qemu(
    linux: Path, fmu_path: Path, numbers: list[str], tmp_path: Path, settings: dict[str, str]
) -> None:
    """Whatever the host's rounding is, which it gets back."""
    emulator = [needs("qemu-aarch64", "qemu-user"), "-L", AARCH64_SYSTEM]
    if not AARCH64_SYSTEM.is_dir():
        pytest.skip("no C library for aarch64: apt install libc6-arm64-cross")
    with ZipFile(fmu_path.with_name("dth_hammer-aarch64.fmu")) as archive:
        archive.extractall(tmp_path)
    command = [*emulator, *host(tmp_path, "aarch64-linux-gnu.2.17")]
    assert run(command, tmp_path, fmu_path, **settings) == numbers
