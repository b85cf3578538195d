//! By how much mesh, penalty and damping may displace a wave front.
//!
//! Consistent mass on elements of size `h` is dispersive: `omega = c k (1 + (k h)^2 / 24)`. A step that has run for a
//! time `t` is then the integral of an Airy function, of width `(c t h^2 / 8)^(1/3)`. Kelvin-Voigt damping spreads it
//! by `c sqrt(beta t)`, and the penalty delays it by `Z / (2 KC)`. The sum of these is the tolerance of an instant;
//! that of a force is the same times its steepest rate.

use hammer::{InputValues, Parameters};

/// A piston that strikes with `speed`, from a gap that it crosses at once. There are no loads, and the rock has
/// neither viscosity nor standstill.
pub fn bare(elements: usize) -> Parameters {
    let mut p = Parameters::default();
    p.mesh.degree = 1;
    (p.piston.elements, p.bit.elements) = (elements, elements);
    p.piston.initial_velocity = SPEED;
    p.contact.initial_gap = GAP;
    p.material.damping_time = 0.0;
    p.rock.viscosity = 0.0;
    p.rock.energy_barrier = 0.0;
    p.rock.standstill_speed = 0.0;
    p.rock.standstill_penetration = 0.0;
    p.drive.amplitude = 0.0;
    p.gravity = 0.0;
    soften_contact(&mut p);
    p
}

/// Impact speed of the closed forms, m/s, in which all of them are linear.
pub const SPEED: f64 = 10.0;
/// Gap before it, m.
pub const GAP: f64 = 1e-6;

/// Instant of the strike, s.
pub fn strike() -> f64 {
    GAP / SPEED
}

/// The stiffest penalty without chattering: twice the element's `E A / h`.
pub fn soften_contact(p: &mut Parameters) {
    let h = p.piston.length / p.piston.elements as f64;
    p.contact.stiffness = 2.0 * stretch(p) / h;
}

/// `E A`.
pub fn stretch(p: &Parameters) -> f64 {
    p.material.youngs_modulus * p.cross_section
}

/// No feed, no other input.
pub fn no_inputs() -> InputValues {
    InputValues { feed_force: 0.0, ..Default::default() }
}

/// Spread of a front after this many piston transits, in transits.
pub fn spread(p: &Parameters, transits: f64) -> f64 {
    let transit = p.timescales().piston_transit;
    let n = p.piston.elements as f64;
    let airy = (transits / (8.0 * n * n)).cbrt();
    let damping = (p.material.damping_time * transits / transit).sqrt();
    let penalty = p.impedance_of(p.cross_section) / (2.0 * p.contact.stiffness) / transit;
    airy + damping + penalty
}

/// Largest remaining distance of a value from its limit, by its changes over three meshes, each twice as fine as the
/// previous one.
pub fn remaining([quarter, half, full]: [f64; 3]) -> f64 {
    let ratio = 2f64.powf(2.0 / 3.0);
    (full - half).abs().max((half - quarter).abs() / ratio) / (ratio - 1.0)
}
