//! Scenes that broke the engine once: found by the properties, shrunk, kept.

use hammer::{Fidelity, InputValues, Machine, Parameters};
use serde_json::Value;
use verify::drawn::stored::scene;
use verify::laws::properties::PROPERTIES;

/// What the shrunk scenes share: rigid, undamped, weightless, the piston on the bit, soft
/// rock without viscosity, barrier or standstill.
fn shrunk(section: f64, lengths: [f64; 2]) -> Parameters {
    let mut p = verify::rows::mesh::bare(1);
    p.fidelity = Fidelity::Rigid;
    (p.material.youngs_modulus, p.material.density) = (1e9, 1e3);
    p.cross_section = section;
    (p.piston.length, p.bit.length) = (lengths[0], lengths[1]);
    p.piston.initial_velocity = 0.0;
    (p.contact.stiffness, p.contact.initial_gap) = (1e7, 0.0);
    (p.rock.stiffness, p.rock.unloading_ratio) = (1e5, 2.0);
    p
}

fn feed(force: f64) -> InputValues {
    InputValues { feed_force: force, ..verify::rows::mesh::no_inputs() }
}

/// Bodies a metre away from the origin closed at 7 km/s with a gap above its resolution by
/// rounding; that was taken for an opening, and that again for a closing, without end.
#[test]
fn rounding_at_a_closing_is_no_opening() {
    let mut p = shrunk(1e-4, [0.04, 1.0]);
    (p.drive.amplitude, p.drive.stroke) = (23422.0, 1.0);
    let mut m = Machine::new(&p, &feed(0.0), 0.0).unwrap();
    m.advance(0.01).unwrap();
}

/// The damping work of rigid bodies in contact was 0 / 0 when `beta` was not zero.
#[test]
fn rigid_bodies_in_contact_lose_nothing_to_damping() {
    let mut p = shrunk(4e-5, [0.66, 0.04]);
    p.material.damping_time = 1e-4;
    let mut m = Machine::new(&p, &feed(-1.0), 0.0).unwrap();
    m.advance(1e-3).unwrap();
    assert!(m.mode().closed());
    assert_eq!(m.energies().damping, 0.0);
}

/// A gap that starts at zero with no speed and closes was looked at after a millisecond,
/// 5 nm deep. It reaches the resolution after `sqrt(2 r / a)`.
#[test]
fn a_gap_that_closes_from_rest_is_found_at_once() {
    let p = shrunk(0.09, [1.0, 1.0]);
    let mut m = Machine::new(&p, &feed(-1.0), 0.0).unwrap();
    m.keep_journal(true);
    m.advance(2e-3).unwrap();
    let first = m.take_journal()[0];
    let acceleration = 1.0 / p.bit_mass();
    let late = (2.0 * p.resolutions()[0] / acceleration).sqrt();
    assert!(first.event.is_contact());
    assert!(first.time <= late, "{} after {late}", first.time);
}

fn assert_stored(name: &str) {
    let stored: Vec<Value> = serde_json::from_str(include_str!("found.json")).expect("JSON");
    let object = stored.into_iter().find(|object| object["name"] == name);
    let object = object.expect("a scene of this name");
    let (wrong, scene) = (object["wrong"].to_string(), scene(object));
    for (property, holds) in PROPERTIES {
        assert!(holds(&scene).is_ok(), "{property} (once: {wrong}): {:?}", holds(&scene));
    }
}

/// Declares a test a kept scene.
macro_rules! stored {
    ($($name:ident),* $(,)?) => {
        $(#[test] fn $name() { assert_stored(stringify!($name)); })*
    };
}

stored! {
    touches_in_the_precursor,
    standstill_under_a_newton,
    contact_and_rock_by_picometres,
    pushed_off_stiff_rock,
    heavy_piston_on_a_light_bit,
    heavy_piston_under_feed,
    heavy_piston_at_gamma_one,
    heavy_piston_on_soft_rock,
    light_bit_overdamped,
}

/// Of a fine mesh most modes are overdamped and crowd at `-1 / beta`; the sum of the
/// eigenvalues was not met, and the scene was refused.
#[test]
fn crowded_overdamped_modes_are_told_apart() {
    let mut p = verify::rows::closed::blow_scene(0.3, 5.0, 160);
    p.material.damping_time = 0.01 * p.timescales().piston_transit;
    p.contact.stiffness = 20.0 * verify::rows::mesh::stretch(&p) / p.piston.length;
    let mut m = Machine::new(&p, &verify::rows::mesh::no_inputs(), 0.0).unwrap();
    m.advance(9.0 * p.timescales().piston_transit).unwrap();
    assert_eq!(m.counters().blows, 1);
}
