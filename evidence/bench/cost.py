"""What people wait for, by what they do: a page of CPU times and instruction counts.

    cargo bench-report cost

builds what is measured, runs this, and writes `reports/cost.md`. The engine's part is of two
examples of `hammer`, and of the laboratory's library in the node that playwright brings; sweep and
calibration are of the package, in the Python that runs this (the variable PYTHON), if it has it.
CPU time does not count what other programs do meanwhile, but caches are shared with them: the
least of some rounds, in turn, is given. Instructions do not depend on the load: `--counts` prints
them alone. The last line is what the front page reads, as JSON.
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
from pathlib import Path

TARGET = Path(os.environ.get("CARGO_TARGET_DIR", "target"))
EXAMPLES = TARGET / "release" / "examples"
ROUNDS = 3
RUNS = 6

ACTIONS = {
    "a run of 1 s, the same hammer again": [],
    "a run of 1 s, new feed force": ["feed"],
    "a run of 1 s, new rock": ["rock"],
    "two blows, new rock": ["rock", "first=2"],
    "long-run means, new rock": ["rock", "mean"],
    "gradient of a run of 1 s by two, new rock": ["rock", "gradient"],
}
#: Scenes that users run beside the reference, by the words of `runs`.
SCENES = {
    "reference": [],
    "built-in chambers": ["chambers"],
    "air, 4 inch": ["preset=air_4_inch"],
    "6 inch": ["preset=hammer_6_inch"],
    "casing of 40 kg": ["casing.mass=40"],
    "top hammer, four rods": ["preset=top_hammer"],
    "the same, joints loose": ["preset=top_hammer", "drill.joint.stiffness=3e9"],
}
#: What is done in each of them: so many blows from the start.
BLOWS = 4
FIRST = f"first={BLOWS}"
DONE = {"new feed force": ["feed"], "new rock": ["rock"]}
#: Growth over spans of a bar, and over rods on the mesh that a rate needs (17 spans a rod and 5).
SPANS = (8, 16, 32, 64, 128)
RODS = (1, 2, 4, 8)
#: Growth over blows: the same hammer for so many seconds.
SECONDS = (1, 4, 16)
#: In node, by `browser.mjs`, which knows no gradients.
WASM = "wasm in node"
BODIES = {
    "rigid": ["rigid"],
    "16": [],
    "64": ["elements=64"],
    "16, degree 7": ["elements=16", "mesh.degree=7"],
    "20, degree 1": ["elements=20", "mesh.degree=1"],
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
    return timed(lambda n: sweep(grid(n), 1.0, outputs=["hole_depth"], workers=1))

done = {
    "sweep over the feed force": runs("feed_force", 3e3, 9e3),
    "sweep over the rock": runs("rock.stiffness", 1e8, 2e8),
}
begun = spent()
calibrate({"rop": (0.030, 0.0005)}, ["rock.stiffness"])
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


def table(title: str, columns: dict[str, list[str]]) -> None:
    """Actions by columns, in milliseconds."""
    print(f"\n## {title}\n")
    print("| ms | " + " | ".join(columns) + " |")
    print("|---|" + "---:|" * len(columns))
    cases = [action + more for action in ACTIONS.values() for more in columns.values()]
    times = iter(measured(cases))
    for action in ACTIONS:
        row = [next(times) for _ in columns]
        print(f"| {action} | " + " | ".join(f"{t:.2f}" if t < math.inf else "" for t in row) + " |")


def count(words: list[str]) -> float:
    """Millions of instructions of a run beyond the first, in AVX2, by valgrind."""
    command = [str(EXAMPLES / "runs"), "count", "AVX2", *words]
    done = subprocess.run(command, capture_output=True, check=True, text=True)
    return 1e-6 * int(done.stdout)


def blows_and_events(words: list[str]) -> list[int]:
    """What the example says of one run."""
    done = subprocess.run(run(1, words), capture_output=True, check=True, text=True)
    return [int(word) for word in done.stdout.split()[-2:]]


def growth(scenes: dict[str, list[float]]) -> None:
    """Prints how instructions grow with blows, and what an event takes in each scene."""
    print("\n## Growth over blows, reference, new feed force (AVX2)\n")
    print("| seconds | blows | millions | a blow |\n|---|---:|---:|---:|")
    for seconds in SECONDS:
        words = ["feed", f"seconds={seconds}"]
        blows, whole = blows_and_events(words)[0], count(words)
        print(f"| {seconds} | {blows} | {whole:.1f} | {whole / blows:.2f} |", flush=True)
    print(
        "\nEach in one step. What works, losses and peaks follow from is stored for some 120 blows;"
    )
    print("beyond that they are integrated on the way, whether anybody reads them or not.")
    print(
        f"\n## Growth over events, {BLOWS} blows with a new feed force, by rising number (AVX2)\n"
    )
    print("| scene | events | millions | a thousand events |\n|---|---:|---:|---:|")
    table = []
    for name, scene in SCENES.items():
        table.append((blows_and_events([*scene, "feed", FIRST])[1], name, scenes[name][0]))
    for events, name, whole in sorted(table):
        print(f"| {name} | {events} | {whole:.1f} | {1e3 * whole / events:.1f} |")


def rows(title: str, head: list[str], cells: dict[str, list[list[str]]]) -> dict[str, list[float]]:
    """Prints a table of counts, row by row, and returns it."""
    print(f"\n## {title}\n\n| " + " | ".join(head) + " |\n|---|" + "---:|" * (len(head) - 1))
    table = {}
    for name, row in cells.items():
        table[name] = [count(words) for words in row]
        print(f"| {name} | " + " | ".join(f"{x:.1f}" for x in table[name]) + " |", flush=True)
    return table


def counts() -> dict[str, dict[str, list[float]]]:
    """Instructions of each action and scene, and how they grow."""
    tables = {
        "actions": rows(
            "Instructions, in millions (16 spans of degree 3 per bar, AVX2)",
            ["reference", "millions"],
            {action: [words] for action, words in ACTIONS.items()},
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
            {str(n): [[f"elements={n}", *do] for do in DONE.values()] for n in SPANS},
        ),
        "rods": rows(
            f"Growth over rods of a top hammer, {BLOWS} blows, new feed force, in millions (AVX2)",
            ["rods", "tight", "loose"],
            {str(n): [string(n), [*string(n), "drill.joint.stiffness=3e9"]] for n in RODS},
        ),
    }
    growth(tables["scenes"])
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


def from_python() -> None:
    """The package on one thread, if this Python has it."""
    if importlib.util.find_spec("dth_hammer") is None:
        return
    print("\n## From Python, on one thread\n")
    print("With the native module that this Python has.\n")
    print("| | CPU ms | a second and core |\n|---|---:|---:|")
    rounds = []
    for _ in range(ROUNDS):
        done = subprocess.run([sys.executable, "-c", PYTHON], check=True, capture_output=True)
        rounds.append(json.loads(done.stdout.splitlines()[-1]))
    for name in rounds[0]:
        least = min(done[name] for done in rounds)
        print(f"| {name} | {1e3 * least:.2f} | {1 / least:.1f} |")


def main() -> None:
    """Measures and prints."""
    if sys.argv[1:] == ["--counts"]:
        counts()
        return
    if sys.argv[1:] == ["--short"]:
        table("By spans per bar, of degree 3 if not said", {"16": []})
        print(json.dumps({}))
        return
    text = Path("/proc/cpuinfo").read_text() if platform.system() == "Linux" else ""
    names = [line.split(":")[1].strip() for line in text.splitlines() if "model name" in line]
    kinds = vectors()
    print("# Cost by what people do: `cargo bench-report cost`\n")
    print(
        f"{names[0] if names else platform.processor()}, {os.cpu_count()} cores, CPU time of one "
        f"thread; the least of {ROUNDS} rounds in turn, each the mean of {RUNS} runs beyond the "
        f"first. Each new rock is one that the process has not seen. The load of the machine was "
        f"{os.getloadavg()[1]:.0f} at the start."
    )
    table(f"By spans per bar, of degree 3 if not said ({kinds[0]})", BODIES)
    kinds += [WASM] if node() else []
    table(
        "By the processor's vectors (16 spans of degree 3 per bar)",
        {kind: [kind] for kind in kinds},
    )
    if WASM in kinds:
        print(
            "\nNode goes on compiling while the first runs are under way; that is in its numbers."
        )
    tables = counts() if shutil.which("valgrind") else {}
    from_python()
    print("\n## A thousand hammers side by side\n")
    command = [str(EXAMPLES / "fleet"), "1000"]
    print(subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip())
    if shutil.which("valgrind"):
        command = [str(EXAMPLES / "fleet"), "count"]
        fleet = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        print("\nThe hammers in turn integrate works and losses, because there is no room to store")
        print("what they follow from; those one after another leave it until somebody asks.\n")
        print("".join(f"- {line}\n" for line in fleet.splitlines()), end="")
    processor = names[0] if names else platform.processor()
    named = f"{processor}, {kinds[0]} vectors"
    print(json.dumps({"processor": named, "blows": BLOWS, "counts": tables}))


if __name__ == "__main__":
    main()
