//! Stepped pistons and bits, by the size of the hole.
//!
//! The areas of the 3-inch piston's two sections are Drillco's (Puma 3.1: body 2698 mm2, tail 1714
//! mm2). Everything else is invented in the style of its class: masses, strokes and forces that
//! give typical energies and frequencies. The rock is the reference's, with stiffness, viscosity
//! and barrier proportional to the hole's area.
//!
//! The damping is assumed: [`DAMPING`] of the piston's first elastic mode, for a guided body that
//! joints hold. The reference's damping time damps these modes by 0.02 to 0.1 %, and such hammers
//! never repeat a blow.

use crate::quantities::parameters::Parameters;
use crate::quantities::sections::Segment;

/// Bit diameter that the reference rock is meant for, m.
const REFERENCE_HOLE: f64 = 0.09;

/// Damping ratio that is assumed of the piston's first elastic mode, where nothing is known.
pub const DAMPING: f64 = 0.005;

/// The dimensions of a hammer.
struct Hammer<'a> {
    /// Lengths (m) and areas (m2) from top to bottom, and spans of the mesh.
    piston: (&'a [(f64, f64)], usize),
    bit: (&'a [(f64, f64)], usize),
    /// Diameter of the hole, m.
    hole: f64,
    /// Force (N) and stroke (m) of the relay.
    force: f64,
    stroke: f64,
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
    fn build(&self, p: &mut Parameters) {
        p.piston.segments = sections(&mut p.piston.segment, self.piston.0);
        p.bit.segments = sections(&mut p.bit.segment, self.bit.0);
        (p.mesh.degree, p.piston.elements, p.bit.elements) = (5, self.piston.1, self.bit.1);
        (p.drive.amplitude, p.drive.stroke) = (self.force, self.stroke);
        (p.contact.stiffness, p.contact.initial_gap) = (self.contact, self.stroke);
        let share = (self.hole / REFERENCE_HOLE) * (self.hole / REFERENCE_HOLE);
        p.rock.stiffness *= share;
        p.rock.viscosity *= share;
        p.rock.energy_barrier *= share;
        p.hole.diameter = self.hole;
        // To three digits, so that it is the same number wherever the modes are computed.
        let damping =
            p.damping_time_of(DAMPING).and_then(|time| format!("{time:.2e}").parse().ok());
        p.material.damping_time = damping.unwrap_or(p.material.damping_time);
    }
}

/// 2 inches, about 35 J at 33 Hz.
pub fn two_inch(p: &mut Parameters) {
    Hammer {
        piston: (&[(0.09, 9e-4), (0.13, 6e-4)], 44),
        bit: (&[(0.10, 7e-4), (0.07, 1.4e-3)], 35),
        hole: 0.064,
        force: 650.0,
        stroke: 0.022,
        contact: 1.1e10,
    }
    .build(p);
}

/// 3 inches, about 200 J at 27 Hz; the piston's areas are Drillco's.
pub fn three_inch(p: &mut Parameters) {
    Hammer {
        piston: (&[(0.17, 2.698e-3), (0.14, 1.714e-3)], 63),
        bit: (&[(0.16, 1.9e-3), (0.09, 4.2e-3)], 50),
        hole: 0.09,
        force: 2600.0,
        stroke: 0.03,
        contact: 3.2e10,
    }
    .build(p);
}

/// 4 inches, about 450 J at 27 Hz.
pub fn four_inch(p: &mut Parameters) {
    Hammer {
        piston: (&[(0.06, 3.2e-3), (0.16, 5e-3), (0.15, 2.9e-3)], 74),
        bit: (&[(0.18, 3e-3), (0.11, 7.5e-3)], 58),
        hole: 0.115,
        force: 5700.0,
        stroke: 0.032,
        contact: 5.2e10,
    }
    .build(p);
}

/// 6 inches, about 1.2 kJ at 24 Hz.
pub fn six_inch(p: &mut Parameters) {
    Hammer {
        piston: (&[(0.08, 7e-3), (0.22, 1.1e-2), (0.20, 6.5e-3)], 100),
        bit: (&[(0.22, 6.5e-3), (0.16, 1.8e-2)], 76),
        hole: 0.165,
        force: 14_300.0,
        stroke: 0.034,
        contact: 1.1e11,
    }
    .build(p);
}

/// 8 inches, about 2.4 kJ at 21 Hz.
pub fn eight_inch(p: &mut Parameters) {
    Hammer {
        piston: (&[(0.10, 1.2e-2), (0.26, 1.8e-2), (0.22, 1.1e-2)], 116),
        bit: (&[(0.26, 1.1e-2), (0.19, 3.2e-2)], 90),
        hole: 0.215,
        force: 24_300.0,
        stroke: 0.039,
        contact: 1.9e11,
    }
    .build(p);
}

/// A 4-inch hammer driven by water: a slender piston, a short stroke, 60 Hz.
pub fn water(p: &mut Parameters) {
    Hammer {
        piston: (&[(0.12, 2.2e-3), (0.30, 3e-3), (0.10, 2.2e-3)], 104),
        bit: (&[(0.15, 2.6e-3), (0.12, 7e-3)], 54),
        hole: 0.115,
        force: 7500.0,
        stroke: 0.009,
        contact: 4.2e10,
    }
    .build(p);
}
