"""Exact waves in two bars: the continuum that every mesh approximates.

d'Alembert's solution is carried along characteristics: each bar is a pair of
delay lines, the piston/bit interface a rigid unilateral junction, the rock the
bilinear law without viscosity, barrier or feed. Discontinuities of the waves
are followed exactly from end to end; between them a wave is a chord per step,
so the error falls with the square of the step.

Units: piston length, wave speed, impedance and striking speed are 1. Then
`E A`, the transit `T1` and the piston's mass are 1 as well, and the rock's
stiffness is the model's `kappa = KR Lp / (E A)`.
"""

from __future__ import annotations

import heapq
from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field
from math import exp, inf

# Times closer than this, and forces and gaps below it, are equal: rounding.
TINY = 1e-12


@dataclass
class Scene:
    """What strikes what."""

    stiffness: float  # kappa; 0 leaves the bit's lower end free
    ratio: float = 1.0  # gamma
    bit_length: float = 1.0
    piston_speed: float = 1.0
    bit_speed: float = 0.0
    gap: float = 0.0  # inf: no piston


@dataclass
class Collision:
    """One spell of contact, `push` being the part of it that carries force."""

    start: float
    end: float = inf
    push: float = 0.0
    impulse: float = 0.0


class Line:
    """A delay line: what was sent into one end, in chords."""

    def __init__(self, delay: float, value: float) -> None:
        self.delay, self.times = delay, [-inf]
        self.chords = [(0.0, value, 0.0)]  # start, value there, slope

    def send(self, time: float, end: float, first: float, last: float) -> None:
        self.times.append(time)
        self.chords.append((time, first, (last - first) / (end - time)))

    def arrival(self, time: float, before: bool = False) -> float:
        """What comes out at `time`: just after it, or just before it."""
        sent = time - self.delay
        if before:
            index = bisect_left(self.times, sent - TINY) - 1
        else:
            index = bisect_right(self.times, sent + TINY) - 1
        start, value, slope = self.chords[index]
        return value + slope * (sent - start)


def relax(q: float, first: float, slope: float, stiff: float, time: float) -> tuple[float, float]:
    """Indentation and its rate after `time` under an incident wave `first + slope t`."""
    if stiff == 0.0:
        return q + (2 * first + slope * time) * time, 2 * (first + slope * time)
    drift = 2 * slope / stiff
    offset = (2 * first - drift) / stiff
    decay = (q - offset) * exp(-stiff * time)
    return offset + drift * time + decay, drift - stiff * decay


@dataclass
class Waves:
    """One blow followed along characteristics."""

    scene: Scene
    step: float
    time: float = 0.0
    gap: float = 0.0
    closed: bool = False
    tip: float = 0.0
    rock: str = "FF"
    lower: float = 0.0
    upper: float = 0.0
    dissipated: float = 0.0  # work that the rock does not give back
    rock_peak: float = 0.0
    rock_end: float = inf  # last lift-off
    impulse: float = 0.0
    collisions: list[Collision] = field(default_factory=list)
    history: list[tuple[float, float, float]] = field(default_factory=list)  # t, F_C, F_R

    def __post_init__(self) -> None:
        s = self.scene
        self.gap = s.gap
        self.piston_down, self.piston_up = (Line(1.0, s.piston_speed / 2) for _ in range(2))
        self.bit_down, self.bit_up = (Line(s.bit_length, s.bit_speed / 2) for _ in range(2))
        self.ticks = 0
        self.jumps = [0.0]

    @property
    def piston_speed(self) -> float:
        """Mean velocity of the piston, by its momentum."""
        return self.scene.piston_speed - self.impulse

    def line(self) -> tuple[float, float]:
        """Stiffness and origin of the rock's current line."""
        if self.rock == "FF":
            return 0.0, 0.0
        if self.rock == "FC":
            return self.scene.stiffness, self.lower
        return self.scene.ratio * self.scene.stiffness, self.upper

    def settle(self) -> None:
        """Transitions at this instant, contact first."""
        for _ in range(10):
            piston, bit = self.piston_down.arrival(self.time), self.bit_up.arrival(self.time)
            incident = self.bit_down.arrival(self.time)
            if not self.closed and self.gap <= TINY and piston > bit + TINY:
                self.closed, self.gap = True, 0.0
                self.collisions.append(Collision(self.time))
                self.jump(self.time)
            elif self.closed and piston < bit - TINY:
                self.closed, self.collisions[-1].end = False, self.time
            elif not self.settle_rock(incident):
                return
        raise RuntimeError(f"endless transitions at {self.time}")

    def settle_rock(self, incident: float) -> bool:
        stiff, origin = self.line()
        rate = 2 * incident - stiff * (self.tip - origin)
        if self.rock == "FF" and self.scene.stiffness > 0:
            touching = self.tip >= self.lower - TINY and rate > TINY
            if touching:
                self.rock = "FC"
            return touching
        if self.rock == "FC" and rate < -TINY:
            self.upper = self.tip - (self.tip - self.lower) / self.scene.ratio
            self.rock = "BC"
            return True
        if self.rock == "BC" and self.tip <= self.upper + TINY and rate < TINY:
            self.rock, self.lower, self.rock_end = "FF", self.upper, self.time
            return True
        if self.rock == "BC" and rate > TINY:
            self.rock = "FC"
            self.lower = self.tip - self.scene.ratio * (self.tip - self.upper)
            return True
        return False

    def jump(self, time: float) -> None:
        """A discontinuity at the contact: when it will be at an end again."""
        for arrival in (time + 1.0, time + self.scene.bit_length):
            heapq.heappush(self.jumps, arrival)

    def advance(self, until: float) -> None:
        """Steps to the first step's end at or past `until`."""
        while self.time < until - TINY:
            self.settle()
            while self.jumps and self.jumps[0] <= self.time + TINY:
                # Where it came from does not matter: it leaves for every end.
                time = heapq.heappop(self.jumps)
                while self.jumps and self.jumps[0] <= time + TINY:
                    heapq.heappop(self.jumps)
                self.jump(time)
            while self.ticks * self.step <= self.time + TINY:
                self.ticks += 1
            end = min(self.ticks * self.step, self.jumps[0] if self.jumps else inf)
            self.move(self.first_event(end))

    def first_event(self, end: float) -> float:
        """The earliest change of sign in the step, by bisection of exact expressions."""
        span = end - self.time
        piston, bit = self.ends(self.piston_down, end), self.ends(self.bit_up, end)
        incident = self.ends(self.bit_down, end)
        slopes = [(b - a) / span for a, b in (piston, bit, incident)]
        stiff, origin = self.line()
        first = 0.0 if self.rock == "FF" else self.tip - origin

        def signs(t: float) -> tuple[bool, ...]:
            force = piston[0] - bit[0] + (slopes[0] - slopes[1]) * t
            gap = self.gap - (2 * (piston[0] - bit[0]) + (slopes[0] - slopes[1]) * t) * t
            q, rate = relax(first, incident[0], slopes[2], stiff, t)
            contact = force < -TINY if self.closed else gap < 0 and force > TINY
            if self.rock == "FF":
                return contact, self.scene.stiffness > 0 and self.tip + q > self.lower and rate > 0
            if self.rock == "FC":
                return contact, rate < -TINY
            return contact, q < 0 or rate > TINY

        if not any(signs(span)):
            return end
        low, high = 0.0, span
        while high - low > TINY / 10:
            middle = (low + high) / 2
            low, high = (low, middle) if any(signs(middle)) else (middle, high)
        return self.time + high

    def ends(self, line: Line, end: float) -> tuple[float, float]:
        return line.arrival(self.time), line.arrival(end, before=True)

    def move(self, end: float) -> None:
        """Commits one step, in which nothing changes its status."""
        span = end - self.time
        piston, bit = self.ends(self.piston_down, end), self.ends(self.bit_up, end)
        top, incident = self.ends(self.piston_up, end), self.ends(self.bit_down, end)
        stiff, origin = self.line()
        before = self.tip - origin
        after, _ = relax(before, incident[0], (incident[1] - incident[0]) / span, stiff, span)
        rock = (stiff * before, stiff * after)
        self.piston_down.send(self.time, end, *top)
        self.bit_up.send(self.time, end, incident[0] - rock[0], incident[1] - rock[1])
        force = (0.0, 0.0)
        if self.closed:
            self.piston_up.send(self.time, end, *bit)
            self.bit_down.send(self.time, end, *piston)
            force = (piston[0] - bit[0], piston[1] - bit[1])
            push = sum(force) / 2 * span
            self.impulse += push
            self.collisions[-1].impulse += push
            self.collisions[-1].push += span if max(force) > 1e3 * TINY else 0.0
        else:
            self.piston_up.send(self.time, end, *piston)
            self.bit_down.send(self.time, end, *bit)
            self.gap += (sum(bit) - sum(piston)) * span
        if self.rock == "FC":
            self.dissipated += (1 - 1 / self.scene.ratio) * stiff * (after**2 - before**2) / 2
        self.rock_peak = max(self.rock_peak, *rock)
        self.history.append((self.time, force[0], rock[0]))
        self.tip, self.time = origin + after, end


def blow(scene: Scene, until: float, steps: int = 2000) -> Waves:
    """Follows a scene to `until`, in piston transits, with `steps` steps per transit."""
    waves = Waves(scene, 1.0 / steps)
    waves.advance(until)
    return waves
