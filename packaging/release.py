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

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from wheels import STANDARD, component, here, platform, wheel

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
RELEASE = ROOT / "dist" / "release"
LABORATORY = ROOT / "dist" / "lab" / "index.html"
BILL = "dth-hammer.cdx.json"
SUMS = "SHA256SUMS"


def main() -> None:
    """Makes the wheel of this machine, then the bill of materials and the hashes of all files."""
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
    """Returns all files with their hashes and components, as CycloneDX 1.6."""
    manifest = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
    version = re.search(r'^version = "(.+)"$', manifest, re.MULTILINE)
    product = {"name": "dth-hammer", "bom-ref": "dth-hammer", "type": "library"}
    parts = {c["file"]: c["parts"] for c in json.loads((TARGET / "contents.json").read_text())}
    members, made_of = [], []
    known: dict[str, dict[str, Any]] = {}
    for path in files:
        hashes = [{"alg": "SHA-256", "content": digest(path)}]
        members.append({"name": path.name, "bom-ref": path.name, "type": "file", "hashes": hashes})
        inside = {part["name"]: part for part in parts.get(source(path), [])}
        known |= {name: component(part) | {"bom-ref": name} for name, part in inside.items()}
        made_of.append({"ref": path.name, "dependsOn": [*inside]})
    made_of.append({"ref": "dth-hammer", "dependsOn": [member["name"] for member in members]})
    bom = {
        **STANDARD,
        "metadata": {"component": product | ({"version": version[1]} if version else {})},
        "components": [*members, *known.values()],
        "dependencies": made_of,
    }
    text = json.dumps(bom, indent=2)
    errors = JsonStrictValidator(SchemaVersion.V1_6).validate_str(text)
    if errors is not None:
        sys.exit(f"{BILL} is not CycloneDX 1.6: {errors}")
    return text + "\n"


def source(path: Path) -> str:
    """Returns the name of the .fmu in a file."""
    if path.suffix == ".whl":
        return f"dth_hammer-{platform(path)}.fmu"
    return path.name


def digest(path: Path) -> str:
    """Returns the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


if __name__ == "__main__":
    main()
