"""The files of a release: each is what its name says, and the first of them draws a figure.

But for the first figure all is of `cargo ship`, and skipped where that has not been run.
"""

from __future__ import annotations

import hashlib
import json
import re
import struct
import subprocess
import sys
import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from PIL import Image

ROOT = Path(__file__).parents[2]
RELEASE = ROOT / "dist" / "release"
sys.path.insert(0, str(ROOT / "packaging"))

from first_figure import first_figure  # noqa: E402
from wheels import TAGS, here, platform, wheel  # noqa: E402

# Numbers of processors in a library: ELF's e_machine, PE's Machine.
ELF = {62: "x86_64", 183: "aarch64"}
PE = {0x8664: "x86_64"}


def processor(library: bytes) -> str:
    if library[:4] == b"\x7fELF":
        return "linux-" + ELF[struct.unpack_from("<H", library, 18)[0]]
    if library[:2] == b"MZ":
        place = struct.unpack_from("<I", library, 60)[0]
        return "windows-" + PE[struct.unpack_from("<H", library, place + 4)[0]]
    assert library[:4] == b"\xca\xfe\xba\xbe"
    return "macos-universal2"


def libraries(fmu: bytes) -> dict[str, str]:
    """Returns processors by the paths of their libraries."""
    with zipfile.ZipFile(BytesIO(fmu)) as archive:
        names = [n for n in archive.namelist() if n.startswith("binaries/")]
        return {name: processor(archive.read(name)) for name in names}


@pytest.fixture(scope="module")
def release() -> Path:
    if not (RELEASE / "SHA256SUMS").is_file():
        pytest.skip("dist/release is not built: `cargo ship` makes it")
    return RELEASE


@pytest.mark.weekly  # pip fetches 150 MB
def test_a_newcomer_draws_the_first_figure(fmu_path: Path, tmp_path: Path) -> None:
    """A clean environment without a compiler: pip chooses the wheel, `demo` draws."""
    assert platform(wheel(fmu_path, tmp_path, "native")) == here()
    fetch = [sys.executable, "-m", "pip", "download", "--no-deps", "--dest", tmp_path / "reach"]
    probe = subprocess.run([*fetch, "tqdm"], capture_output=True, text=True, check=False)
    if "NewConnectionError" in probe.stderr:
        pytest.skip("no package index can be reached: the wheel's dependencies come from one")
    said = first_figure(tmp_path, tmp_path / "first.png")
    assert "frequency               21.92 Hz" in said
    assert re.search(r"^.*energy.* 227(\.\d+)? J", said, re.MULTILINE), said
    pixels = np.asarray(Image.open(tmp_path / "first.png").convert("L"), dtype=float)
    assert min(pixels.shape) > 1000
    assert 0.01 < (pixels < 128).mean() < 0.3


@pytest.mark.parametrize("name", TAGS)
def test_each_platform_has_its_own(release: Path, fmu_path: Path, name: str) -> None:
    fmu = release / f"dth_hammer-{name}.fmu"
    if not fmu.is_file():
        pytest.skip(f"no {fmu.name}: another machine builds that")
    assert list(libraries(fmu.read_bytes()).values()) == [name]
    guid = read_model_description(str(fmu_path)).guid
    assert read_model_description(str(fmu)).guid == guid
    if name != here():
        pytest.skip(f"the wheel for {name} is made there")
    (path,) = release.glob("dth_hammer-*-cp310-abi3-*.whl")
    with zipfile.ZipFile(path) as archive:
        for ending in (".fmu", "_fmi3.fmu"):
            packed = archive.read(f"dth_hammer/data/dth_hammer{ending}")
            assert packed == fmu.with_name(fmu.stem + ending).read_bytes()
        (native,) = (n for n in archive.namelist() if n.endswith((".so", ".pyd")))
        assert processor(archive.read(native)) == name
        assert archive.testzip() is None


def test_one_fmu_is_for_all_that_can_share_a_file(release: Path) -> None:
    apart = {"linux-aarch64"}  # FMI 2.0 has no folder for it
    built = {p for p in TAGS if (release / f"dth_hammer-{p}.fmu").is_file()}
    found = libraries((release / "dth_hammer.fmu").read_bytes())
    assert set(found.values()) == built - apart
    for one in built - apart:
        (name,) = (n for n, p in found.items() if p == one)
        own = zipfile.ZipFile(release / f"dth_hammer-{one}.fmu").read(name)
        assert zipfile.ZipFile(release / "dth_hammer.fmu").read(name) == own


def test_one_fmu_of_fmi_3_is_for_every_platform(release: Path) -> None:
    built = {p for p in TAGS if (release / f"dth_hammer-{p}.fmu").is_file()}
    found = libraries((release / "dth_hammer_fmi3.fmu").read_bytes())
    assert set(found.values()) == built
    for one in built:
        own = libraries((release / f"dth_hammer-{one}_fmi3.fmu").read_bytes())
        assert set(own) == {name for name, platform in found.items() if platform == one}


def test_every_file_has_its_hash(release: Path) -> None:
    lines = (release / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    sums = {name: digest for digest, name in (line.split("  ") for line in lines)}
    files = {p.name: p for p in release.iterdir() if p.name != "SHA256SUMS"}
    assert set(sums) == set(files)
    for name, path in files.items():
        assert hashlib.sha256(path.read_bytes()).hexdigest() == sums[name]


def test_the_bill_of_materials_names_what_is_linked(release: Path) -> None:
    bill = json.loads((release / "dth-hammer.cdx.json").read_text(encoding="utf-8"))
    assert (bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.6")
    parts = {c["bom-ref"]: c for c in bill["components"]}
    made_of = {d["ref"]: d.get("dependsOn", []) for d in bill["dependencies"]}
    for path in release.glob("*.fmu"):
        assert (
            hashlib.sha256(path.read_bytes()).hexdigest()
            == parts[path.name]["hashes"][0]["content"]
        )
        licences = zipfile.ZipFile(path).read("documentation/licenses/license.txt").decode()
        listed = {line.split(": ")[0] for line in licences.split("\n\n")[0].splitlines()}
        assert listed == set(made_of[path.name])
        names = {parts[ref]["name"] for ref in made_of[path.name]}
        assert {"dth-hammer", "libm", "nalgebra", "postcard"} <= names
        # Crates that only tests, the build script and procedural macros use are in no library.
        assert not names & {"rand", "libloading", "quick-xml", "serde_json", "serde_derive", "syn"}
    crates = [c for c in bill["components"] if c.get("purl", "").startswith("pkg:cargo/")]
    assert all(c["version"] and c["licenses"] for c in crates)
