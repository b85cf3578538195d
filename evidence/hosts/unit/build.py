"""Builds the four archives, of two units and two standards, to the same bytes wherever it runs.

    pip install ziglang==0.15.2 fmpy==0.3.32
    python build.py            # beside this file
    python build.py FOLDER

zig is the compiler, fmpy has the standards' headers. Each archive has one library, for Linux on
x86-64 with glibc 2.17 or newer; `--target TRIPLE PLATFORM` builds another, such as `aarch64-macos
aarch64-darwin`.
Entries are stored, not compressed, so that no version of a compressor shows.
"""

from __future__ import annotations

import argparse
import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path
from zipfile import ZIP_STORED, ZipFile, ZipInfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from score import SCENES, input_rows, instant_rows

HERE = Path(__file__).resolve().parent
SOURCES = ("unit.c", "none.c")
#: That has zig.
PYTHON = sys.executable
#: Of each unit: its variables as name, value reference, causality and unit.
UNITS = {
    "thrown": [
        ("relative_position", 1, "output", "m"),
        ("velocity", 2, "output", "m/s"),
        ("acceleration", 3, "input", "m/s2"),
    ],
    "valve": [
        ("relative_position", 1, "input", "m"),
        ("acceleration", 3, "output", "m/s2"),
    ],
}
STARTS = {"relative_position": "-0.001", "acceleration": "800.0"}
EXPONENTS = {"m": 'm="1"', "m/s": 'm="1" s="-1"', "m/s2": 'm="1" s="-2"'}
#: As that layered standard has it, word for word.
MEANING = "Layered Standard providing information on related files included in an FMU."
EXTRA = "extra/org.fmi-standard.fmi-ls-ref"


def description(unit: str, fmi: int) -> str:
    """The model description, in the words of each standard."""
    three = fmi == 3
    variables = UNITS[unit]
    token = f'{"instantiationToken" if three else "guid"}="{unit}"'
    base = "BaseUnit"
    units = "".join(
        f'    <Unit name="{name}"><{base} {EXPONENTS[name]}/></Unit>\n'
        for name in sorted({row[3] for row in variables})
    )
    lines, outputs = [], []
    for index, (name, reference, causality, of) in enumerate(variables, 1):
        more = f'causality="{causality}" variability="continuous"'
        kind = f'unit="{of}"' + (f' start="{STARTS[name]}"' if causality == "input" else "")
        head = f'name="{name}" valueReference="{reference}" {more}'
        if three:
            lines.append(f"    <Float64 {head} {kind}/>\n")
        else:
            real = f"<Real {kind}/>"
            initial = ' initial="calculated"' if causality == "output" else ""
            lines.append(f"    <ScalarVariable {head}{initial}>{real}</ScalarVariable>\n")
        if causality == "output":
            # The valve's output follows its input at once; the piston's does not.
            known = 1 if unit == "valve" else ""
            place = f'valueReference="{reference}"' if three else f'index="{index}"'
            outputs.append((place, f'dependencies="{known}"'))
    if three:
        lines.insert(
            0,
            '    <Float64 name="time" valueReference="0" causality="independent" '
            'variability="continuous"/>\n',
        )
    tag = ("Output", "InitialUnknown") if three else ("Unknown", "Unknown")
    outputs_xml = "".join(f"    <{tag[0]} {place} {known}/>\n" for place, known in outputs)
    first = "".join(f"    <{tag[1]} {place} {known}/>\n" for place, known in outputs)
    state = "FMUState" if three else "FMUstate"
    can = (
        f'modelIdentifier="{unit}" canHandleVariableCommunicationStepSize="true" '
        f'canGetAndSet{state}="true" canSerialize{state}="true"'
    )
    if three:
        can += ' hasEventMode="true" mightReturnEarlyFromDoStep="true"' if unit == "thrown" else ""
        can += ' hasEventMode="true"' if unit == "valve" else ""
        structure = outputs_xml + first
    else:
        structure = (
            f"    <Outputs>\n{outputs_xml}    </Outputs>\n"
            f"    <InitialUnknowns>\n{first}    </InitialUnknowns>\n"
        )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{fmi}.0" modelName="{unit}" {token}
  description="A unit whose events have closed forms" license="MIT OR Apache-2.0">
  <CoSimulation {can}/>
  <UnitDefinitions>
{units}  </UnitDefinitions>
  <DefaultExperiment startTime="0.0" stopTime="0.021" stepSize="0.001"/>
  <ModelVariables>
{"".join(lines)}  </ModelVariables>
  <ModelStructure>
{structure}  </ModelStructure>
</fmiModelDescription>
"""


def related() -> dict[str, str]:
    """What a host's rows are to be compared with, by the layered standard FMI-LS-REF."""
    files = {f"{scene}.csv": ("result", instant_rows(scene)) for scene in SCENES}
    files["changed_input.csv"] = ("testcase", input_rows())
    rows = "".join(
        f'  <Related type="text/csv" source="{name}" role="{role}"/>\n'
        for name, (role, _) in files.items()
    )
    manifest = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref"
  fmi-ls:fmi-ls-version="1.0.0-alpha.1"
  fmi-ls:fmi-ls-description="{MEANING}">
{rows}</fmiReferences>
"""
    return {"fmi-ls-manifest.xml": manifest} | {name: text for name, (_, text) in files.items()}


def library(target: str) -> bytes:
    found = importlib.util.find_spec("fmpy")
    if found is None or found.origin is None:
        raise SystemExit("fmpy has the standards' headers: pip install fmpy")
    headers = Path(found.origin).with_name("c-code")
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "unit.bin"
        # No fused multiplication: all platforms round alike. No path and no identity of the build.
        options = "-std=c17 -O2 -s -shared -fno-math-errno -ffp-contract=off -Wl,--build-id=none"
        if "macos" in target or "windows" in target:
            options = options.replace(" -Wl,--build-id=none", "")
        command = [PYTHON, "-m", "ziglang", "cc", "-target", target, *options.split()]
        command += ["-Wno-deprecated-non-prototype", f"-I{headers}", *SOURCES, "-o", str(place)]
        subprocess.run(command, cwd=HERE, check=True)
        return place.read_bytes()


def write(folder: Path, target: str, platform: str) -> None:
    code = library(target)
    suffix = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}[platform.split("-")[1]]
    two = {"windows": "win64", "linux": "linux64", "darwin": "darwin64"}[platform.split("-")[1]]
    for unit in UNITS:
        for fmi, place in ((2, two), (3, platform)):
            entries: dict[str, str | bytes] = {"modelDescription.xml": description(unit, fmi)}
            entries[f"binaries/{place}/{unit}{suffix}"] = code
            if unit == "thrown":
                entries |= {f"{EXTRA}/{name}": text for name, text in related().items()}
            with ZipFile(folder / f"{unit}_fmi{fmi}.fmu", "w", ZIP_STORED) as archive:
                for name, data in entries.items():
                    archive.writestr(ZipInfo(name), data)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", default=HERE)
    parser.add_argument("--target", nargs=2, default=["x86_64-linux-gnu.2.17", "x86_64-linux"])
    options = parser.parse_args()
    write(options.folder, *options.target)


if __name__ == "__main__":
    main()
