"""Assertions for tests of a drive or a controller of a hammer."""

from __future__ import annotations

from .frames import pd
from .simulation.hammer import Hammer
from .simulation.run import Run

WORKS = ("energy_drive", "energy_gravity", "energy_feed")


def assert_energy_balanced(subject: Hammer | Run, relative: float = 1e-9) -> None:
    """Asserts that the energy balance closes, within a fraction of the work done.

    Example:
        >>> from dth_hammer import simulate
        >>> from dth_hammer.testing import assert_energy_balanced
        >>> assert_energy_balanced(simulate(until="200 ms"))
    """
    names = [*WORKS, "energy_residual"]
    if isinstance(subject, Hammer):
        table = pd.DataFrame([subject.get(names)])
    else:
        table = subject.convert("si").frame[names]
    done = table[list(WORKS)].abs().sum(axis=1).max()
    worst = table["energy_residual"].abs().max()
    assert worst <= relative * done, (
        f"energy is off by {worst:.3g} J after {done:.3g} J of work, more than {relative:g} of it"
    )


def assert_periodic(run: Run, relative: float = 1e-3, last: int = 3) -> None:
    """Asserts that the last blows have equal periods and equal impact speeds.

    Example:
        >>> from dth_hammer import simulate
        >>> from dth_hammer.testing import assert_periodic
        >>> assert_periodic(simulate(until="600 ms"))
    """
    table = run.blows
    assert len(table) > last, f"only {len(table)} blows, {last + 1} are needed"
    for column in ("blow_period", "blow_speed"):
        values = table[column].iloc[-last:]
        spread = (values.max() - values.min()) / values.mean()
        listed = ", ".join(f"{v:.6g}" for v in values)
        assert spread <= relative, f"{column} still varies by {spread:.2g}: {listed}"
