"""A pytest plugin with a hammer, for tests of a drive or a controller.

It is installed with the package. The fixture ``hammer`` is a running reference hammer; a marker
gives it other parameters::

    @pytest.mark.hammer({"drive.source": "Pressure"}, rock="granite")
    def test_my_controller(hammer, assert_energy_balanced): ...
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .simulation.hammer import Hammer


def pytest_configure(config: pytest.Config) -> None:
    """Registers the marker."""
    text = "hammer(parameters, preset=None): what the hammer fixture is made of"
    config.addinivalue_line("markers", text)


@pytest.fixture
def make_hammer() -> Iterator[Callable[..., Hammer]]:
    """Returns a function that makes hammers; they are closed after the test."""
    # Imported here, so that a test session without a hammer starts as fast as before.
    from .simulation.hammer import Hammer  # noqa: PLC0415

    made: list[Hammer] = []

    def make(*arguments: Any, **named: Any) -> Hammer:
        made.append(Hammer(*arguments, **named))
        return made[-1]

    yield make
    for hammer in made:
        hammer.close()


@pytest.fixture
def hammer(request: pytest.FixtureRequest, make_hammer: Callable[..., Hammer]) -> Hammer:
    """Returns a hammer at time 0: the reference, unless a marker gives other parameters."""
    marker = request.node.get_closest_marker("hammer")
    return make_hammer(*marker.args, **marker.kwargs) if marker else make_hammer()


@pytest.fixture
def assert_energy_balanced() -> Callable[..., None]:
    """Returns a function that asserts that no energy is created or lost; see `testing`."""
    from . import testing  # noqa: PLC0415

    return testing.assert_energy_balanced


@pytest.fixture
def assert_periodic() -> Callable[..., None]:
    """Returns a function that asserts that the last blows are equal; see `testing`."""
    from . import testing  # noqa: PLC0415

    return testing.assert_periodic
