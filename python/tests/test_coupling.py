"""Coupling, against a partner whose answer is known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from dth_hammer import Coupling, DthHammerError, Hammer, Motion

# A spring as a partner: pressure proportional to the piston's position, a free
# oscillation while the piston flies.
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
    """State: the last position."""

    def __init__(self, position: float) -> None:
        self.start = self.position = position

    def outputs(self) -> dict[str, float]:
        return {"return_pressure": STIFFNESS * (self.position - self.start + 0.01)}

    def slopes(self, position: float, velocity: float) -> dict[str, float]:
        return {"return_pressure": STIFFNESS * velocity}

    def advance(self, size: float, motion: Callable[[float], tuple[float, float]]) -> None:
        self.position = motion(size)[0]

    def save(self) -> float:
        return self.position

    def restore(self, state: float) -> None:
        self.position = state


def flight(step: float, **options: Any) -> tuple[float, Coupling]:
    with Hammer(FLIGHT) as hammer:
        coupling = Coupling(hammer, Spring(hammer["relative_position"]), step, **options)
        coupling.advance(END)
        assert hammer.time == pytest.approx(END)
        return hammer["piston_velocity"], coupling


@pytest.fixture(scope="module")
def exact() -> float:
    return flight(2e-6)[0]


@pytest.mark.parametrize(
    ("scheme", "slopes", "order"),
    [
        ("jacobi", False, 1),
        ("jacobi", True, 1),
        ("gauss-seidel", False, 1),
        ("gauss-seidel", True, 2),
    ],
)
def test_errors_fall_with_the_step_in_their_order(
    exact: float, scheme: str, slopes: bool, order: int
) -> None:
    errors = [abs(flight(h, scheme=scheme, slopes=slopes)[0] - exact) for h in (4e-4, 1e-4)]
    assert errors[0] / errors[1] > 0.7 * 4**order


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


def test_an_unknown_scheme_is_refused() -> None:
    with Hammer(FLIGHT) as hammer, pytest.raises(DthHammerError, match="gauss"):
        Coupling(hammer, Spring(0.0), 1e-4, scheme="gauss")  # type: ignore[arg-type]
