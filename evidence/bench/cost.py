"""What people wait for, by what they do: a page of CPU times and instruction counts.

    cargo bench-report cost

builds what is measured, runs this in the project's Python, and writes `reports/cost.md`, all of
which is printed here. The engine's part is of two examples of `hammer`, and of the laboratory's
library in the node that playwright brings; sweep and calibration are of the package. CPU time does
not count what other programs do meanwhile, but caches are shared with them: the least of some
rounds, in turn, is taken, and told as a ratio to another of the same rounds. Instructions, counted
by valgrind if it is there, do not depend on the load: `--counts` prints them alone. The last line
is what the front page reads, as JSON.
"""

from __future__ import annotations

import importlib.util
import json
import math
import os
import platform
import resource
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TARGET = Path(os.environ.get("CARGO_TARGET_DIR", "target"))
EXAMPLES = TARGET / "release" / "examples"
ROUNDS = 3
RUNS = 6

#: What times are told in.
UNIT = "a run of 1 s, new feed force"
ACTIONS = {
    "a run of 1 s, the same hammer again": [],
    UNIT: ["feed"],
    "a run of 1 s, new rock": ["rock"],
    "two blows, new rock": ["rock", "first=2"],
    "long-run means, new rock": ["rock", "mean"],
    "gradient of a run of 1 s by two, new rock": ["rock", "gradient"],
}
#: Scenes that users run beside the reference, by the words of `runs`.
SCENES = {
    "reference": [],
    "air, reference": ["drive.source=3"],
    "air, rigid": ["drive.source=3", "rigid"],
    "air, 4 inch": ["preset=air_4_inch"],
    "water": ["preset=water_hammer"],
    "casing of 40 kg": ["casing.mass=40"],
    "top hammer, four rods": ["preset=top_hammer"],
    "the same, joints loose": ["preset=top_hammer", "drill.joint.stiffness=3e9"],
}
#: What is done in each of them: so many blows from the start.
BLOWS = 4
FIRST = f"first={BLOWS}"
#: Up to which blow a run goes on where only what is beyond those counts, and what is read each ms.
LATER = 24
LAST = 64
READ = {
    f"to blow {LATER}": [f"first={LATER}"],
    "energies each ms": [f"first={LATER}", "energies"],
    "all outputs each ms": [f"first={LATER}", "outputs"],
    f"to blow {LAST}": [f"first={LAST}"],
}
DONE = {"new feed force": ["feed"], "new rock": ["rock"]}
#: Growth over spans of a bar, and over rods on the mesh that a rate needs (17 spans a rod and 5).
SPANS = (8, 16, 32, 64, 128)
RODS = (1, 2, 4, 8)
#: In node, by `browser.mjs`, which knows no gradients.
WASM = "wasm in node"


def mesh(spans: int, degree: int = 3) -> list[str]:
    """The words of bars on so many spans each."""
    return [f"elements={spans}", f"mesh.degree={degree}"]


USUAL = mesh(16)
BODIES = {
    "16": USUAL,
    "rigid": ["rigid"],
    "64": mesh(64),
    "16, degree 7": mesh(16, 7),
    "20, degree 1": mesh(20, 1),
}

PYTHON = """
import json, resource, sys
import numpy as np
from dth_hammer import calibrate, sweep

def spent():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime

def timed(work):
    work(2)
    begun = spent()
    work(60)
    return (spent() - begun) / 60

def runs(name, low, high):
    grid = lambda n: {name: np.linspace(low, high, n)}
    return timed(lambda n: sweep(grid(n), 1.0, outputs=["tip_depth"], workers=1))

done = {
    "sweep over the feed force": runs("feed_force", 3e3, 9e3),
    "sweep over the rock": runs("rock.stiffness", 1e8, 2e8),
}
begun = spent()
calibrate("reference", {"rop": (0.030, 0.0005)}, ["rock.stiffness"])
done["calibrate: one parameter from one mean"] = spent() - begun
print(json.dumps(done))
"""


def cpu(words: list[str]) -> float:
    """CPU seconds of a program and its children."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def node() -> list[str]:
    """The command that runs the laboratory's library, if it and node are there."""
    folders = [TARGET / "cross", TARGET]
    files = [f / "wasm32-unknown-unknown" / "fmu" / "dth_hammer.wasm" for f in folders]
    found = importlib.util.find_spec("playwright")
    if found is None or found.origin is None or not any(file.exists() for file in files):
        return []
    program = Path(found.origin).parent / "driver" / "node"
    script = Path(__file__).with_name("browser.mjs")
    return [str(program), str(script), *(str(file) for file in files if file.exists())][:3]


def run(count: int, words: list[str]) -> list[str]:
    if WASM in words:
        return [*node(), str(count), *(word for word in words if word != WASM)]
    return [str(EXAMPLES / "runs"), str(count), *words]


def measured(cases: list[list[str]]) -> list[float]:
    """Milliseconds of a run beyond the first of each case: the least of the rounds."""
    least = [math.inf] * len(cases)
    for _ in range(ROUNDS):
        for k, words in enumerate(cases):
            if WASM in words and "gradient" in words:
                continue
            took = cpu(run(RUNS + 1, words)) - cpu(run(1, words))
            least[k] = min(least[k], 1e3 * took / RUNS)
    return least


def vectors() -> list[str]:
    """Kinds of vectors of this processor."""
    known = []
    for name in ("AVX-512", "AVX2", "scalar"):
        done = subprocess.run(run(1, ["rigid", name]), capture_output=True, check=False)
        known += [name] if done.returncode == 0 else []
    return known


def table(title: str, rows: dict[str, list[str]], columns: dict[str, list[str]]) -> float:
    """Prints rows by columns, in the time of the unit's row in the first column; returns it."""
    cases = [row + more for row in rows.values() for more in columns.values()]
    times = measured(cases)
    unit = times[list(rows).index(UNIT) * len(columns)] if UNIT in rows else times[0]
    print(f"\n## {title}\n")
    print(f"| 1 is {unit:.2f} ms | " + " | ".join(columns) + " |")
    print("|---|" + "---:|" * len(columns))
    for k, name in enumerate(rows):
        row = times[k * len(columns) :][: len(columns)]
        cells = (f"{time / unit:.2f}" if time < math.inf else "" for time in row)
        print(f"| {name} | " + " | ".join(cells) + " |")
    return unit


def instructions(words: list[str]) -> float:
    """Millions of instructions of a run beyond the first, in AVX2, by valgrind."""
    command = [str(EXAMPLES / "runs"), "count", "AVX2", *words]
    done = subprocess.run(command, capture_output=True, check=True, text=True)
    return 1e-6 * int(done.stdout)


def count(cases: list[list[str]]) -> list[float]:
    """The same of many, on all cores: other programs do not change a count."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(instructions, cases))


def later() -> None:
    """Prints what a blow takes once the hammer has begun."""
    # What is new in the second of two runs of another length is the rest of the longer one.
    print(f"\n## A blow after the first {BLOWS}, in steps of 1 ms, in millions (AVX2)\n")
    print("| scene | " + " | ".join(READ) + " |\n|---|" + "---:|" * len(READ))
    starts = [[*scene, "feed"] for scene in SCENES.values()]
    whole = count([[*words, *read] for words in starts for read in READ.values()])
    first = count([[*words, *read[1:], FIRST] for words in starts for read in READ.values()])
    blows = [int(read[0].removeprefix("first=")) - BLOWS for read in READ.values()]
    for k, name in enumerate(SCENES):
        row = slice(k * len(READ), (k + 1) * len(READ))
        each = zip(whole[row], first[row], blows, strict=True)
        print(f"| {name} | " + " | ".join(f"{(a - b) / n:.2f}" for a, b, n in each) + " |")


def rows(title: str, head: list[str], cells: dict[str, list[list[str]]]) -> dict[str, list[float]]:
    """Prints a table of counts, and returns it."""
    print(f"\n## {title}\n\n| " + " | ".join(head) + " |\n|---|" + "---:|" * (len(head) - 1))
    counted = iter(count([words for row in cells.values() for words in row]))
    numbers = {name: [next(counted) for _ in row] for name, row in cells.items()}
    for name, row in numbers.items():
        print(f"| {name} | " + " | ".join(f"{x:.1f}" for x in row) + " |")
    return numbers


def counts() -> dict[str, dict[str, list[float]]]:
    """Instructions of each action and scene, and how they grow."""
    tables = {
        "actions": rows(
            "Instructions, in millions (16 spans of degree 3 per bar, AVX2)",
            ["reference", "millions"],
            {action: [[*USUAL, *words]] for action, words in ACTIONS.items()},
        ),
        "scenes": rows(
            f"Instructions of the first {BLOWS} blows of what users run, in millions (AVX2)",
            ["scene", *DONE],
            {
                name: [[*words, *do, FIRST] for do in DONE.values()]
                for name, words in SCENES.items()
            },
        ),
        "spans": rows(
            "Growth over spans of degree 3 per bar, reference, in millions (AVX2)",
            ["spans", "1 s, new feed force", "1 s, new rock"],
            {str(n): [[*mesh(n), *do] for do in DONE.values()] for n in SPANS},
        ),
        "rods": rows(
            f"Growth over rods of a top hammer, {BLOWS} blows, new feed force, in millions (AVX2)",
            ["rods", "tight", "loose"],
            {str(n): [string(n), [*string(n), "drill.joint.stiffness=3e9"]] for n in RODS},
        ),
    }
    later()
    return tables


def string(rods: int) -> list[str]:
    """The words of a top hammer with so many rods."""
    return [
        "preset=top_hammer",
        "feed",
        FIRST,
        f"drill.rods={rods}",
        f"bit.elements={17 * rods + 5}",
    ]


def from_python(unit: float) -> None:
    """The package on one thread, in the unit of so many ms, if this Python has it."""
    if importlib.util.find_spec("dth_hammer") is None:
        return
    rounds = []
    for _ in range(ROUNDS):
        done = subprocess.run([sys.executable, "-c", PYTHON], check=True, capture_output=True)
        rounds.append(json.loads(done.stdout.splitlines()[-1]))
    print("\n## From Python, on one thread\n")
    print(f"| 1 is {unit:.2f} ms | |\n|---|---:|")
    for name in rounds[0]:
        print(f"| {name} | {1e3 * min(done[name] for done in rounds) / unit:.2f} |")


def fleet(counted: bool) -> None:
    """Many hammers in one process."""

    def answer(word: str) -> str:
        words = [str(EXAMPLES / "fleet"), word]
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()

    print(f"\n## A thousand hammers side by side\n\n{answer('1000')}\n")
    print("The hammers in turn integrate works and losses, because there is no room to store")
    print("what they follow from; those one after another leave it until somebody asks.")
    if counted:
        print("\n" + "\n".join(f"- {line}" for line in answer("count").splitlines()))


def processor() -> str:
    """Its name."""
    text = Path("/proc/cpuinfo").read_text() if platform.system() == "Linux" else ""
    names = [line.split(":")[1].strip() for line in text.splitlines() if "model name" in line]
    return names[0] if names else platform.processor()


def main() -> None:
    """Measures and prints."""
    if sys.argv[1:] == ["--counts"]:
        counts()
        return
    kinds, counted = vectors(), shutil.which("valgrind") is not None
    print("# Cost by what people do: `cargo bench-report cost`\n")
    print(
        f"{processor()}, {os.cpu_count()} cores, {kinds[0]} vectors if not said. Times are CPU "
        f"times of one thread, the least of {ROUNDS} rounds in turn, each the mean of {RUNS} runs "
        "beyond the first, told as ratios; what 1 is stands in each table. Each new rock is one "
        "that the process has not seen. Instructions are those of a process's second run, by "
        f"callgrind. The load of the machine was {os.getloadavg()[1]:.0f} at the start."
    )
    unit = table("By spans per bar, of degree 3 if not said", ACTIONS, BODIES)
    kinds += [WASM] if node() else []
    by_kind = {kind: [*USUAL, kind] for kind in kinds}
    table("By the processor's vectors (16 spans of degree 3 per bar)", ACTIONS, by_kind)
    if WASM in kinds:
        print(
            "\nNode goes on compiling while the first runs are under way; that is in its numbers."
        )
    tables = counts() if counted else {}
    from_python(unit)
    fleet(counted)
    named = f"{processor()}, {kinds[0]} vectors"
    print(json.dumps({"processor": named, "blows": BLOWS, "counts": tables}))


if __name__ == "__main__":
    main()
