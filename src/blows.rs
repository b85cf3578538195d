//! The blows of the last communication step, one by one.
//!
//! How many there are nobody knows before, so no description can list them. It tells in
//! `VendorAnnotations` where their count and each of their figures start. A table of blows
//! then does not depend on how long the steps are.
//!
//! Also compiled into `build.rs`.

use hammer::quantity::{ADVANCE, ENERGY, LENGTH, Quantity, TIME, VELOCITY};
use hammer::{Blow, MAX_STEP_BLOWS, Machine};

/// Name of their number.
pub const COUNT_NAME: &str = "step_blow_count";
/// Value reference of their number.
pub const COUNT: u32 = 99_999;
/// Value reference of the first family's first member; above those of the waves.
const FIRST: u32 = 100_000;
/// From one family's first member to the next one's; more than a step keeps blows.
const STRIDE: u32 = 100_000;
/// Number of value references that an instance can answer.
pub const CAPACITY: usize = FAMILIES.len() * MAX_STEP_BLOWS + 1;

/// One figure of every blow, counted from 1.
pub struct Family {
    /// Name without index.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Type.
    pub quantity: Quantity,
    /// Order of magnitude.
    pub nominal: f64,
    value: fn(&Blow) -> f64,
}

/// All families, in the order of their value references.
#[rustfmt::skip]
pub const FAMILIES: [Family; 6] = [
    Family { name: "step_blow_time", description: "Instant of a blow",
        quantity: TIME, nominal: 0.1, value: |blow| blow.time },
    Family { name: "step_blow_speed", description: "Mean speed of the piston over the bit at a blow",
        quantity: VELOCITY, nominal: 10.0, value: |blow| blow.speed },
    Family { name: "step_blow_energy", description: "Half the piston's mass times step_blow_speed squared",
        quantity: ENERGY, nominal: 200.0, value: |blow| blow.energy },
    Family { name: "step_blow_period", description: "Time since the blow before, 0 for the first of all",
        quantity: TIME, nominal: 0.05, value: |blow| blow.period },
    Family { name: "step_blow_penetration", description: "Advance of the hole since the blow before",
        quantity: LENGTH, nominal: 1e-3, value: |blow| blow.penetration },
    Family { name: "step_rop", description: "Rate of penetration since the blow before",
        quantity: ADVANCE, nominal: 0.03, value: |blow| blow.rop },
];

/// Value reference of a family's first member.
pub fn first(family: usize) -> u32 {
    FIRST + STRIDE * family as u32
}

/// A value reference of this file's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// How many blows there are.
    Count,
    /// A family, and an index from 0.
    Of(usize, usize),
}

impl Place {
    /// The place of a value reference; `None` if it is none of these.
    pub fn of(reference: u32) -> Option<Self> {
        if reference == COUNT {
            return Some(Self::Count);
        }
        let beyond = reference.checked_sub(FIRST)?;
        let (family, index) = ((beyond / STRIDE) as usize, (beyond % STRIDE) as usize);
        (family < FAMILIES.len()).then_some(Self::Of(family, index))
    }

    /// Its value.
    ///
    /// # Errors
    /// A sentence, if the last step had fewer blows.
    pub fn read(self, machine: &Machine) -> Result<f64, String> {
        let blows = machine.step_blows();
        let Self::Of(family, index) = self else { return Ok(blows.len() as f64) };
        let Family { name, value, .. } = &FAMILIES[family];
        let (number, count) = (index + 1, blows.len());
        blows
            .get(index)
            .map(value)
            .ok_or_else(|| format!("there is no {name}[{number}]: the last step had {count} blows"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves;

    #[test]
    fn references_do_not_meet() {
        assert!(waves::first(waves::FAMILIES.len()) <= COUNT);
        assert!(MAX_STEP_BLOWS <= STRIDE as usize);
        assert_eq!(Place::of(COUNT), Some(Place::Count));
        assert_eq!(Place::of(first(2) + 5), Some(Place::Of(2, 5)));
        assert_eq!(Place::of(COUNT - 1), None);
        assert_eq!(Place::of(first(FAMILIES.len())), None);
        assert_eq!(Place::of(u32::MAX), None);
    }
}
