"""Values that are accepted but hardly meant cause one warning."""

import pytest
from dth_hammer import Coupling, Hammer, HammerWarning, simulate

PRESSURE = {"drive.source": "Pressure"}
AIR = {"drive.source": "Air"}


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"drive_pressure": 1e6}, "drive_pressure is ignored: drive.source is Relay"),
        (PRESSURE | {"drive.amplitude": 2e3, "drive_pressure": 1e6}, "drive.amplitude is ignored"),
        ({"bit.length": 168.0}, "bit.length = 168 m is 1000 times .* is the unit right"),
        ({"feed_force": 5.0}, "feed_force = 5 N is 0.001 times"),
        # Values that are 0 in the reference hammer are compared with usual ones; a temperature in
        # degrees.
        (PRESSURE | {"drive_pressure": 24.0}, "drive_pressure = 24 Pa is 4.8e-6 times a usual"),
        (
            {"drive.source": "Force", "drive_force": 4.0},
            "drive_force = 4 N is 0.0008 times a",
        ),
        ({"casing.mass": 5e4}, "casing.mass = 50000 kg is 1000 times a usual 50 kg: is the unit"),
        (AIR | {"air.temperature": 27.0}, "air.temperature = 27 K is .*: is the unit right"),
        ({"piston.segment[3].area": 2e-3}, r"piston\.segment\[3\]\.area is ignored: piston"),
        # Hammers that cannot drill.
        ({"feed_force": "-50 kN"}, "feed_force = -50000.0 N lifts the hammer off the rock"),
        ({"drive.amplitude": 10.0}, "a piston at rest stays at rest"),
        ({"air.port_height": 1e-3}, "only Air reads it"),
        ({"drive.area_drive": 2e-3}, "only Pressure, Air read it"),
        (
            {"bit.length": 0.2, "bit.segments": 1, "bit.segment[1].length": 0.168},
            "bit.length is ignored: bit.segments is 1",
        ),
    ],
)
def test_a_doubtful_parameter(parameters: dict[str, float | str], message: str) -> None:
    with pytest.warns(HammerWarning, match=message) as warned:
        hammer = Hammer(parameters)
    with hammer:
        hammer.step(1e-4)
        hammer.step(1e-4)
        assert len(hammer.warnings) == 1
    assert len(warned) == 1
    # The warning is at the caller's line, not in this package.
    assert warned[0].filename == __file__


def test_an_input_set_on_the_way_that_nobody_reads() -> None:
    with Hammer() as hammer:
        with pytest.warns(HammerWarning, match="drive_force is ignored"):
            hammer.set(drive_force=1e3)
        # Once: a second warning would be an error here.
        hammer.set(drive_force=2e3)
        hammer.step(1e-4)


def test_a_source_without_its_inputs() -> None:
    message = "drive.source is Pressure, but nothing sets drive_pressure or return_pressure"
    with pytest.warns(HammerWarning, match=message) as warned:
        frame = simulate(PRESSURE, until=0.01)
    assert len(warned) == 1
    assert message in frame.warnings[0]


class Constant:
    """A partner that returns pressures."""

    def outputs(self) -> dict[str, float]:
        return {"drive_pressure": 1e6}

    def advance(self, *_: object) -> None: ...


def test_nothing_is_said_where_nothing_is_wrong() -> None:
    # A warning is an error in these tests: see pyproject.toml.
    simulate({"rock.energy_barrier": 1e9, "gravity": 0.0}, until=0.01)
    simulate(PRESSURE, until=0.01, inputs={"drive_pressure": 1e6})
    with Hammer(PRESSURE) as hammer:
        Coupling(hammer, Constant(), 1e-3).advance(0.01)
