//! A water hammer of stepped bodies, and a top hammer.
//!
//! The rock is that of the reference hammer; its stiffness, viscosity and barrier are in proportion to the hole's area.
//! The mesh gives a rate of penetration with an error of 1 %. The damping is assumed: the piston, which is a guided
//! body, has the damping ratio [`DAMPING`] in its first elastic mode. With the reference's damping time the ratio would
//! be 0.02 to 0.1 %, and the blows would never repeat.

use super::rocks::{Ground, Inserts};
use crate::bodies::resolution::Reading;
use crate::quantities::parameters::{InputValues, Parameters};
use crate::quantities::sections::Segment;

/// Assumed damping ratio of the piston's first elastic mode.
pub const DAMPING: f64 = 0.005;

struct Hammer<'a> {
    piston: &'a [Segment],
    bit: &'a [Segment],
    hole: f64,
    /// Force (N) and stroke (m) of the relay.
    force: f64,
    stroke: f64,
    /// Feed force, N; `None` means that of the reference hammer.
    feed: Option<f64>,
    /// Penalty stiffness that makes wave fronts of 6 mm, N/m.
    contact: f64,
}

/// A section of a length (m) and an area (m2).
const fn section(length: f64, area: f64) -> Segment {
    Segment { length, area }
}

impl Hammer<'_> {
    fn build(&self, p: &mut Parameters, inputs: &mut InputValues) {
        inputs.feed_force = self.feed.unwrap_or(inputs.feed_force);
        p.piston.segments.set(self.piston);
        p.bit.segments.set(self.bit);
        (p.drive.amplitude, p.drive.stroke) = (self.force, self.stroke);
        (p.contact.stiffness, p.contact.initial_gap) = (self.contact, self.stroke);
        p.rock.spread(self.hole);
        p.hole.diameter = self.hole;
        let error = Reading::Rate.usual_error();
        if let Some(mesh) = p.mesh_for(Reading::Rate, error) {
            mesh.apply(p);
        }
        // The time is rounded to three digits, so that it does not depend on the machine that computes the modes.
        let damping =
            p.damping_time_of(DAMPING).and_then(|time| format!("{time:.2e}").parse().ok());
        p.material.damping_time = damping.unwrap_or(p.material.damping_time);
    }
}

/// A 4-inch hammer driven by water: a slender piston, a short stroke, 60 Hz.
pub fn water(p: &mut Parameters, inputs: &mut InputValues) {
    Hammer {
        piston: &[section(0.12, 2.2e-3), section(0.30, 3e-3), section(0.10, 2.2e-3)],
        bit: &[section(0.15, 2.6e-3), section(0.12, 7e-3)],
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
/// Blow energy, blow rate and power are those of Atlas Copco's COP 1838: 18 to 19 kW at up to 60 Hz, or some 310 J
/// (Walker, Engineering and Mining Journal, "Hydraulic drills hammer through with new designs, tougher materials").
/// Another drifter of this class was measured at 346 J and 62 Hz.
///
/// The rock is the granite of [`ROCKS`](super::ROCKS) under nine inserts of 11 mm. The following are assumed: a piston
/// with the rods' impedance, as in Lundberg 1987 (Int. J. Rock Mech. Min. Sci. 24:213), its speed, the feed force and
/// the bit. The string is the default one, with the damping time of the reference hammer. A damping ratio of 0.5 % in
/// the piston's first mode, as in the other hammers, would dissipate the share `1 - exp(-2 zeta omega L/c)` = 62 % of
/// the energy of such a wave on its way down the rods.
pub fn top_hammer(p: &mut Parameters, inputs: &mut InputValues) {
    let damping = p.material.damping_time;
    p.drill.rods = 4;
    Hammer {
        piston: &[section(0.5, 1.3e-3)],
        bit: &[section(0.08, 2.4e-3), section(0.05, 3.8e-3)],
        hole: 0.076,
        force: 6600.0,
        stroke: 0.0224,
        feed: Some(10_000.0),
        contact: 2e10,
    }
    .build(p, inputs);
    p.material.damping_time = damping;
    let bit = Inserts { count: 9, radius: 5.5e-3 };
    p.rock = Ground::named("granite").and_then(|(rock, _)| rock.under(&bit)).unwrap_or(p.rock);
}
