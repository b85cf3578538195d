//! Named presets, each of which sets only what differs from the defaults, and named rocks, [`ROCKS`].

mod air;
mod hammers;
mod rocks;

use crate::quantities::inputs::INPUTS;
use crate::quantities::parameters::{InputValues, Parameters};
use crate::scene::Scene;
use crate::variables::differences;

pub use air::AirHammer;
pub use hammers::DAMPING;
pub use rocks::{Figure, Ground, Inserts, REFERENCE_HOLE, ROCKS, RockError, RockType};

/// A named set of parameters and inputs.
#[non_exhaustive]
pub struct Preset {
    /// The preset's name, one word.
    pub name: &'static str,
    /// The hammer that it represents.
    pub description: &'static str,
    change: fn(&mut Parameters, &mut InputValues),
}

/// The presets. All except the first are plausible illustrations, not measurements.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "reference",
        description: "A hammer with the times that Depouhon, Denoël and Detournay print: all start values as they are",
        change: |_, _| {},
    },
    Preset {
        name: "overdamped",
        description: "Reference hammer in rock so viscous that the bit creeps and never stands still, on 20 linear elements",
        change: |p, _| {
            p.mesh.degree = 1;
            (p.piston.elements, p.bit.elements) = (20, 20);
            p.rock.viscosity = 1.7e5;
            p.rock.energy_barrier = 4.0;
        },
    },
    Preset {
        name: "long_bit",
        description: "A bit of twice the length, with elements of the same size: longer waves; illustrative",
        change: |p, _| {
            p.bit.length *= 2.0;
            p.bit.elements *= 2;
        },
    },
    Preset {
        name: "water_hammer",
        description: "A water hammer of 180 bar, 115 mm hole: slender piston, short stroke, 60 Hz; made up in the style of its class",
        change: hammers::water,
    },
    Preset {
        name: "top_hammer",
        description: "A hydraulic drifter on four rods of 3.66 m, 76 mm hole in granite: power and blows as published of its class, the rest assumed",
        change: hammers::top_hammer,
    },
    air::THREE_AND_A_HALF_INCH,
    air::FOUR_INCH,
    air::FIVE_INCH,
    air::SIX_INCH,
];

impl Preset {
    /// The replacement for a preset that no longer exists.
    pub fn instead_of(name: &str) -> Option<&'static str> {
        match name {
            "granite" | "medium_rock" => {
                Some("a rock is given beside any hammer: rock = granite, R5 or 180 MPa")
            }
            "hammer_2_inch" | "hammer_3_inch" => Some("take air_3_5_inch or the reference"),
            "hammer_4_inch" => Some("take air_4_inch"),
            "hammer_6_inch" | "hammer_8_inch" => {
                Some("take air_6_inch, or make one of a datasheet")
            }
            _ => None,
        }
    }

    /// The preset with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// The preset's scene.
    pub fn start(&self) -> Scene {
        let mut scene = Scene::default();
        (self.change)(&mut scene.parameters, &mut scene.inputs);
        scene
    }

    /// Names and values of the variables that differ from the defaults. Inputs come last.
    pub fn differences(&self) -> Vec<(&'static str, f64)> {
        let Scene { parameters, mut inputs } = self.start();
        let (mut list, mut defaults) = (differences(&parameters), InputValues::default());
        for row in &INPUTS {
            let (value, default) = (*(row.start)(&mut inputs), *(row.start)(&mut defaults));
            list.extend((value != default).then_some((row.name, value)));
        }
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_lie_in_their_domains_and_list_only_what_differs() {
        for preset in PRESETS {
            assert_eq!(preset.start().parameters.validate(), Ok(()), "{}", preset.name);
            assert_eq!(preset.differences().is_empty(), preset.name == "reference");
        }
    }
}
