"""A pytest plugin: a hammer for tests of what drives it.

Installed with the package. ``hammer`` is a live reference hammer; a marker changes it::

    @pytest.mark.hammer({"drive.source": "Pressure"}, rock="granite")
    def test_my_controller(hammer, assert_energy_balanced): ...
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .run.hammer import Hammer


def pytest_configure(config: pytest.Config) -> None:
    """Registers the marker."""
    text = "hammer(parameters, preset=None): what the hammer fixture is made of"
    config.addinivalue_line("markers", text)


@pytest.fixture
def make_hammer() -> Iterator[Callable[..., Hammer]]:
    """Makes hammers, as many as wanted, and closes them after the test."""
    # Imported late: a test session that has no hammer pays nothing.
    from .run.hammer import Hammer  # noqa: PLC0415

    made: list[Hammer] = []

    def make(*arguments: Any, **named: Any) -> Hammer:
        made.append(Hammer(*arguments, **named))
        return made[-1]

    yield make
    for hammer in made:
        hammer.close()


@pytest.fixture
def hammer(request: pytest.FixtureRequest, make_hammer: Callable[..., Hammer]) -> Hammer:
    """A hammer at time 0: the reference, unless a marker gives other parameters."""
    marker = request.node.get_closest_marker("hammer")
    return make_hammer(*marker.args, **marker.kwargs) if marker else make_hammer()


@pytest.fixture
def assert_energy_balanced() -> Callable[..., None]:
    """Asserts that no energy is created or lost; see `dth_hammer.testing`."""
    from . import testing  # noqa: PLC0415

    return testing.assert_energy_balanced


@pytest.fixture
def assert_periodic() -> Callable[..., None]:
    """Asserts that the last blows are equal; see `dth_hammer.testing`."""
    from . import testing  # noqa: PLC0415

    return testing.assert_periodic
