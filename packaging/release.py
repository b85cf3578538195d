"""The rest of `cargo ship`: the wheel of this machine, the bill of materials, the hashes.

Takes the .fmu files that `packaging release` has written to dist/release, and what that
says of their contents.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model import HashAlgorithm, HashType
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packageurl import PackageURL
from wheels import here, platform, wheel

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
RELEASE = ROOT / "dist" / "release"
LABORATORY = ROOT / "dist" / "lab" / "index.html"
BILL = "dth-hammer.cdx.json"
SUMS = "SHA256SUMS"


def main() -> None:
    """Makes the wheel of this machine, then tells of all files."""
    fmu = RELEASE / f"dth_hammer-{here()}.fmu"
    if fmu.is_file():
        print(f"{'Wheel':>12} {wheel(fmu, RELEASE).name}")
    else:
        print(f"{'Skipped':>12} the wheel: no {fmu.name}")
    if LABORATORY.is_file():
        shutil.copy(LABORATORY, RELEASE / "dth-hammer-laboratory.html")
    else:
        print(f"{'Skipped':>12} the laboratory: `cargo lab` says what is missing")
    files = sorted(p for p in RELEASE.iterdir() if p.name not in (BILL, SUMS))
    (RELEASE / BILL).write_text(bill(files), encoding="utf-8")
    sums = [f"{digest(path)}  {path.name}\n" for path in [*files, RELEASE / BILL]]
    (RELEASE / SUMS).write_text("".join(sums), encoding="utf-8")
    print(f"{'Wrote':>12} {BILL}, {SUMS}: {len(files)} files")


def bill(files: Iterable[Path]) -> str:
    """All files with their hashes, and for each what it is made of, as CycloneDX 1.6."""
    manifest = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
    version = re.search(r'^version = "(.+)"$', manifest, re.MULTILINE)
    parts = {c["file"]: c["parts"] for c in json.loads((TARGET / "contents.json").read_text())}
    bom = Bom()
    number = version[1] if version else None
    product = Component(name="dth-hammer", version=number, type=ComponentType.LIBRARY)
    bom.metadata.component = product
    known: dict[str, Component] = {}
    members = []
    for path in files:
        member = Component(
            name=path.name,
            type=ComponentType.FILE,
            bom_ref=path.name,
            hashes=[HashType(alg=HashAlgorithm.SHA_256, content=digest(path))],
        )
        bom.components.add(member)
        members.append(member)
        made_of = [component(known, part) for part in parts.get(source(path), [])]
        bom.register_dependency(member, made_of)
    for part in known.values():
        bom.components.add(part)
    bom.register_dependency(product, members)
    text = JsonV1Dot6(bom).output_as_string(indent=2)
    errors = JsonStrictValidator(SchemaVersion.V1_6).validate_str(text)
    if errors is not None:
        sys.exit(f"{BILL} is not CycloneDX 1.6: {errors}")
    return text + "\n"


def source(path: Path) -> str:
    """The .fmu that a file has in it."""
    if path.suffix == ".whl":
        return f"dth_hammer-{platform(path)}.fmu"
    return path.name


def component(known: dict[str, Component], part: dict[str, Any]) -> Component:
    """A crate, or what else is linked; one for each name and version."""
    name, _, version = part["name"].rpartition(" ")
    if not version[:1].isdigit():
        name, version = part["name"], ""
    own = name in ("hammer", "dth-fmu", "dth-native")
    purl = PackageURL("cargo", name=name, version=version) if version and not own else None
    if part["name"] not in known:
        known[part["name"]] = Component(
            name=name,
            version=version or None,
            type=ComponentType.LIBRARY,
            bom_ref=part["name"],
            purl=purl,
            licenses=[LicenseFactory().make_from_string(part["terms"])],
        )
    return known[part["name"]]


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


if __name__ == "__main__":
    main()
