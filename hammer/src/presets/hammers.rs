//! Stepped pistons and bits, by the size of the hole; and a top hammer.
//!
//! Mass of the piston and feed (the middle of its range) are those that SPM prints for its
//! medium-pressure hammers of 58, 80, 98, 148 and 182 mm; the areas of the 3-inch piston's two
//! sections are Drillco's (Puma 3.1: body 2698 mm2, tail 1714 mm2). Everything else is invented in
//! the style of its class: shapes, strokes, and forces that give impacts at 7 to 9 m/s. The rock is
//! the reference's, with stiffness, viscosity and barrier proportional to the hole's area. The mesh is that
//! on which a rate errs by a hundredth.
//!
//! The damping is assumed: [`DAMPING`] of the piston's first elastic mode, for a guided body that
//! joints hold. The reference's damping time damps these modes by 0.02 to 0.1 %, and such hammers
//! never repeat a blow.

use super::rocks::{Inserts, RockType};
use crate::bodies::resolution::Reading;
use crate::quantities::parameters::{InputValues, Parameters};
use crate::quantities::sections::Segment;

/// Damping ratio that is assumed of the piston's first elastic mode, where nothing is known.
pub const DAMPING: f64 = 0.005;

/// The dimensions of a hammer.
struct Hammer<'a> {
    /// Lengths (m) and areas (m2) from top to bottom.
    piston: &'a [(f64, f64)],
    bit: &'a [(f64, f64)],
    /// Diameter of the hole, m.
    hole: f64,
    /// Force (N) and stroke (m) of the relay.
    force: f64,
    stroke: f64,
    /// Feed, N; the reference's where none is known.
    feed: Option<f64>,
    /// Penalty stiffness that makes wave fronts 6 mm wide, N/m.
    contact: f64,
}

fn sections(segment: &mut [Segment], parts: &[(f64, f64)]) -> usize {
    for (segment, &(length, area)) in segment.iter_mut().zip(parts) {
        *segment = Segment { length, area };
    }
    parts.len()
}

impl Hammer<'_> {
    fn build(&self, p: &mut Parameters, inputs: &mut InputValues) {
        inputs.feed_force = self.feed.unwrap_or(inputs.feed_force);
        p.piston.segments = sections(&mut p.piston.segment, self.piston);
        p.bit.segments = sections(&mut p.bit.segment, self.bit);
        (p.drive.amplitude, p.drive.stroke) = (self.force, self.stroke);
        (p.contact.stiffness, p.contact.initial_gap) = (self.contact, self.stroke);
        p.rock.spread(self.hole);
        p.hole.diameter = self.hole;
        let usual = Reading::Rate.usual_error();
        if let Some(mesh) = p.mesh_for(Reading::Rate, usual) {
            mesh.apply(p);
        }
        // To three digits, so that it is the same number wherever the modes are computed.
        let damping =
            p.damping_time_of(DAMPING).and_then(|time| format!("{time:.2e}").parse().ok());
        p.material.damping_time = damping.unwrap_or(p.material.damping_time);
    }
}

/// 2 inches: 2 kg.
pub fn two_inch(p: &mut Parameters, inputs: &mut InputValues) {
    Hammer {
        piston: &[(0.09, 1.25e-3), (0.15, 9.5e-4)],
        bit: &[(0.10, 1.1e-3), (0.07, 2.1e-3)],
        hole: 0.064,
        force: 1040.0,
        stroke: 0.022,
        feed: Some(5000.0),
        contact: 1.8e10,
    }
    .build(p, inputs);
}

/// 3 inches: 4.7 kg; the piston's areas are Drillco's.
pub fn three_inch(p: &mut Parameters, inputs: &mut InputValues) {
    Hammer {
        piston: &[(0.145, 2.698e-3), (0.121, 1.714e-3)],
        bit: &[(0.16, 1.9e-3), (0.09, 4.2e-3)],
        hole: 0.09,
        force: 2450.0,
        stroke: 0.03,
        feed: Some(8600.0),
        contact: 3.2e10,
    }
    .build(p, inputs);
}

/// 4 inches: 7.4 kg.
pub fn four_inch(p: &mut Parameters, inputs: &mut InputValues) {
    Hammer {
        piston: &[(0.05, 2.6e-3), (0.13, 4e-3), (0.127, 2.3e-3)],
        bit: &[(0.18, 2.5e-3), (0.11, 6.5e-3)],
        hole: 0.115,
        force: 4150.0,
        stroke: 0.032,
        feed: Some(9400.0),
        contact: 4.2e10,
    }
    .build(p, inputs);
}

/// 6 inches: 23 kg.
pub fn six_inch(p: &mut Parameters, inputs: &mut InputValues) {
    Hammer {
        piston: &[(0.07, 5.6e-3), (0.18, 8.8e-3), (0.18, 5.3e-3)],
        bit: &[(0.22, 5.3e-3), (0.16, 1.4e-2)],
        hole: 0.165,
        force: 8800.0,
        stroke: 0.034,
        feed: Some(14_000.0),
        contact: 9.3e10,
    }
    .build(p, inputs);
}

/// 8 inches: 43 kg.
pub fn eight_inch(p: &mut Parameters, inputs: &mut InputValues) {
    Hammer {
        piston: &[(0.08, 1e-2), (0.21, 1.45e-2), (0.182, 9e-3)],
        bit: &[(0.26, 9e-3), (0.19, 2.5e-2)],
        hole: 0.215,
        force: 16_000.0,
        stroke: 0.039,
        feed: Some(17_500.0),
        contact: 1.6e11,
    }
    .build(p, inputs);
}

/// A 4-inch hammer driven by water: a slender piston, a short stroke, 60 Hz.
pub fn water(p: &mut Parameters, inputs: &mut InputValues) {
    Hammer {
        piston: &[(0.12, 2.2e-3), (0.30, 3e-3), (0.10, 2.2e-3)],
        bit: &[(0.15, 2.6e-3), (0.12, 7e-3)],
        hole: 0.115,
        force: 7500.0,
        stroke: 0.009,
        feed: None,
        contact: 4.2e10,
    }
    .build(p, inputs);
}

/// A hydraulic drifter on four rods of 3.66 m, in granite.
///
/// Blow energy, rate of blows and power are those of Atlas Copco's COP 1838: 18 to 19 kW at up to 60 Hz
/// (Walker, Engineering and Mining Journal, "Hydraulic drills hammer through with new designs, tougher
/// materials"), so some 310 J; another drifter of this class has been measured at 346 J and 62 Hz. The
/// rock is [`ROCKS`](super::ROCKS)' granite under nine inserts of 11 mm. Assumed: a piston of the rods'
/// impedance, as Lundberg 1987 (Int. J. Rock Mech. Min. Sci. 24:213) has it; its speed; the feed; the bit.
/// The string is the parameters' own, and its damping the reference's: half a per cent of the piston's
/// first mode, as the other hammers have it, would take `1 - exp(-2 zeta omega L/c)`, 62 %, of the energy
/// of a wave of that frequency on its way down the rods.
pub fn top_hammer(p: &mut Parameters, inputs: &mut InputValues) {
    let damping = p.material.damping_time;
    p.drill.rods = 4;
    Hammer {
        piston: &[(0.5, 1.3e-3)],
        bit: &[(0.08, 2.4e-3), (0.05, 3.8e-3)],
        hole: 0.076,
        force: 6600.0,
        stroke: 0.0224,
        feed: Some(10_000.0),
        contact: 2e10,
    }
    .build(p, inputs);
    p.material.damping_time = damping;
    let granite = RockType::named("kuru granite");
    let bit = Inserts { count: 9, radius: 5.5e-3 };
    p.rock = granite.and_then(|rock| rock.under(&bit)).unwrap_or(p.rock);
}
