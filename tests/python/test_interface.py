"""The interface that hosts rely on, variable by variable, read from the packaged FMU."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.model_description import ModelDescription, ScalarVariable
from fmu import Instance, Package
from programs import ran

# Parameters by type and variability.
PARAMETERS = {
    ("Enumeration", "fixed"): "fidelity drive.source",
    ("Integer", "fixed"): "piston.elements bit.elements",
    ("Real", "tunable"): """rock.stiffness rock.unloading_ratio rock.viscosity rock.energy_barrier
        drive.amplitude""",
    ("Real", "fixed"): """material.youngs_modulus material.density material.damping_time
        cross_section piston.length bit.length contact.stiffness contact.initial_gap
        piston.initial_velocity rock.standstill_speed rock.standstill_penetration drive.stroke
        drive.area_drive drive.area_return gravity""",
}
INPUTS = """feed_force drive_force drive_pressure return_pressure
    supply_pressure exhaust_pressure"""
# Inputs on which an output depends directly: the drive's force, and the vented chambers on the
# exhaust.
FED = {
    "drive_line_pressure": ["drive_pressure"],
    "return_line_pressure": ["return_pressure"],
    "applied_drive_force": [*INPUTS.split()[1:4], "exhaust_pressure"],
    "drive_chamber_pressure": ["exhaust_pressure"],
    "return_chamber_pressure": ["exhaust_pressure"],
}
OUTPUTS = """piston_position piston_velocity bit_position bit_velocity bit_tip_position
    bit_tip_velocity relative_position relative_velocity contact_gap contact_force rock_force
    applied_drive_force tip_depth contact_impulse rock_impulse contact_count blow_count
    rock_cycle_count event_count contact_force_peak rock_force_peak blow_time blow_speed
    blow_energy blow_period blow_penetration rop rop_mean tip_rate tip_rate_mean
    energy_drive energy_gravity energy_feed
    energy_kinetic energy_strain energy_contact energy_rock_stored energy_rock_dissipated
    energy_viscous energy_damping energy_residual"""
LOCALS = {"contact_closed": "Boolean", "stalled": "Boolean", "rock_mode": "Enumeration"}
ENUMERATIONS = {
    "fidelity": ["Rigid", "Elastic"],
    "drive.source": ["Relay", "Force", "Pressure", "Air"],
    "rock_mode": ["FreeFlight", "DissipativeForward", "Forward", "Backward", "Standstill"],
}
DISPLAY_UNITS = {"m": "mm", "s": "ms", "N": "kN", "Pa": "bar", "m/s": "m/min"}


@pytest.fixture(scope="module")
def description(fmu_path: Path) -> ModelDescription:
    return read_model_description(str(fmu_path))


@pytest.fixture(scope="module")
def variables(description: ModelDescription) -> dict[str, ScalarVariable]:
    return {variable.name: variable for variable in description.modelVariables}


def test_parameters(variables: dict[str, ScalarVariable]) -> None:
    for (kind, variability), names in PARAMETERS.items():
        for name in names.split():
            found = variables[name]
            assert (found.type, found.variability) == (kind, variability), name
            assert (found.causality, found.initial) == ("parameter", "exact"), name


def test_ports_are_real_and_flat(variables: dict[str, ScalarVariable]) -> None:
    ports = dict.fromkeys(INPUTS.split(), "input") | dict.fromkeys(OUTPUTS.split(), "output")
    assert {name: variables[name].causality for name in ports} == ports
    for variable in variables.values():
        if variable.causality in ("input", "output"):
            assert variable.type == "Real", variable.name
            assert "." not in variable.name
    assert float(variables["feed_force"].start) == 5000.0


def test_local_variables_and_enumerations(variables: dict[str, ScalarVariable]) -> None:
    for name, kind in LOCALS.items():
        assert (variables[name].causality, variables[name].type) == ("local", kind), name
    for name, items in ENUMERATIONS.items():
        found = variables[name].declaredType.items
        assert [(item.name, int(item.value)) for item in found] == [
            (item, number) for number, item in enumerate(items, 1)
        ]


def test_every_variable_says_what_it_is(
    description: ModelDescription, variables: dict[str, ScalarVariable]
) -> None:
    assert description.variableNamingConvention == "structured"
    units = {unit.name: unit for unit in description.unitDefinitions}
    for name, variable in variables.items():
        assert variable.description, name
        if variable.type == "Real":
            assert variable.unit in units, name
            # Only a variable that starts at zero and has no bounds has no nominal value.
            assert float(variable.nominal or 0.0) > 0.0 or float(variable.start) == 0.0, name
    for unit, display in DISPLAY_UNITS.items():
        assert display in [display_unit.name for display_unit in units[unit].displayUnits], unit


def test_the_model_structure_is_exact(
    description: ModelDescription, variables: dict[str, ScalarVariable]
) -> None:
    order = list(variables)
    outputs = [name for name in order if variables[name].causality == "output"]
    assert [unknown.variable.name for unknown in description.outputs] == outputs
    for unknown in description.outputs:
        # A missing attribute would mean a dependence on everything.
        assert unknown.dependencies is not None, unknown.variable.name
        fed = [variable.name for variable in unknown.dependencies]
        assert fed == FED.get(unknown.variable.name, []), unknown.variable.name
    initial = [order.index(unknown.variable.name) for unknown in description.initialUnknowns]
    assert initial == sorted(set(initial))
    assert float(description.defaultExperiment.stepSize) > 0.0


def test_the_start_values_are_the_published_reference(package: Package) -> None:
    # The numbers are repeated on purpose: they come from the publication, not from the table.
    published = Path(__file__).parent / "data" / "reference.json"
    for name, value in json.loads(published.read_text()).items():
        assert package.start(name) == value, name


def test_outputs_are_related_as_they_are_described(fmu_path: Path, package: Package) -> None:
    """Checks relations over two blows in steps of 10 us, short enough to resolve collisions."""
    result = simulate_fmu(
        str(fmu_path),
        stop_time=0.07,
        output_interval=1e-5,
        output=[*OUTPUTS.split(), *LOCALS],
    )
    value = {name: np.asarray(result[name], dtype=float) for name in result.dtype.names}

    def same(found: np.ndarray, expected: np.ndarray, size: float) -> None:
        """Compares up to the rounding of some sums of numbers of that size."""
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14 * size)

    same(value["relative_velocity"], value["piston_velocity"] - value["bit_velocity"], 20.0)
    closed = value["contact_closed"] > 0
    assert 0 < closed.sum() < len(closed)
    assert (value["contact_force"][~closed] == 0.0).all()
    assert (value["contact_force"] >= 0.0).all()
    # The gap is a difference of positions of some cm, and its rounding is multiplied by the
    # stiffness.
    stiffness = package.start("contact.stiffness")
    force = -stiffness * np.where(closed, value["contact_gap"], 0.0)
    same(value["contact_force"], force, 0.1 * stiffness)
    struck = value["blow_count"] > 0
    assert value["blow_count"][-1] == 2.0
    sizes = ("material.density", "cross_section", "piston.length")
    mass = np.prod([package.start(name) for name in sizes])
    same(value["blow_energy"], 0.5 * mass * value["blow_speed"] ** 2 * struck, 300.0)
    assert value["blow_time"][-1] < 0.07
    assert value["tip_rate"][-1] == pytest.approx(
        value["blow_penetration"][-1] / value["blow_period"][-1], rel=1e-12
    )
    for name in ("tip_depth", "contact_count", "rock_cycle_count", "event_count"):
        assert (np.diff(value[name]) >= 0.0).all(), name
    works = sum(value[f"energy_{name}"] for name in ("drive", "gravity", "feed"))
    held = sum(value[f"energy_{name}"] for name in ("kinetic", "strain", "contact", "rock_stored"))
    lost = sum(value[f"energy_{name}"] for name in ("rock_dissipated", "viscous", "damping"))
    residual = works - (held - held[0]) - lost
    same(value["energy_residual"], residual, 1e3)


# One process writes a state; the other reads it and goes on.
GO_ON = """
import sys
from fmu import Instance, Package
with Package(sys.argv[1]) as package, Instance(package, {"bit.length": 0.2}) as hammer:
    data = open(sys.argv[2], "rb").read()
    state = hammer.slave.deSerializeFMUstate(data)
    hammer.slave.setFMUstate(state)
    hammer.slave.freeFMUstate(state)
    hammer.time = 0.03
    hammer.advance(0.06)
    print([value.hex() for value in hammer.read(package.names("output"))])
"""


def test_a_state_goes_on_in_the_next_process(
    fmu_path: Path, package: Package, tmp_path: Path
) -> None:
    with Instance(package) as hammer:
        hammer.advance(0.03)
        state = hammer.slave.getFMUstate()
        data = hammer.slave.serializeFMUstate(state)
        hammer.slave.freeFMUstate(state)
        hammer.advance(0.06)
        expected = [float(value).hex() for value in hammer.read(package.names("output"))]
    file = tmp_path / "state"
    file.write_bytes(bytes(data))
    demo = {"PYTHONPATH": str(Path(__file__).parents[2] / "demo")}
    said = ran([sys.executable, "-c", GO_ON, fmu_path, file], env=os.environ | demo)
    assert said.strip() == str(expected)
