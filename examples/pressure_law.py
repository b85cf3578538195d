"""The paper's pressure law in both of its readings, compared with the simulator's relay.

    python examples/pressure_law.py          # a table

By the event functions (5) the force keeps its direction until the piston reaches the other end of
its stroke. By formula (3) it follows from the relative position and velocity alone. Both are
implemented outside the hammer, as a drive that is updated every few microseconds.
"""

from __future__ import annotations

from collections.abc import Callable

from dth_hammer import VARIABLES, Hammer

#: Communication step, s: a valve outside is late by half of it, 2e-5 of a period of 45 ms.
STEP = 2e-6
UNTIL = 0.6  # s: thirteen blows, the last ones equal
STROKE = VARIABLES["drive.stroke"].start or 0.0
FORCE = VARIABLES["drive.amplitude"].start or 0.0
#: Outputs of the last blow to read, with the factor of the unit in the table.
READ = {"blow_period": 1e3, "tip_rate": 1e3, "blow_speed": 1.0, "rop": 3600.0}

Law = Callable[[float, float, float], float]


def by_events(before: float, position: float, _: float) -> float:
    """Equation (5): the direction changes at the ends of the stroke."""
    if before > 0.0 and position > 0.0:
        return -1.0
    return 1.0 if before < 0.0 and position < -STROKE else before


def by_formula(_: float, position: float, velocity: float) -> float:
    """Equation (3): the direction follows from position and velocity."""
    beyond = position <= -STROKE
    return 1.0 if beyond or (position <= 0.0 and velocity >= 0.0) else -1.0


def driven(law: Law, until: float = UNTIL) -> list[float]:
    """Returns the last blow of a hammer that a law drives from outside."""
    with Hammer({"drive.source": "Force"}) as hammer:
        direction = 1.0
        hammer.set(drive_force=FORCE)
        read = hammer.reader(["relative_position", "relative_velocity"])
        for _ in range(round(until / STEP)):
            hammer.step(STEP)
            position, velocity = read()
            now = law(direction, position, velocity)
            if now != direction:
                direction = now
                hammer.set(drive_force=FORCE * direction)
        return last_blow(hammer)


def inside(until: float = UNTIL) -> list[float]:
    """Returns the last blow with the relay inside the simulator."""
    with Hammer() as hammer:
        hammer.advance(until)
        return last_blow(hammer)


def last_blow(hammer: Hammer) -> list[float]:
    """Returns the outputs in the units of the table."""
    return [factor * hammer[name] for name, factor in READ.items()]


def table() -> str:
    """Returns a table in Markdown, with a row for each reading."""
    readings = {
        "the relay inside": inside(),
        "(5), event functions, from outside": driven(by_events),
        "(3), a formula, from outside": driven(by_formula),
    }
    rows = ["| pressure law | period (ms) | tip's gain (mm/s) | impact (m/s) | rate (m/h) |"]
    rows.append("|---|---:|---:|---:|---:|")
    for name, (period, gain, speed, rate) in readings.items():
        rows.append(f"| {name} | {period:.2f} | {gain:.2f} | {speed:.3f} | {rate:.2f} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
