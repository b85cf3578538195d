"""The piston whose blow does the most work on a rock: six sections of a given mass and length.

    python examples/shape_piston.py --rock granite --out piston.png

The efficiency is Lundberg's: the work that the wave of one blow does on the rock while loading it,
over the piston's energy. The bit is a rod so long that no reflection returns from the rock before
the wave is over. The rock has a loading line, without viscosity or barrier. On it a uniform piston
reaches 0.8145 at best, and a wave that grows exponentially tends to 1 (Lundberg, Int. J. Rock Mech.
Min. Sci. 10, 1973; Lundberg and Collet, Int. J. Impact Eng. 37, 2010).
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from dth_hammer import VARIABLES, Hammer, simulate
from dth_hammer import rock as rock_under
from dth_hammer.figures import DARK, PISTON
from dth_hammer.figures.style import styled
from dth_hammer.scene.variables import Array, Value
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import minimize

SECTIONS = 6
#: Lengths of the bit over that of the piston: the wave may last twice its transit.
ROD = 4
#: Speed at the strike, m/s: the efficiency does not depend on it.
SPEED = 10.0
#: Spans a piston: while it is sought, and once it is found.
COARSE, FINE = 12, 48


@dataclass(frozen=True)
class Scene:
    """The rock, the bit and the mass and length of the piston."""

    mass: float = 16.0  # kg
    length: float = 0.8  # m
    bit_area: float = 2.6e-3  # m2
    rock: str = "granite"
    #: Largest and smallest section over the mean one: the bore, and what still holds.
    limits: tuple[float, float] = (0.3, 2.5)
    #: Start values of the FMU and of the rock.
    own: dict[str, float] = field(init=False)

    def __post_init__(self) -> None:
        names = ("material.density", "material.youngs_modulus", *ROCK)
        start = {name: VARIABLES[name].start for name in names}
        own = rock_under(self.rock, hole="90 mm")
        object.__setattr__(self, "own", {n: own.get(n, x) for n, x in start.items()})

    @property
    def speed(self) -> float:
        """Speed of waves, m/s."""
        return math.sqrt(self.own["material.youngs_modulus"] / self.own["material.density"])

    @property
    def area(self) -> float:
        """The mean section of the piston, m2."""
        return self.mass / (self.own["material.density"] * self.length)

    @property
    def transit(self) -> float:
        """Time that a wave takes through the bit, s."""
        return ROD * self.length / self.speed

    @property
    def contact(self) -> float:
        """Stiffness of the contact, N/m: that of a span, so that the mesh resolves the front."""
        return COARSE * self.own["material.youngs_modulus"] * self.bit_area / self.length

    def areas(self, shape: Sequence[float] | Array) -> Array:
        """Returns the sections (m2), top to bottom, of a shape, of which only the ratios matter."""
        return self.area * np.asarray(shape) / np.mean(shape)

    def parameters(self, areas: Array, spans: int) -> dict[str, Value]:
        """Returns parameters: a piston strikes a long, free bit on intact rock at once."""
        pieces: dict[str, Value] = {"piston.segments": len(areas)}
        for k, area in enumerate(areas, 1):
            pieces[f"piston.segment[{k}].length"] = self.length / len(areas)
            pieces[f"piston.segment[{k}].area"] = float(area)
        still = ("drive.amplitude", "gravity", "feed_force", "contact.initial_gap")
        ideal = [f"rock.{name}" for name in IDEAL]
        return pieces | {
            "cross_section": self.bit_area,
            "bit.length": ROD * self.length,
            "piston.elements": spans,
            "bit.elements": ROD * spans,
            "mesh.degree": 5,
            "contact.stiffness": self.contact,
            "piston.initial_velocity": SPEED,
            **dict.fromkeys([*still, *ideal], 0.0),
            **{name: self.own[name] for name in ROCK},
        }


ROCK = ("rock.stiffness", "rock.unloading_ratio")
IDEAL = ("viscosity", "energy_barrier", "standstill_speed", "standstill_penetration")


def efficiency(scene: Scene, areas: Array, spans: int = COARSE) -> float:
    """Returns the work on the rock over the energy of the piston.

    The rock keeps 1 - 1/gamma of the work that loads it. The reflection in the bit reaches the
    rock again three transits after the strike, so the result is read just before.
    """
    with Hammer(scene.parameters(areas, spans), quiet=True) as hammer:
        hammer.step(3 * scene.transit)
        dissipated = hammer["energy_rock_dissipated"]
    work = dissipated / (1 - 1 / scene.own["rock.unloading_ratio"])
    return float(work / (0.5 * scene.mass * SPEED**2))


def wave(scene: Scene, areas: Array, spans: int = FINE) -> pd.Series:
    """Returns the force (N) at the bit's upper face over time (s), until the reflection arrives."""
    run = simulate(
        scene.parameters(areas, spans),
        times=np.linspace(0.0, 2 * scene.transit, 1601),
        outputs=["contact_force"],
    )
    return run["contact_force"]


def incident(scene: Scene, force: pd.Series) -> float:
    """Returns the energy of the wave over that of the piston: the integral of F^2 / Z."""
    own = scene.own
    impedance = scene.bit_area * math.sqrt(own["material.youngs_modulus"] * own["material.density"])
    energy = np.trapezoid(force**2, force.index) / impedance
    return float(energy / (0.5 * scene.mass * SPEED**2))


def shape(scene: Scene, iterations: int = 40) -> Array:
    """Returns the sections (m2), top to bottom, of the most efficient piston.

    Sequential quadratic programs with differences as derivatives. The mass enters as a linear
    constraint, the limits as bounds.
    """
    found = minimize(
        lambda x: -efficiency(scene, scene.areas(x)),
        np.ones(SECTIONS),
        method="SLSQP",
        bounds=[scene.limits] * SECTIONS,
        constraints={"type": "eq", "fun": lambda x: np.mean(x) - 1},
        options={"maxiter": iterations, "eps": 1e-4, "ftol": 1e-6},
    )
    return scene.areas(found.x)


def compare(scene: Scene, shaped: Array) -> pd.DataFrame:
    """Returns efficiency and energy of the wave for the shaped and the uniform piston."""
    rows = {}
    for name, areas in (("uniform", scene.areas(np.ones(SECTIONS))), ("shaped", shaped)):
        force = wave(scene, areas)
        row = {"efficiency": efficiency(scene, areas, FINE), "wave energy": incident(scene, force)}
        rows[name] = row | {"largest force (kN)": force.max() * 1e-3}
    return pd.DataFrame(rows).T


def _profile(axes: Axes, scene: Scene, areas: Array, **style: object) -> None:
    """Returns the outline of a round piston, with the striking face at the right."""
    ends = np.linspace(0.0, scene.length, len(areas) + 1) * 1e3
    radius = np.sqrt(areas / np.pi) * 1e3
    place, half = np.repeat(ends, 2), np.concatenate([[0], np.repeat(radius, 2), [0]])
    axes.plot(np.r_[place, place[::-1]], np.r_[half, -half[::-1]], **style)


def draw(scene: Scene, shaped: Array, table: pd.DataFrame) -> Figure:
    """Draws profiles and incident waves of the uniform and the shaped piston."""
    gain = table.loc["shaped", "efficiency"] / table.loc["uniform", "efficiency"]
    with styled(6.5, 5.0) as figure:
        upper, lower = figure.subplots(2, height_ratios=(1, 1.6))
        uniform, last = scene.areas(np.ones(SECTIONS)), 0.0
        for name, areas, style in (
            ("uniform", uniform, {"color": DARK, "linestyle": "--"}),
            ("shaped", shaped, {"color": PISTON}),
        ):
            _profile(upper, scene, areas, **style)
            force = wave(scene, areas)
            last = max(last, force.index[force > 0.01 * force.max()].max())
            text = f"{name}: {100 * table.loc[name, 'efficiency']:.1f} % of the blow into the rock"
            lower.plot(force.index * 1e6, force * 1e-3, label=text, **style)
        upper.set_xlabel("from the upper end (mm), striking face at the right")
        upper.set_ylabel("radius (mm)")
        upper.margins(0.03, 0.2)
        lower.set_xlabel("time since the strike (µs)")
        lower.set_ylabel("force at the bit's upper face (kN)")
        lower.set_xlim(0.0, 1.05e6 * last)
        lower.set_ylim(bottom=0.0)
        lower.grid(color="0.92", linewidth=0.6)
        rock = scene.rock.replace("_", " ")
        figure.suptitle(
            f"{scene.mass:g} kg, {scene.length * 1e3:g} mm, {rock}: gain {gain:.3f}", fontsize=10.5
        )
        figure.legend(*lower.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def main() -> None:
    """Shapes a piston, compares it with the uniform one, and draws both."""
    own = Scene.__dataclass_fields__
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--mass", type=float, default=own["mass"].default, help="kg")
    parser.add_argument("--length", type=float, default=own["length"].default, help="m")
    parser.add_argument("--bit-area", type=float, default=own["bit_area"].default, help="m2")
    parser.add_argument("--rock", default=own["rock"].default, help="a name, a class or a strength")
    parser.add_argument("--out", type=Path, default=Path("piston.png"))
    asked = parser.parse_args()
    scene = Scene(asked.mass, asked.length, asked.bit_area, asked.rock)
    shaped = shape(scene)
    print("sections, top to bottom (mm2):", *(f"{1e6 * area:.0f}" for area in shaped))
    table = compare(scene, shaped)
    print(table.to_string(float_format="%.4f"))
    draw(scene, shaped, table).savefig(asked.out, dpi=160)


if __name__ == "__main__":
    main()
