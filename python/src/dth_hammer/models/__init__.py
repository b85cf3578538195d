"""Models of what drives and feeds the hammer, to couple and to copy: water, and a compressor."""

from collections.abc import Callable

#: Position (m) and velocity (m/s) of the piston over the bit by time, s.
Motion = Callable[[float], tuple[float, float]]
State = tuple[float, ...]


def runge_kutta(
    rates: Callable[[State, float, float], State], y: State, start: float, h: float, motion: Motion
) -> State:
    """The state after one classical Runge-Kutta step of size ``h``, s.

    Args:
        rates: of a state, given the piston's position and velocity.
        y: the state at ``start``.
        start: s, in the time of ``motion``.
        h: s.
        motion: of the piston.
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
