"""Stress and velocity along the bars, compared with closed forms and balances."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import matplotlib.image as mpimg
import numpy as np
import pandas as pd
import pytest
from dth_hammer import (
    VARIABLES,
    DomainError,
    DthHammerError,
    Hammer,
    RefusedError,
    UnknownNameError,
    figures,
    simulate,
    waves,
)
from dth_hammer.simulation.diagram import Waves
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from scipy.integrate import simpson

#: The first blow is before this time, s.
FIRST = 0.03
#: Velocities are linear between nodes, and masses are those of the consistent matrix.
LINEAR = {"mesh.degree": 1}


def start(name: str) -> float:
    return VARIABLES[name].start or 0.0


E, RHO, AREA = (start(n) for n in ("material.youngs_modulus", "material.density", "cross_section"))
SPEED = np.sqrt(E / RHO)
LENGTH = start("piston.length")
TRANSIT = LENGTH / SPEED
#: Acceleration of the piston in contact: the relay pulls it back from the impact on.
PULL = start("gravity") - start("drive.amplitude") / (RHO * AREA * LENGTH)


@pytest.mark.parametrize("elements", [80, 160])
def test_behind_the_front_is_the_stress_of_saint_venant(elements: int) -> None:
    """-E v / (2 c0) in both bars, v the speed with which they met a way x / c0 ago.

    That speed changes with the pull on the piston; the bit is in balance, and keeps the
    stress that it had. Looked at in the quarter next to the contact, while the front is in
    the outer half: many times (h^2 c t / 8)^(1/3) away, the width that a mesh gives a front.
    """
    size = LENGTH / elements
    times = np.linspace(0.5, 0.9, 41) * TRANSIT
    parameters = {"mesh.degree": 1, "piston.elements": elements, "bit.elements": elements}
    record = waves(parameters, FIRST, times=[-1e-6, *times])
    speed = record.notes["front"] * 2 * SPEED / E
    # The contact's compliance delays the plateau, and an element may do so too.
    delay = AREA * np.sqrt(E * RHO) / (2 * start("contact.stiffness")) + size / SPEED
    # The mesh's fastest oscillation, begun at the impact, with its modal damping.
    fastest = np.sqrt(12) * SPEED / size
    left = np.exp(-0.5 * start("material.damping_time") * fastest**2 * times[0])
    bound = abs(PULL) * delay + left * speed
    assert bound < 2e-4 * speed
    for bar in (record.piston, record.bit):
        near = np.abs(bar.centres) < 0.25 * LENGTH
        way = np.abs(bar.centres[near]) / SPEED
        expected = -E / (2 * SPEED) * (speed + PULL * (times[:, None] - way))
        change = bar.stress[1:, near] - bar.stress[0, near]
        np.testing.assert_allclose(change, expected, rtol=0.0, atol=E / (2 * SPEED) * bound)


def test_the_contact_force_is_what_the_stress_beside_it_balances() -> None:
    """Impulses on the end node's half element: stress, contact, its momentum, its loads."""
    until = 1.2 * TRANSIT
    times = np.linspace(0.0, until, 2001)
    record = waves(LINEAR, until=FIRST, times=times)
    force = simpson(record.beside["contact_force"], x=times)
    half = RHO * AREA * LENGTH / start("piston.elements") / 2

    def momentum(end: np.ndarray, next_one: np.ndarray) -> float:
        """Returns the change of a row's momentum with the consistent mass matrix."""
        row = half * (2 * end + next_one) / 3
        return float(row[-1] - row[0])

    v, w = record.piston.velocity, record.bit.velocity
    above = AREA * simpson(record.piston.stress[:, -1], x=times)
    below = AREA * simpson(record.bit.stress[:, 0], x=times)
    gained = momentum(v[:, -1], v[:, -2])
    taken = momentum(w[:, 0], w[:, 1])
    # Simpson's rule on the fastest oscillation, (w dt)^4 / 180 of it, is below 1e-6 of the
    # force; the relay turns within 1e-7 s of the impact.
    size = LENGTH / start("piston.elements")
    error = (np.sqrt(12) * SPEED / size * times[1]) ** 4 / 180
    assert error < 1e-6
    relay = 2 * start("drive.amplitude") * half / (RHO * AREA * LENGTH) * 1e-7
    bound = 2e-6 * force + relay
    assert abs(gained + above + force - half * PULL * until) < bound
    loads = start("feed_force") + half * start("gravity")
    assert abs(taken - below - force - loads * until) < bound
    assert force > 5.0


def test_a_table_has_the_waves_when_asked_for() -> None:
    plain = simulate(LINEAR, until=0.01, step=0.005)
    run = simulate(LINEAR, until=0.01, step=0.005, waves=True)
    assert not any("stress" in str(column) for column in plain)
    count = int(start("piston.elements"))
    assert run.frame.shape[1] - plain.frame.shape[1] == 2 * count + 2 * (count + 1)
    assert run.units["bit_stress[3]"] == "Pa"
    mean = run.frame[[f"piston_node_velocity[{i + 1}]" for i in range(count + 1)]].to_numpy()
    weights = np.ones(count + 1)
    weights[[0, -1]] = 0.5
    np.testing.assert_allclose(mean @ weights / count, run["piston_velocity"], rtol=1e-12)
    # The rock carries feed and weight.
    weight = RHO * AREA * LENGTH * start("gravity")
    last = run[f"bit_stress[{count}]"].iloc[0] * AREA
    assert last == pytest.approx(-start("feed_force") - weight * (1 - 0.5 / count))
    with pytest.raises(DthHammerError, match="simulate with waves=True"):
        Waves.of(plain)


def test_stresses_by_name_on_a_live_hammer() -> None:
    with Hammer({"bit.elements": 5}) as hammer:
        assert hammer["bit_stress[5]"] < 0.0
        with pytest.raises(RefusedError, match=r"no bit_stress\[6\]: bit.elements = 5"):
            hammer["bit_stress[6]"]
        with pytest.raises(UnknownNameError, match="did you mean 'bit_stress'"):
            hammer["bit_stres[5]"]


def test_no_waves_without_elastic_bars_or_blows() -> None:
    with pytest.raises(DomainError, match="rigid bodies carry no waves: set fidelity"):
        simulate({"fidelity": "Rigid"}, until=0.01, waves=True)
    with pytest.raises(DthHammerError, match=r"no blow in 0\.005 s"):
        waves(until=0.005)


def test_the_long_table_is_the_arrays() -> None:
    record = waves(until=FIRST, times=[0.0, 1e-5, 2e-5])
    table = record.to_frame()
    assert table.columns.tolist() == ["time", "body", "position", "stress"]
    found = table.pivot(index=["time"], columns=["body", "position"], values="stress")
    np.testing.assert_array_equal(found["piston"].to_numpy(), record.piston.stress)
    np.testing.assert_array_equal(found["bit"].columns, record.bit.centres)


def test_the_diagram_is_white_where_no_stress_is(tmp_path: Path) -> None:
    record = waves(until=FIRST, times=np.linspace(-1e-5, 2e-4, 200))
    figure = figures.wave_diagram(record)
    figure.savefig(tmp_path / "waves.png", dpi=40)
    plane, strip, colours = figure.get_axes()
    assert plane.get_xlabel().endswith("(mm)")
    assert plane.get_ylabel().endswith("(µs)")
    assert "MPa" in colours.get_xlabel()
    meshes = [c for c in plane.collections if isinstance(c, QuadMesh)]
    assert len(meshes) == 2
    for one in meshes:
        low, high = one.get_clim()
        assert low == -high
        assert high >= np.abs(one.get_array()).max()
    said = [text.get_text() for text in plane.texts]
    assert said[:2] == ["contact closes", "contact opens"]
    assert strip.patches


@pytest.mark.filterwarnings("ignore:.*creeps in the rock")
def test_the_words_of_the_diagram_stand_apart_and_in_order() -> None:
    """Hard rock: two short contacts within 60 microseconds, after that of the blow."""
    rock = {"stiffness": 5e8, "unloading_ratio": 6.0, "viscosity": 3e5, "energy_barrier": 15.0}
    hard = {f"rock.{name}": value for name, value in rock.items()}
    figure = figures.wave_diagram(waves(hard, preset="overdamped", until=0.3))
    plane = figure.get_axes()[0]
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    words = sorted(plane.texts, key=lambda text: float(text.get_position()[1]))
    assert [word.get_text() for word in words] == ["contact closes", "contact opens"] * 3
    boxes = [word.get_window_extent(canvas.get_renderer()) for word in words]
    assert all(below.y1 <= above.y0 for below, above in pairwise(boxes))


def test_the_command_draws_and_writes(tmp_path: Path, cli: Callable[..., str]) -> None:
    plot, table = tmp_path / "waves.png", tmp_path / "waves.parquet"
    quick = ["waves", "--elements", "10", "10", "--until", "30 ms"]
    assert "MPa" in cli(*quick, "--plot", plot, "-o", table)
    assert mpimg.imread(plot).shape[0] > 500
    stress = pd.read_parquet(table)["stress"]
    assert stress.min() < -1e8
