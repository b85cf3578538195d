"""What a sweep of the Python package takes beyond its engine: docs/sweep-cost.{md,json}.

    cargo fmu
    cargo build --profile fmu -p bench --bin sweep-engine
    python evidence/bench/sweep_cost.py                 # in the environment of `cargo suite`

Round by round in turn: the runs by the engine alone (`sweep-engine`, a Rust program), and by
`dth_hammer.sweep`; on as many threads, with the same outputs, whose numbers must be the same to
the last bit. With --runs or --rounds the report is printed only.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RUNS, ROUNDS, THREADS, UNTIL = 1000, 5, 2, 1.0
FEEDS = (3e3, 9e3)
#: What runs of a scene share beside the feed force, which differs from run to run.
SCENES = {
    "20 elements per bar": {},
    "5 elements per bar": {"piston.elements": 5, "bit.elements": 5},
    "rigid bodies": {"fidelity": 1},
}
#: Most that a sweep by threads may take of the engine's own time.
GOAL = 1.2
#: Runs under callgrind.
COUNTED = 20
#: How it is swept: options of `sweep`.
WAYS = {
    "threads": {},
    "threads, rows kept in a Parquet file": {"out": "sweep.parquet"},
    "processes": {"scheduler": "processes"},
}


def spent():
    """Processor seconds of this process and of those that it has waited for."""
    both = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def child():
    """A sweep by the plan on standard input."""
    import pandas as pd  # noqa: PLC0415
    from dth_hammer import HammerWarning, sweep  # noqa: PLC0415

    # Five elements per bar are doubtful, and said to be: not what is asked here.
    warnings.simplefilter("ignore", HammerWarning)
    plan = json.load(sys.stdin)
    grid = pd.DataFrame(plan["points"], columns=plan["names"])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        cpu, began = spent(), time.perf_counter()
        more = {"outputs": plan["outputs"], "workers": plan["threads"]} | plan["options"]
        table = sweep(grid, plan["until"], **more)
        seconds, own = time.perf_counter() - began, spent() - cpu
        os.chdir(ROOT)
    rows = table[plan["outputs"]].to_numpy(dtype=float).tolist()
    print(json.dumps({"seconds": seconds, "cpu": own, "start": cpu, "rows": rows}))


def answer(command, plan):
    """What a program says to a plan, and the processor seconds that it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [str(word) for word in command],
        input=json.dumps(plan),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"whole": whole} | json.loads(done.stdout.splitlines()[-1])


def planned(scene, runs, threads):
    """What both are told."""
    from dth_hammer.sweeping import RESULTS  # noqa: PLC0415

    shared = SCENES[scene]
    feeds = [FEEDS[0] + (FEEDS[1] - FEEDS[0]) * i / runs for i in range(runs)]
    return {
        "names": ["feed_force", *shared],
        "points": [[feed, *map(float, shared.values())] for feed in feeds],
        "until": UNTIL,
        "outputs": [*RESULTS],
        "threads": threads,
        "options": {},
    }


def counted(scene, engine):
    """Instructions of a run, beyond the first: by the engine alone, and by the sweep."""
    if not shutil.which("valgrind"):
        return None
    sweep, found = [sys.executable, __file__, "--child"], []
    for command in ([engine], sweep):
        totals = []
        for runs in (1, 1 + COUNTED):
            tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
            plan = json.dumps(planned(scene, runs, 1))
            whole = [*tool, *map(str, command)]
            done = subprocess.run(whole, input=plan, capture_output=True, text=True, check=True)
            totals.append(int(re.search(r"Collected : (\d+)", done.stderr)[1]))
        found.append((totals[1] - totals[0]) / COUNTED)
    return found


def measured(scene, engine, runs, rounds):
    """Of a scene, the turns of the engine and of each way."""
    plan = planned(scene, runs, THREADS)
    turns = []
    for _ in range(rounds):
        alone = answer([engine], plan)
        turn = {"engine": {"cpu": alone["whole"], "seconds": alone["seconds"]}}
        for way, options in WAYS.items():
            found = answer([sys.executable, __file__, "--child"], plan | {"options": options})
            if found.pop("rows") != alone["rows"]:
                raise SystemExit(f"{scene}, {way}: other numbers than the engine's")
            turn[way] = found
        turns.append(turn)
    return turns


def spread(ratios, form):
    """The middle of some ratios, and their range."""
    low, high = min(ratios), max(ratios)
    return f"{statistics.median(ratios):{form}} ({low:{form}} to {high:{form}})"


def report(data):
    """The page."""
    lines = [
        "# Cost of a sweep",
        "",
        f"{data['runs']} runs of {UNTIL:g} s each over the feed force, on {THREADS} threads or "
        f"processes and {data['cores']} cores ({data['processor']}), with the outputs that "
        "`sweep` reads if it is told of none. **Engine**: the same runs by a Rust program that "
        "knows the engine alone (`evidence/bench/src/bin/sweep_engine.rs`); both give the same "
        "numbers to the last bit. **Sweep**: from the call of `dth_hammer.sweep` to its table, "
        "its threads and processes from their start to their end; not the start of Python and "
        f"its imports, which take {data['start']:.1f} s once. All in turn, {data['rounds']} "
        "rounds; the middle of the rounds' ratios, and their range. The machine's load was "
        f"{data['load']:.1f} in the mean, of which these runs are {THREADS} at most.",
        "",
        "```text",
        "cargo fmu",
        "cargo build --profile fmu -p bench --bin sweep-engine",
        "python evidence/bench/sweep_cost.py",
        "```",
        "",
        "| bodies | engine, CPU a run | sweep by | CPU over engine | wall over engine |",
        "|---|---:|---|---:|---:|",
    ]
    for scene, turns in data["scenes"].items():
        alone = statistics.median(turn["engine"]["cpu"] for turn in turns) / data["runs"]
        for way in WAYS:
            cpu = [turn[way]["cpu"] / turn["engine"]["cpu"] for turn in turns]
            wall = [turn[way]["seconds"] / turn["engine"]["seconds"] for turn in turns]
            lines.append(
                f"| {scene} | {1e3 * alone:.2f} ms | {way} "
                f"| {spread(cpu, '.2f')} | {spread(wall, '.2f')} |"
            )
    turns = next(iter(data["scenes"].values()))
    ratio = statistics.median(turn["threads"]["cpu"] / turn["engine"]["cpu"] for turn in turns)
    verdict = "is met" if ratio <= GOAL else "is not met"
    lines += [
        "",
        f"The reference hammer by threads, which `sweep` takes by itself: {ratio:.2f} times the "
        f"engine's own CPU time; the goal, {GOAL}, {verdict}.",
    ]
    return "\n".join([*lines, *instructions(data["counts"])]) + "\n"


def instructions(counts):
    """The table of what callgrind counts."""
    if not all(counts.values()):
        return ["", "Instructions were not counted: there is no valgrind."]
    lines = [
        "",
        f"Instructions of a run beyond the first, on one thread (the mean of {COUNTED}; AVX2, as "
        "valgrind's processor has no AVX-512): a count that does not depend on other work.",
        "",
        "| bodies | engine | sweep | sweep over engine |",
        "|---|---:|---:|---:|",
    ]
    for scene, (alone, swept) in counts.items():
        lines.append(f"| {scene} | {alone:,.0f} | {swept:,.0f} | {swept / alone:.3f} |")
    return lines


def processor():
    """Its name."""
    text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    names = [line.split(":", 1)[1].strip() for line in text.splitlines() if "model name" in line]
    return names[0] if names else "unknown"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int)
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        child()
        return
    runs, rounds = options.runs or RUNS, options.rounds or ROUNDS
    target = Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    engine = ROOT / target / "fmu" / "sweep-engine"
    loads, scenes = [], {}
    for scene in SCENES:
        scenes[scene] = measured(scene, engine, runs, rounds)
        loads.append(os.getloadavg()[0])
    starts = [turn[way]["start"] for turns in scenes.values() for turn in turns for way in WAYS]
    data = {
        "runs": runs,
        "rounds": rounds,
        "cores": os.cpu_count(),
        "processor": processor(),
        "load": statistics.mean(loads),
        "start": statistics.median(starts),
        "scenes": scenes,
        "counts": {scene: counted(scene, engine) for scene in SCENES},
    }
    print(report(data))
    if not (options.runs or options.rounds):
        docs = ROOT / "docs" / "sweep-cost"
        docs.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
        docs.with_suffix(".md").write_text(report(data), encoding="utf-8")


if __name__ == "__main__":
    main()
