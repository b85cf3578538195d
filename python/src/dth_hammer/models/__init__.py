"""Example models to couple with the hammer, or to copy: a water drive and a compressor."""

from collections.abc import Callable

#: Position (m) and velocity (m/s) of the piston relative to the bit, as a function of time (s).
Motion = Callable[[float], tuple[float, float]]
State = tuple[float, ...]


def runge_kutta(
    rates: Callable[[State, float, float], State], y: State, start: float, h: float, motion: Motion
) -> State:
    """Returns the state after one classical Runge-Kutta step.

    Args:
        rates: returns the time derivative of a state, given the piston's position and velocity.
        y: the state at ``start``.
        start: beginning of the step, s, on the time axis of ``motion``.
        h: size of the step, s.
        motion: the piston's motion.
    """

    def along(rate: State, h: float) -> State:
        return tuple(value + h * slope for value, slope in zip(y, rate, strict=True))

    first, middle, last = motion(start), motion(start + h / 2), motion(start + h)
    a = rates(y, *first)
    b = rates(along(a, h / 2), *middle)
    c = rates(along(b, h / 2), *middle)
    d = rates(along(c, h), *last)
    mean = tuple((p + 2 * q + 2 * r + s) / 6 for p, q, r, s in zip(a, b, c, d, strict=True))
    return along(mean, h)
