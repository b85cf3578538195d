"""The FMU against exact waves: the mesh is the only difference, and it shrinks."""

from __future__ import annotations

import math

import pytest
from fmu import Instance, Package
from oracle_waves import Scene, blow

GAMMA = 5.0
SPEED = 8.0


def one_blow(package: Package, kappa: float, elements: int, transits: float) -> dict[str, float]:
    """A thrown piston on a bit that touches virgin rock; no other load at all."""
    start = package.start
    rigidity = start("material.youngs_modulus") * start("cross_section")
    length = start("piston.length")
    speed_of_sound = math.sqrt(start("material.youngs_modulus") / start("material.density"))
    scene = {
        "piston.elements": elements,
        "bit.elements": elements,
        "contact.stiffness": 2 * rigidity * elements / length,
        # Enough to quiet what the mesh adds, and gone with it.
        "material.damping_time": 0.01 * length / elements / speed_of_sound,
        "contact.initial_gap": 0.0,
        "piston.initial_velocity": SPEED,
        "rock.stiffness": kappa * rigidity / length,
        "rock.unloading_ratio": GAMMA,
        "rock.viscosity": 0.0,
        "rock.energy_barrier": 0.0,
        "rock.standstill_speed": 0.0,
        "rock.standstill_penetration": 0.0,
        "drive.amplitude": 0.0,
        "gravity": 0.0,
        "feed_force": 0.0,
    }
    mass = start("material.density") * start("cross_section") * length
    with Instance(package, scene) as hammer:
        hammer.advance(transits * length / speed_of_sound)
        return {
            "kept": 2 * hammer.get("energy_rock_dissipated") / (mass * SPEED**2),
            "speed": hammer.get("piston_velocity") / SPEED,
        }


@pytest.mark.parametrize("kappa", [0.03, 0.1, 0.3])
def test_a_blow_converges_to_exact_waves_as_the_mesh_is_refined(
    package: Package, kappa: float
) -> None:
    # Well into the second collision's aftermath: the piston has left for good.
    transits = blow(Scene(kappa, GAMMA), until=30.0).collisions[1].end + 0.5
    exact = blow(Scene(kappa, GAMMA), until=transits)
    coarse, fine = (one_blow(package, kappa, elements, transits) for elements in (20, 80))
    for name, value in (("kept", 2 * exact.dissipated), ("speed", exact.piston_speed)):
        far, near = abs(coarse[name] - value), abs(fine[name] - value)
        # Linear elements smear a jump over the 2/3 power of their size, here 0.054 and
        # 0.14 of a bar: no error may be larger, and it must fall about that fast (2.5).
        assert near < 80 ** (-2 / 3), name
        assert near < far / 1.6, name
