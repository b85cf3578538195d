"""The characteristics oracle against closed forms; no FMU is involved."""

from __future__ import annotations

from math import exp, inf

import pytest
from oracle_waves import Scene, Waves, blow

# Published to five digits: half a unit of the last one, and nothing for the
# oracle itself, whose chords err by (kappa step)^2 / 8, below 2e-7.
FIVE = 0.51e-5
STEPS = 1000


@pytest.mark.parametrize("bit_length", [1.0, 2.3, 0.4])
def test_two_bars_exchange_momentum_as_saint_venant_says(bit_length: float) -> None:
    struck = blow(Scene(0.0, bit_length=bit_length), until=6.0, steps=100)
    shorter = min(1.0, bit_length)
    (collision,) = struck.collisions
    # Waves constant between jumps are carried exactly: only sums round.
    assert collision.push == pytest.approx(2 * shorter, abs=1e-9)
    assert collision.impulse == pytest.approx(shorter, abs=1e-9)
    assert struck.piston_speed == pytest.approx(1 - shorter, abs=1e-9)
    assert max(force for _, force, _ in struck.history) == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize("stiffness", [0.05, 0.2, 0.5, 1.0, 2.0, 5.0])
def test_a_free_bar_on_a_spring_follows_the_exponentials(stiffness: float) -> None:
    bar = blow(Scene(stiffness, gap=inf, bit_speed=1.0), until=3.9, steps=STEPS)
    # A chord strays from an exponential by (k step)^2 / 8; two reflections add up.
    close = (stiffness / STEPS) ** 2 / 2 + 1e-12
    for time, _, force in bar.history:
        if force > 0:
            assert force == pytest.approx(on_spring(stiffness, time), abs=close)


def on_spring(k: float, s: float) -> float:
    """Force of a unit bar on a spring, up to the second reflection."""
    if s <= 2:
        return 1 - exp(-k * s)
    return (2 - exp(-2 * k) + 2 * k * (s - 2)) * exp(-k * (s - 2)) - 1


@pytest.mark.parametrize(
    ("stiffness", "peak", "contact"),
    [
        (0.05, 0.22171, 14.170),
        (0.2, 0.43045, 7.248),
        (0.5, 0.66397, 4.804),
        (1.0, 0.86914, 3.637),
        (2.0, 0.98177, 2.836),
        (5.0, 0.99995, 2.336),
    ],
)
def test_a_free_bar_on_a_spring_has_the_tabulated_peak_and_contact_time(
    stiffness: float, peak: float, contact: float
) -> None:
    bar = blow(Scene(stiffness, gap=inf, bit_speed=1.0), until=contact + 1, steps=STEPS)
    assert bar.rock_peak == pytest.approx(peak, abs=FIVE)
    # Tabulated to three decimals: a unit of the last.
    assert bar.rock_end == pytest.approx(contact, abs=1e-3)


@pytest.mark.parametrize("b", [0.4, 1.25643, 3.0])
def test_a_rectangular_pulse_leaves_the_rock_its_closed_form_share(b: float) -> None:
    ratio = 4.0
    pulse = blow(Scene(b / 2, ratio, bit_length=30.0), until=45.0, steps=STEPS)
    share = 2 * (1 - exp(-b)) ** 2 / b * (1 - 1 / ratio)
    assert 2 * pulse.dissipated == pytest.approx(share, abs=1e-6)


BLOWS = [
    (0.03, 5.0, 0.79186, 0.17232, -0.45615, 22.16),
    (0.1, 5.0, 0.77306, 0.31086, -0.47517, 11.59),
    (0.1, 10.0, 0.86969, 0.31086, -0.35953, 12.89),
    (0.3, 5.0, 0.72120, 0.52005, -0.52414, 6.317),
    (1.0, 5.0, 0.60433, 0.86914, -0.58976, 3.594),
]


@pytest.mark.parametrize("case", BLOWS, ids=lambda c: f"kappa={c[0]:g}-gamma={c[1]:g}")
def test_a_blow_on_virgin_rock_matches_the_published_waves(case: tuple[float, ...]) -> None:
    kappa, gamma, share, peak, speed, second = case
    waves = blow(Scene(kappa, gamma), until=second + 2.5, steps=STEPS)
    assert 2 * waves.dissipated == pytest.approx(share, abs=FIVE)
    assert waves.rock_peak == pytest.approx(peak, abs=FIVE)
    assert waves.piston_speed == pytest.approx(speed, abs=FIVE)
    assert len(waves.collisions) == 2
    # Four digits are published.
    assert waves.collisions[1].start == pytest.approx(second, rel=5.1e-4)


def test_the_chords_converge_with_the_square_of_the_step() -> None:
    def peak(steps: int) -> Waves:
        return blow(Scene(0.1, 5.0), until=15.0, steps=steps)

    exact = peak(1600).dissipated
    coarse, fine = (abs(peak(steps).dissipated - exact) for steps in (100, 200))
    assert 3.5 < coarse / fine < 4.5
