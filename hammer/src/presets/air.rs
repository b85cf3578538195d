//! Hammers that air drives, with a casing, by the size of the hammer.
//!
//! From makers: the outer diameter, the air at 150, 250 and 350 psi and the power at 24 bar are from Sandvik's
//! catalogue (*Down the Hole Rock Drilling Tools*, 2023, quoted in `reports/catalogue.md`); the bore, 0.866 of the
//! outer diameter, is from Drillco (*Puma 3.1 maintenance sheet*); the piston is scaled from a published one of about
//! that size (the same report).
//!
//! The following are assumed, and scaled by area to all four sizes: the faces of the piston, its stroke, the positions
//! and height of the ports, the dead volumes, and an exhaust port of 2.5 times the supply's area. This is the one of
//! six such sets with the published frequencies, 35 to 45 Hz, and with impacts below 13 m/s. One number of each hammer
//! is fitted: the area of its supply ports, to the air at 150 psi. Bodies are uniform, and the bit is as heavy as the
//! piston. The masses of the casings, the chuck, and the rock (the reference rock, scaled by the area of the hole) are
//! assumed too. The feed holds the casing down at 24 bar. SPM's largest recommended feeds for these sizes, at up to 17
//! bar, are 11.8, 12.3, 13.5 and 18.1 kN. With these feeds the drives of the three larger hammers are vented part of
//! the time at 24 bar.

use super::Preset;
use super::hammers::DAMPING;
use crate::quantities::air::{ATMOSPHERE, AirChamber, AirLaw};
use crate::quantities::parameters::{InputValues, Parameters, Source};
use crate::quantities::sections::Segment;
use crate::scene::Scene;

/// Length of the wave front that the contact's stiffness makes, m.
const FRONT: f64 = 0.0125;
/// Absolute supply pressure, Pa: 350 psi above the atmosphere's.
const SUPPLY: f64 = 2.413e6 + ATMOSPHERE;

/// Area of a supply port of the 4-inch hammer, over its outside diameter squared.
const PORTS: f64 = 2.2e-4 / (0.105 * 0.105);
/// Mass of the casing over the outside diameter squared, kg/m2: between those of the presets.
const CASING: f64 = 2500.0;

/// The numbers in which these hammers differ.
#[derive(Clone, Copy, Debug)]
pub struct AirHammer {
    /// Outer diameter, m.
    pub outer: f64,
    /// Mass of the piston, kg.
    pub piston: f64,
    /// Mass of the casing, kg.
    pub casing: f64,
    /// Area of a supply port, m2.
    pub supply: f64,
    /// Diameter of the hole, m.
    pub hole: f64,
    /// Feed, N.
    pub feed: f64,
    /// Stroke, ports and dead volumes over those of the presets.
    pub stroke: f64,
}

impl AirHammer {
    /// The bore over the outer diameter.
    pub const BORE: f64 = 0.866;
    /// Area of the drive chamber's face over the bore's.
    pub const DRIVE: f64 = 0.92;

    /// A hammer with casing and ports scaled from the presets by the area of its outside diameter (m).
    pub fn in_proportion(outer: f64, piston: f64, hole: f64, feed: f64) -> Self {
        let [casing, supply] = [CASING, PORTS].map(|part| part * outer * outer);
        Self { outer, piston, casing, supply, hole, feed, stroke: 1.0 }
    }

    /// Holds the cylinder. Without a casing, nothing rises.
    #[cfg(test)]
    pub(crate) fn hold(p: &mut Parameters) {
        (p.casing.mass, p.chuck.idle_travel) = (0.0, 0.0);
    }

    /// The hammer's scene at the presets' pressure.
    pub fn start(&self) -> Scene {
        let mut scene = Scene::default();
        self.build(&mut scene.parameters, &mut scene.inputs);
        scene
    }

    fn build(&self, p: &mut Parameters, inputs: &mut InputValues) {
        let diameter = Self::BORE * self.outer;
        // Numbers are rounded to three digits, as in a hand-written scene.
        let rounded = |x: f64| format!("{x:.2e}").parse().unwrap_or(x);
        let bore = std::f64::consts::FRAC_PI_4 * diameter * diameter;
        let area: f64 = rounded(0.7 * bore);
        let length = rounded(self.piston / (p.material.density * area));
        let section = [Segment { length, area }];
        p.piston.segments.set(&section);
        p.bit.segments.set(&section);
        (p.mesh.degree, p.piston.elements, p.bit.elements) = (3, 16, 16);
        p.contact.stiffness = rounded(p.material.youngs_modulus * area / FRONT);
        p.contact.initial_gap = 0.06 * self.stroke;
        p.rock.spread(self.hole);
        p.hole.diameter = self.hole;
        p.casing.mass = self.casing;
        p.chuck.idle_travel = 0.02;
        let [drive, back] = [rounded(Self::DRIVE * bore), rounded(0.55 * bore)];
        (p.drive.source, p.drive.area_drive, p.drive.area_return) = (Source::Air, drive, back);
        p.air = AirLaw {
            drive: AirChamber {
                dead_volume: rounded(0.02 * drive * self.stroke),
                supply: -0.038 * self.stroke,
                exhaust: -0.028 * self.stroke,
            },
            returning: AirChamber {
                dead_volume: rounded(0.03 * back * self.stroke),
                supply: -0.022 * self.stroke,
                exhaust: -0.042 * self.stroke,
            },
            cylinder: 0.12 * self.stroke,
            port_height: 6e-3 * self.stroke,
            supply_area: self.supply,
            exhaust_area: 2.5 * self.supply,
            ..p.air
        };
        p.material.damping_time =
            p.damping_time_of(DAMPING).map_or(p.material.damping_time, rounded);
        (inputs.feed_force, inputs.supply_pressure) = (self.feed, SUPPLY);
    }
}

/// The presets, with the outside and hole diameters in mm.
macro_rules! presets {
    ($($name:ident = $text:literal, $inches:literal, $outer:literal, $hole:literal,
       [$piston:literal, $casing:literal, $supply:literal, $feed:literal];)*) => {
        $(
            #[doc = concat!($inches, " inches: ", $outer, " mm.")]
            pub const $name: Preset = Preset {
                name: $text,
                description: concat!(
                    "A ", $inches, "-inch hammer driven by air at 24 bar in a casing, ", $outer, " mm, ", $hole,
                    " mm hole: piston's mass and air from makers, ports and areas assumed"
                ),
                change: |p, inputs| {
                    let [piston, casing, supply, feed] = [$piston, $casing, $supply, $feed];
                    let [outer, hole] = [$outer, $hole].map(|mm: u32| f64::from(mm) / 1000.0);
                    AirHammer { outer, piston, casing, supply, hole, feed, stroke: 1.0 }
                        .build(p, inputs);
                },
            };
        )*
    };
}

presets! {
    THREE_AND_A_HALF_INCH = "air_3_5_inch", "3.5", 85, 90, [5.5, 16.0, 1.45e-4, 12e3];
    FOUR_INCH = "air_4_inch", "4", 105, 115, [9.1, 27.0, 2.2e-4, 17e3];
    FIVE_INCH = "air_5_inch", "5", 127, 140, [19.0, 40.0, 1.92e-4, 19e3];
    SIX_INCH = "air_6_inch", "6", 150, 165, [23.9, 65.0, 1.9e-4, 25e3];
}
