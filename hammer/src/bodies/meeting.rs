//! The stiffness through which piston and bit meet.
//!
//! Rigid bodies meet through `KC` in series with a stiffness `k` that represents the bars. A collision through `k`
//! alone lasts half a period of the reduced mass `mu`; waves keep a contact of bars closed for a time `T`. `k` is
//! chosen so that both times are equal: `k = pi^2 mu / T^2`. For uniform bodies with the same section `T = 2 Lmin/c0`,
//! hence `k = pi^2 E A Lmax / (4 (Lp + Lb) Lmin)`. For stepped bodies `T` is the time until the contact force first
//! vanishes when two free, undamped bodies with rigid faces meet. It is computed with exact waves, which are reflected
//! and transmitted at every step of the sections. The lattice places the steps with an error of at most 1/2000 of both
//! lengths.

use crate::quantities::parameters::{Fidelity, Parameters};
use crate::quantities::sections::{Body, Sections};

/// Approximate number of cells of the lattice in both bodies together.
const CELLS: f64 = 2000.0;
/// The contact force counts as zero below this share of its first value, which is above rounding and below the effect
/// of any step.
const NONE: f64 = 1e-9;
/// Longest collision, in transits of a wave through both bodies.
const LONGEST: usize = 16;

impl Parameters {
    /// Stiffness through which piston and bit meet, N/m: the penalty `KC`, and for rigid bodies in series with it the
    /// stiffness `k` that represents the bars.
    pub fn meeting_stiffness(&self) -> f64 {
        match self.fidelity {
            Fidelity::Elastic => self.contact.stiffness,
            Fidelity::Rigid => 1.0 / (1.0 / self.contact.stiffness + 1.0 / self.bars_stiffness()),
        }
    }

    /// The stiffness `k` that represents the bars, N/m.
    fn bars_stiffness(&self) -> f64 {
        let pi2 = std::f64::consts::PI * std::f64::consts::PI;
        let [piston, bit] = Body::ALL.map(|body| self.sections(body));
        let (lp, lb) = (piston.length(), bit.length());
        if let Some(area) = piston.one_area()
            && bit.one_area() == Some(area)
        {
            return pi2 * self.material.youngs_modulus * area * lp.max(lb)
                / (4.0 * (lp + lb) * lp.min(lb));
        }
        let (mp, mb) = (self.piston_mass(), self.bit_mass());
        let duration = collision_length(&piston, &bit) / self.wave_speed();
        pi2 / (1.0 / mp + 1.0 / mb) / (duration * duration)
    }
}

/// `c0 T`, m: the distance that a wave travels until the contact force first vanishes.
fn collision_length(piston: &Sections, bit: &Sections) -> f64 {
    let cell = (piston.length() + bit.length()) / CELLS;
    let areas = |body: &Sections| -> Vec<f64> {
        let cells = |length: f64| (length / cell).round().max(1.0) as usize;
        let sections = body.as_slice().iter();
        sections.flat_map(|s| std::iter::repeat_n(s.area, cells(s.length))).collect()
    };
    let (upper, lower) = (areas(piston), areas(bit));
    let contact = upper.len();
    let areas = [upper, lower].concat();
    let last = areas.len() - 1;
    // Particle velocities of the downward and upward waves in every cell; their sum in the striker is 1.
    let mut down: Vec<f64> = (0..=last).map(|i| if i < contact { 0.5 } else { 0.0 }).collect();
    let mut up = down.clone();
    let approach = |down: &[f64], up: &[f64]| down[contact - 1] - up[contact];
    let first = approach(&down, &up);
    for step in 1..LONGEST * areas.len() {
        let (mut next_down, mut next_up) = (vec![0.0; last + 1], vec![0.0; last + 1]);
        // Free ends carry no force.
        (next_down[0], next_up[last]) = (up[0], down[last]);
        for i in 0..last {
            let (a, b) = (areas[i], areas[i + 1]);
            let (x, y) = (down[i], up[i + 1]);
            next_down[i + 1] = (2.0 * a * x + (b - a) * y) / (a + b);
            next_up[i] = ((a - b) * x + 2.0 * b * y) / (a + b);
        }
        (down, up) = (next_down, next_up);
        if approach(&down, &up) <= NONE * first {
            return step as f64 * cell;
        }
    }
    (LONGEST * areas.len()) as f64 * cell
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::sections::Segment;

    fn rigid(piston: &[(f64, f64)], bit: &[(f64, f64)]) -> Parameters {
        let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
        let part = |&(length, area): &(f64, f64)| Segment { length, area };
        p.piston.segments.set(&piston.iter().map(part).collect::<Vec<_>>());
        p.bit.segments.set(&bit.iter().map(part).collect::<Vec<_>>());
        p
    }

    /// By Saint-Venant's theory, for equal areas `T` is `2 Lmin/c0`, however the bodies are divided into sections. For
    /// unequal areas the contact ends after `2 L/c0`, where `L` is the length of the body with the lower impedance.
    #[test]
    fn a_collision_lasts_as_long_as_waves_make_it() {
        for (piston, bit, expected) in [
            // Each body is uniform but given as two sections, so that the lattice is used.
            ([(0.1, 2e-3), (0.1, 2e-3)], [(0.2, 2e-3), (0.1, 2e-3)], 0.4),
            // A slender striker bounces off; a stout one keeps pushing until the bit leaves it.
            ([(0.1, 1e-3), (0.1, 1e-3)], [(0.2, 2e-3), (0.1, 2e-3)], 0.4),
            ([(0.1, 3e-3), (0.1, 3e-3)], [(0.2, 2e-3), (0.1, 2e-3)], 0.6),
        ] {
            let p = rigid(&piston, &bit);
            let [a, b] = Body::ALL.map(|body| p.sections(body));
            let length = collision_length(&a, &b);
            // The position of a step and the instant of a wave may each be wrong by one cell.
            assert!((length - expected).abs() <= 2.0 * 0.5 / CELLS, "{length} {expected}");
        }
    }
}
