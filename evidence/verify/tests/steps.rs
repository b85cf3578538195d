//! Stepped bodies that meet, against exact waves by characteristics: at a step from impedance
//! `Z1` to `Z2` a velocity wave passes on `2 Z1 / (Z1 + Z2)` of itself (a force wave
//! `2 Z2 / (Z1 + Z2)`) and sends back `(Z1 - Z2) / (Z1 + Z2)`.
//!
//! Sections are whole cells long, so every front is at a cell's end at every whole transit of
//! a cell. Half a cell behind, the engine's fronts have died away: they are as wide as the
//! contact and the damping make them, a twentieth of a cell.

use hammer::{Fidelity, InputValues, Machine, Parameters, Segment, Source};
use oracles::waves::{Scene, Waves};
use verify::scene::sharp;

const CELL: f64 = 0.08;
const SPEED: f64 = 8.0;

fn scene(piston: &[(usize, f64)], bit: &[(usize, f64)]) -> (Parameters, InputValues) {
    let mut p = Parameters { fidelity: Fidelity::Elastic, ..Parameters::default() };
    let fill = |segment: &mut [Segment], body: &[(usize, f64)]| {
        for (s, &(cells, area)) in segment.iter_mut().zip(body) {
            *s = Segment { length: cells as f64 * CELL, area };
        }
    };
    fill(&mut p.piston.segment, piston);
    fill(&mut p.bit.segment, bit);
    (p.piston.segments, p.bit.segments) = (piston.len(), bit.len());
    // Spans of 2 mm.
    let spans = |body: &[(usize, f64)]| body.iter().map(|s| s.0).sum::<usize>() * 40;
    (p.mesh.degree, p.piston.elements, p.bit.elements) = (5, spans(piston), spans(bit));
    (p.piston.initial_velocity, p.contact.initial_gap) = (SPEED, 1e-4);
    (p.gravity, p.drive.source) = (0.0, Source::Force);
    // The contact's exponential front, `c Z / KC` long: 1.4 mm at most, `exp(-28)` half a cell on.
    p.contact.stiffness = 2e11;
    // A bit in the air: a pull too weak to be seen, over rock that is not there.
    (p.rock.stiffness, p.rock.viscosity, p.rock.energy_barrier) = (1.0, 0.0, 0.0);
    (p, InputValues { feed_force: -1e-9, ..InputValues::default() })
}

/// Stresses and velocities at the middles of all cells, at every transit until the force has
/// gone. Of a front half a cell away, the contact leaves `exp(-28)`, times a few where it was
/// met again, and the damping `erfc(40 mm / c sqrt(beta t))`, below 1e-8 up to the sixth
/// transit; the mesh has a ripple that the damping has 15 us to still: 1e-6 of the speed.
fn check(piston: &[(usize, f64)], bit: &[(usize, f64)]) -> usize {
    let (p, inputs) = scene(piston, bit);
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    let (c, rho) = (p.wave_speed(), p.material.density);
    let impact = p.contact.initial_gap / SPEED;
    // The force of the drive is none, and no relay's.
    let exact = Scene { stiffness: 0.0, feed: 0.0, drive: [0.0, 1.0], ..sharp(&p, &inputs) };
    // It stops at its own steps, a fortieth of a cell late at most.
    let mut waves = Waves::new(exact, 120);
    let sections = |body: &[(usize, f64)]| -> Vec<(usize, f64)> {
        let cells = |(section, &(cells, _)): (usize, &(usize, f64))| {
            (0..cells).map(move |cell| (section, (cell as f64 + 0.5) / cells as f64))
        };
        body.iter().enumerate().flat_map(cells).collect()
    };
    let places = [sections(piston), sections(bit)];
    for step in 1..12 {
        let pushed = waves.collisions.first().map_or(0.0, |first| first.push);
        waves.advance(impact + step as f64 * CELL / c);
        if waves.collisions[0].push - pushed < 0.5 * CELL / c {
            return step - 1;
        }
        machine.advance(waves.time).expect("a run");
        let profile = machine.profile();
        let nodes = [&profile.piston[..], &profile.bit[..]];
        let stresses = [&profile.piston_stress[..], &profile.bit_stress[..]];
        for body in 0..2 {
            for (cell, &(section, part)) in places[body].iter().enumerate() {
                // A node, and the mean of the spans on either side of it.
                let (at, stress) = (40 * cell + 20, stresses[body]);
                let (velocity, sigma) = (nodes[body][at][1], 0.5 * (stress[at - 1] + stress[at]));
                let [down, up] = waves.inside(body, section, part);
                let what = format!("{piston:?} {bit:?} step {step} body {body} cell {cell}");
                assert!((velocity - (down + up)).abs() < 1e-6 * SPEED, "{what}: {velocity}");
                let sigma = -sigma / (rho * c);
                assert!((sigma - (down - up)).abs() < 1e-6 * SPEED, "{what}: {sigma}");
            }
        }
    }
    12
}

/// Closed: `v Z1 Z2 / (Z1 + Z2)` when two sections meet, and `2 Z2 / (Z1 + Z2)` of a force
/// that comes to a step.
#[test]
fn unequal_sections_meet_and_pass_a_step_on_as_the_closed_forms_say() {
    let (a, b, d) = (2e-3, 3e-3, 1e-3);
    let (mut p, inputs) = scene(&[(3, a)], &[(1, b), (2, d)]);
    // Looked at half a cell behind the front or more, which may be softer then: less ripple.
    p.contact.stiffness = 1e11;
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

#[test]
fn stepped_bodies_carry_the_waves_of_the_characteristics() {
    let (a, b, d) = (2.7e-3, 1.7e-3, 4e-3);
    assert_eq!(check(&[(2, a)], &[(2, a)]), 4);
    assert!(check(&[(2, a), (1, b)], &[(1, b), (2, d)]) >= 4);
    assert!(check(&[(1, b), (1, d), (1, a)], &[(2, a), (1, b)]) >= 4);
}
