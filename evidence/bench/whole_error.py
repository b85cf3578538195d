"""Cost of a settled cycle against the whole error, in time and space, of the reference hammer.

    python evidence/bench/whole_error.py   # writes docs/whole-error.{json,md,svg}

Needs the package and a built FMU. In time the engine errs by 1e-12; what is left is the mesh.
Errors are against the finest mesh of the highest degree. CPU time of one thread, the
fastest of some rounds in turn, and its ratio to twenty linear elements in the same run.
"""

from __future__ import annotations

import json
import math
import platform
import subprocess
import time
from pathlib import Path
from typing import Any

import matplotlib as mpl
from dth_hammer import Hammer
from dth_hammer.figures import STYLE
from matplotlib.figure import Figure

DOCS = Path(__file__).resolve().parents[2] / "docs"
#: Spans per body by degree: the first is today's mesh.
MESHES = {
    1: (20, 40, 80, 160),
    3: (10, 16, 24, 32, 48, 64, 96, 128),
    5: (10, 16, 24, 32, 48, 64, 96, 128),
    7: (10, 16, 24, 32, 48, 60, 64, 96),
}
CONVERGED = (7, 128)
#: The finest of the meshes on which the tip is turned before the front arrives.
TURNED = (7, 80)
#: Blows until the response repeats itself, and cycles timed.
SETTLE, CYCLES, ROUNDS = 80, 8, 5
STEP, PERIOD = 1e-3, 45.5e-3
#: Times that the tip is looked at while the wave is on its way.
LOOKS = 200
QUANTITIES = {
    "blow_period": "period",
    "rop": "rate of penetration",
    "blow_speed": "impact speed",
    "contact_force_peak": "largest contact force",
    "rock_force_peak": "largest rock force",
}
FORERUNNER = (
    "**Which of two cycles.** When the piston strikes, the bit still creeps into the rock at "
    "some 1e-15 m/s, in the drilling cycle that the last touch began. A mesh lets a little of the "
    "wave run ahead of its front: the column *ahead* is the tip's largest upward speed, in m/s, "
    "before the front can be there. While that is enough to turn the tip, the law ends the old "
    "drilling cycle, begins a new one, and its energy barrier is to be paid once more; *turned* "
    "counts these events. Where there are none, the law goes on as it would in the continuum. "
    "The two cycles are 1.2e-4 apart in the period, 4.4e-4 in the rate of penetration and 2.1e-3 "
    "in the largest rock force: the floor of all lines here but the finest meshes'. No rock knows "
    "1e-15 m/s from rest, so a user should read this floor as what the law itself leaves open."
)
COLOURS = {1: "#999999", 3: "#e69f00", 5: "#0072b2", 7: "#d55e00"}
PEERS = {"tabulated propagators": ("s", "#009e73"), "Radau IIA-5, adaptive": ("^", "#cc79a7")}
#: Measures the peers; prints one line of JSON.
CONTEST = ["run", "--quiet", "--release", "-p", "bench", "--features", "contest"]


class Case:
    """A settled hammer on one mesh."""

    def __init__(self, degree: int, spans: int) -> None:
        self.degree, self.spans = degree, spans
        parameters = {"mesh.degree": degree, "piston.elements": spans, "bit.elements": spans}
        self.hammer = Hammer(parameters, quiet=True)
        self.hammer.step(SETTLE * PERIOD)
        self.seconds = float("inf")
        self.events = 0.0
        self.values = dict.fromkeys(QUANTITIES, 0.0)

    def measure(self) -> None:
        """Times some cycles in steps of a millisecond, and reads what they come to."""
        steps = round(CYCLES * PERIOD / STEP)
        begun = time.thread_time()
        for _ in range(steps):
            self.hammer.step(STEP)
        self.seconds = min(self.seconds, (time.thread_time() - begun) / CYCLES)

    def read(self) -> None:
        """The settled response."""
        before = [self.hammer[name] for name in ("event_count", "blow_count")]
        for _ in range(round(2 * PERIOD / STEP)):
            self.hammer.step(STEP)
            for name in ("contact_force_peak", "rock_force_peak"):
                self.values[name] = max(self.values[name], self.hammer[name])
        for name in ("blow_period", "rop", "blow_speed"):
            self.values[name] = self.hammer[name]
        after = [self.hammer[name] for name in ("event_count", "blow_count")]
        self.events = (after[0] - before[0]) / (after[1] - before[1])
        self.turned, self.ahead = self.before_front()

    def before_front(self) -> tuple[int, float]:
        """Events, and the tip's largest upward speed (m/s), from a blow to nine tenths of the
        wave's time to the tip."""
        blows = self.hammer["blow_count"]
        while self.hammer["blow_count"] == blows:
            snapshot = self.hammer.save()
            self.hammer.step(STEP)
        strike = self.hammer["blow_time"]
        self.hammer.restore(snapshot)
        modulus, density, length = (
            self.hammer[name]
            for name in ("material.youngs_modulus", "material.density", "bit.length")
        )
        self.hammer.advance(strike - 1e-9)
        before = self.hammer["event_count"]
        ahead, front = 0.0, 0.9 * length / math.sqrt(modulus / density)
        for look in range(1, LOOKS + 1):
            self.hammer.advance(strike + front * look / LOOKS)
            ahead = max(ahead, -self.hammer["bit_tip_velocity"])
        closing = 1
        return round(self.hammer["event_count"] - before) - closing, ahead


def contest(exact: dict[str, float]) -> list[dict[str, Any]]:
    """The peers on their meshes: cost over ours on twenty linear elements, errors."""
    command = ["cargo", *CONTEST, "--bin", "peers-by-mesh"]
    done = subprocess.run(command, cwd=DOCS.parent, check=True, stdout=subprocess.PIPE, text=True)
    rows: list[dict[str, Any]] = json.loads(done.stdout)
    for row in rows:
        found = {"blow_period": row["period"], "rop": row["rop"]}
        row["errors"] = {name: value / exact[name] - 1.0 for name, value in found.items()}
    return rows


def measure() -> dict[str, Any]:
    """All meshes, in turn."""
    cases = [Case(degree, spans) for degree, list_ in MESHES.items() for spans in list_]
    for _ in range(ROUNDS):
        for case in cases:
            case.measure()
    exact, turned = Case(*CONVERGED), Case(*TURNED)
    for case in [*cases, exact, turned]:
        case.read()
    rows = [
        {
            "degree": case.degree,
            "spans": case.spans,
            "seconds": case.seconds,
            "events": case.events,
            "turned": case.turned,
            "ahead": case.ahead,
            "cost": case.seconds / cases[0].seconds,
            "errors": {n: case.values[n] / exact.values[n] - 1.0 for n in QUANTITIES},
            "own_errors": {n: case.values[n] / turned.values[n] - 1.0 for n in QUANTITIES}
            if round(case.events) == round(turned.events)
            else None,
        }
        for case in cases
    ]
    return {
        "processor": processor(),
        "converged": exact.values,
        "turned": turned.values,
        "rows": rows,
        "peers": contest(exact.values),
    }


def processor() -> str:
    """Its name and the widest vectors it has."""
    info = Path("/proc/cpuinfo")
    text = info.read_text() if info.exists() else ""
    names = [line.split(":", 1)[1].strip() for line in text.splitlines() if "model name" in line]
    wide = "AVX-512" if "avx512f" in text else "AVX2" if "avx2" in text else "no AVX2"
    return f"{names[0] if names else platform.processor()}, {wide}"


def draw(found: dict[str, Any]) -> Figure:
    """Error against cost, a panel a quantity, a line a degree."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 5.4), layout="constrained")
        axes = figure.subplots(2, 3, sharex=True).flatten()
        for panel, (name, label) in zip(axes, QUANTITIES.items(), strict=False):
            for degree, colour in COLOURS.items():
                rows = [row for row in found["rows"] if row["degree"] == degree]
                cost = [row["cost"] for row in rows]
                error = [max(abs(row["errors"][name]), 1e-9) for row in rows]
                panel.loglog(cost, error, "o-", ms=3.5, color=colour, label=f"degree {degree}")
            for solver, (marker, colour) in PEERS.items():
                rows = [r for r in found["peers"] if r["solver"] == solver and name in r["errors"]]
                cost = [row["cost"] for row in rows]
                error = [abs(row["errors"][name]) for row in rows]
                panel.loglog(cost, error, marker, ms=3.5, color=colour, label=solver)
            panel.set_title(label)
            panel.grid(color="0.92", linewidth=0.6)
            panel.set_xlabel("cost over 20 linear elements")
            panel.set_ylabel("relative error")
        axes[-1].axis("off")
        axes[2].tick_params(labelbottom=True)
        axes[-1].legend(*axes[0].get_legend_handles_labels(), loc="center")
    return figure


def page(found: dict[str, Any]) -> str:
    """The table."""
    head = [
        "# Speed against whole error",
        "",
        "Written by `python evidence/bench/whole_error.py`: the reference hammer, settled, in "
        "steps of 1 ms with nothing read. In time the engine errs by 1e-12 "
        "([speed against error](speed-against-error.md)); what is left is the mesh, and this "
        f"page is about the sum. Errors are against degree {CONVERGED[0]} on {CONVERGED[1]} spans "
        "per body; cost is CPU time of a cycle over that of twenty linear elements in the same "
        f"run, the fastest of {ROUNDS} rounds in turn ({found['processor']}). Set-up is not in it.",
        "",
        "![error against cost](whole-error.svg)",
        "",
        *table(found["rows"], "errors"),
        "",
        f"Converged: {response(found['converged'])}.",
        "",
        FORERUNNER,
        "",
        "Against the converged cycle of their own kind, degree "
        f"{TURNED[0]} on {TURNED[1]} spans ({response(found['turned'])}):",
        "",
        *table([row for row in found["rows"] if row["own_errors"]], "own_errors"),
        *peers_table(found["peers"]),
    ]
    return "\n".join(head)


def table(rows: list[dict[str, Any]], errors: str) -> list[str]:
    """Meshes, what they cost, and these errors of theirs."""
    head = ["degree", "spans", "cost", "events per cycle", "turned", "ahead", *QUANTITIES.values()]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for row in rows:
        cells = [
            f"{row['degree']}",
            f"{row['spans']}",
            f"{row['cost']:.2f}",
            f"{row['events']:.0f}",
            f"{row['turned']}",
            f"{row['ahead']:.0e}",
            *(f"{row[errors][name]:+.1e}" for name in QUANTITIES),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def response(values: dict[str, float]) -> str:
    """A settled response in words."""
    return (
        f"period {1e3 * values['blow_period']:.6f} ms, rate of penetration "
        f"{1e3 * values['rop']:.5f} mm/s, impact {values['blow_speed']:.6f} m/s, largest contact "
        f"force {1e-3 * values['contact_force_peak']:.2f} kN, largest rock force "
        f"{1e-3 * values['rock_force_peak']:.2f} kN"
    )


def peers_table(rows: list[dict[str, Any]]) -> list[str]:
    """The peers, each on its meshes."""
    head = [
        "",
        "## Peers, each on its best mesh",
        "",
        "The two fastest of the [other solvers](speed-against-error.md), over twenty cycles from "
        "rest, the last five measured; costs and errors as above. Degree 1 is linear elements, a "
        "higher one spectral elements on Legendre-Gauss-Lobatto nodes, which full matrices take "
        "and Radau's tridiagonal ones do not. Tables are not in the cost. The setting is the scan "
        "step (s) or the tolerance.",
        "",
        "| solver | degree | elements | setting | cost | period | rate of penetration |",
        "|---" * 7 + "|",
    ]
    for row in rows:
        errors = " | ".join(f"{error:+.1e}" for error in row["errors"].values())
        head.append(
            f"| {row['solver']} | {row['degree']} | {row['elements']} | {row['setting']:.0e} | "
            f"{row['cost']:.0f} | {errors} |"
        )
    return [*head, ""]


def main() -> None:
    """Measures and writes."""
    found = measure()
    (DOCS / "whole-error.json").write_text(json.dumps(found, indent=1) + "\n")
    (DOCS / "whole-error.md").write_text(page(found))
    draw(found).savefig(DOCS / "whole-error.svg")


if __name__ == "__main__":
    main()
