"""Coupling with a partner whose solution is known."""

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from dth_hammer import (
    VARIABLES,
    Coupling,
    DthHammerError,
    Hammer,
    HammerWarning,
    Motion,
    _native,
)

# A partner that is a spring: pressure proportional to the piston's position, so a free oscillation
# while the piston flies.
STIFFNESS = 5e7  # Pa/m
AREA = 1e-3  # m2
FLIGHT = {
    "drive.source": "Pressure",
    "drive.area_drive": AREA,
    "drive.area_return": AREA,
    "gravity": 0.0,
}
END = 4e-3  # s, before the first contact


class Spring:
    """A spring, whose state is the last position."""

    def __init__(self) -> None:
        self.free = self.position = 0.0

    def start(self, position: float) -> None:
        self.free, self.position = position - 0.01, position

    def outputs(self) -> dict[str, float]:
        return {"return_pressure": STIFFNESS * (self.position - self.free)}

    def advance(self, size: float, motion: Callable[[float], tuple[float, float]]) -> None:
        self.position = motion(size)[0]

    def save(self) -> float:
        return self.position

    def restore(self, state: float) -> None:
        self.position = state


def flight(step: float | str, **options: Any) -> tuple[float, Coupling]:
    with Hammer(FLIGHT) as hammer:
        coupling = Coupling(hammer, Spring(), step, **options)
        coupling.advance(END)
        assert hammer.time == pytest.approx(END)
        return hammer["piston_velocity"], coupling


@pytest.fixture(scope="module")
def exact() -> float:
    return flight(2e-6)[0]


@pytest.mark.parametrize(
    ("scheme", "delay", "order"),
    [
        ("jacobi", 0.0, 1),
        ("jacobi", None, 2),
        ("gauss-seidel", 0.0, 1),
        ("gauss-seidel", None, 2),
    ],
)
def test_errors_fall_with_the_step_in_their_order(
    exact: float, scheme: Any, delay: float | None, order: int
) -> None:
    errors = [abs(flight(h, scheme=scheme, delay=delay)[0] - exact) for h in (4e-4, 1e-4)]
    assert errors[0] / errors[1] > 0.7 * 4**order


def test_what_a_held_pressure_makes_is_told_by_the_hammer() -> None:
    for delay in (0.0, 0.5):
        with Hammer(FLIGHT) as hammer:
            spring = Spring()
            Coupling(hammer, spring, 2e-5, delay=delay).advance(END)
            # Kinetic energy, and the spring's energy minus that of its first 10 mm.
            moved = hammer["relative_position"] - spring.free
            stored = 0.5 * STIFFNESS * AREA * (moved**2 - 0.01**2)
            made = energy(hammer) * hammer["piston_velocity"] ** 2 + stored
            # The last step waits for the next value, a share 3 h / END = 0.015 of a sum that grows
            # as t^2.
            assert hammer["energy_exchange"] == pytest.approx(made, rel=0.02, abs=1e-6)
            assert abs(made) > (1e-4 if delay == 0.0 else 0.0)


def by_coupling(hammer: Hammer, spring: Spring) -> None:
    Coupling(hammer, spring, 3e-4, delay=0.0).advance(0.6)


def by_a_loop(hammer: Hammer, spring: Spring) -> None:
    spring.start(hammer["relative_position"])
    for _ in range(2000):
        hammer.set(spring.outputs())
        hammer.step(3e-4)
        spring.position = hammer["relative_position"]


@pytest.mark.parametrize("run", [by_coupling, by_a_loop])
def test_an_exchange_that_makes_energy_warns_unasked(run: Callable[[Hammer, Spring], None]) -> None:
    """The warning comes before any blow, after eight turns of the piston, here 0.35 s."""
    with Hammer(FLIGHT | {"contact.initial_gap": 1.0}) as hammer:
        with pytest.warns(HammerWarning, match=r"energy_exchange: .* 0 the exchange") as told:
            run(hammer, Spring())
        texts = [str(warning.message) for warning in told]
        assert len(texts) == len(set(texts)) == len(hammer.warnings)
        assert "added" in texts[0]
        assert "set coupling.delay (0.5 if" in texts[0]


def energy(hammer: Hammer) -> float:
    """Returns half of the piston's mass, kg, which is its energy at 1 m/s."""
    ((length, area),) = _native.bodies(hammer.numbers)["piston"]["sections"]
    return 0.5 * length * area * (VARIABLES["material.density"].start or 0.0)


def test_a_history_has_the_steps_that_were_made_and_is_drawn() -> None:
    _, coupling = flight(1e-3, tolerance=1e2)
    table = coupling.history
    assert len(table) == coupling.accepted
    assert table.index[0] == 0.0
    assert (np.diff(table.index) > 0.0).all()
    # Each line ends where the next step begins.
    line, *_ = coupling.plot().axes[0].lines
    assert len(line.get_xdata()) == 2 * len(table)
    assert line.get_xdata()[-1] == pytest.approx(END)
    part = coupling.plot(last="1 ms").axes[1].lines[0].get_xdata()
    assert len(part) == (table.index >= END - 1e-3).sum()


def test_a_partner_starts_where_the_piston_stands() -> None:
    with Hammer(FLIGHT) as hammer:
        spring = Spring()
        Coupling(hammer, spring, 1e-4)
        assert spring.position == hammer["relative_position"] != 0.0
        coupling = Coupling(hammer, spring, 1e-4)
        coupling.advance(1e-3)
        moved = spring.position
        # A hammer that has already run takes over the partner in its present state.
        Coupling(hammer, spring, 1e-4)
        assert spring.position == moved


def test_rejected_steps_are_taken_back(exact: float) -> None:
    velocity, coupling = flight(1e-3, tolerance=1e2)
    assert coupling.rejected > 0
    assert velocity == pytest.approx(exact, rel=1e-3)
    loose, free = flight(1e-3)
    assert free.rejected == 0
    assert abs(velocity - exact) < abs(loose - exact)


def test_a_motion_between_two_points_passes_through_both() -> None:
    motion = Motion.between((1.0, 2.0), (1.5, -3.0), 0.1)
    assert motion(0.0) == pytest.approx((1.0, 2.0))
    assert motion(0.1) == pytest.approx((1.5, -3.0))


class Valve:
    """Reverses a force at both ends of a stroke, as the relay of the hammer does."""

    def __init__(self, stroke: float, force: float) -> None:
        self.stroke, self.force = stroke, force

    def outputs(self) -> dict[str, float]:
        return {"drive_force": self.force}

    def advance(self, size: float, motion: Callable[[float], tuple[float, float]]) -> None:
        position, _ = motion(size)
        at_top = self.force < 0.0 and position <= -self.stroke
        if at_top or (self.force > 0.0 and position >= 0.0):
            self.force = -self.force

    def save(self) -> float:
        return self.force

    def restore(self, state: float) -> None:
        self.force = state


def test_a_valve_that_steps_end_for_is_the_relay_inside() -> None:
    end, names = 0.25, ["blow_count", "blow_time", "blow_speed", "piston_position", "tip_depth"]
    with Hammer() as inside, Hammer({"drive.source": "Force"}) as hammer:
        valve = Valve(VARIABLES["drive.stroke"].start or 0.0, inside["applied_drive_force"])
        hammer.set(drive_force=valve.force)
        hammer.stop_at([-valve.stroke, 0.0])
        coupling = Coupling(hammer, valve, 0.05)
        coupling.advance(end)
        inside.advance(end)
        assert inside["blow_count"] > 3
        assert coupling.accepted < 60
        assert hammer.get(names) == pytest.approx(inside.get(names), abs=1e-10)


def test_steps_end_at_blows_and_go_on_so_from_a_saved_state() -> None:
    with Hammer() as whole, Hammer() as hammer, Hammer() as other:
        whole.advance(0.25)
        hammer.stop_at(blows=True)
        assert hammer.advance(0.25) == hammer["blow_time"] < 0.25
        other.restore(pickle.loads(pickle.dumps(hammer.save())))
        instants = []
        while other.time < 0.25:
            other.advance(0.25)
            instants.append(other.time)
        assert instants[-2] == other["blow_time"] == whole["blow_time"]
        assert other["piston_position"] == whole["piston_position"]
        hammer.stop_at()
        assert hammer.advance(0.25) == 0.25


def test_a_position_to_stop_at_is_a_length() -> None:
    with Hammer() as hammer:
        hammer.stop_at(["-30 mm"])
        assert hammer.advance(0.25) < 0.25
        assert hammer["relative_position"] == pytest.approx(-0.03, abs=1e-14)
        with pytest.raises(DthHammerError, match="relative_position"):
            hammer.stop_at(["3 s"])
