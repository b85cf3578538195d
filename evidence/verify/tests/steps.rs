//! Stepped bodies that meet: at a step from impedance `Z1` to `Z2` a force wave is transmitted by the factor
//! `2 Z2 / (Z1 + Z2)`.

use hammer::{Fidelity, InputValues, Machine, Parameters, Segment, Source};

const CELL: f64 = 0.08;
const SPEED: f64 = 8.0;

/// The contact's exponential front is `c Z / KC` long, 2.8 mm at most, and damping removes the mesh's ripple: half a
/// cell behind the front, neither is 1e-6 of the force.
#[test]
fn unequal_sections_meet_and_pass_a_step_on_as_the_closed_forms_say() {
    let (a, b, d) = (2e-3, 3e-3, 1e-3);
    let mut p = Parameters { fidelity: Fidelity::Elastic, ..Parameters::default() };
    let section = |cells: f64, area| Segment { length: cells * CELL, area };
    p.piston.segments.set(&[section(3.0, a)]);
    p.bit.segments.set(&[section(1.0, b), section(2.0, d)]);
    (p.mesh.degree, p.piston.elements, p.bit.elements) = (5, 120, 120);
    (p.piston.initial_velocity, p.contact.initial_gap) = (SPEED, 1e-4);
    (p.gravity, p.drive.source, p.contact.stiffness) = (0.0, Source::Force, 1e11);
    // A bit in the air: a negligible pull, over rock of negligible stiffness.
    (p.rock.stiffness, p.rock.viscosity, p.rock.energy_barrier) = (1.0, 0.0, 0.0);
    let inputs = InputValues { feed_force: -1e-9, ..InputValues::default() };
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    let impact = p.contact.initial_gap / SPEED;
    let (transit, z) = (CELL / p.wave_speed(), p.impedance_of(1.0));
    let meeting = SPEED * z * a * b / (a + b);
    machine.advance(impact + 0.9 * transit).expect("a run");
    let force = machine.kinematics().contact_force;
    assert!((force / meeting - 1.0).abs() < 1e-6, "{force} {meeting}");
    machine.advance(impact + 1.6 * transit).expect("a run");
    let passed = -machine.profile().bit_stress[41] * d;
    let expected = meeting * 2.0 * d / (b + d);
    assert!((passed / expected - 1.0).abs() < 1e-6, "{passed} {expected}");
}
