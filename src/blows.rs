//! The blows of the last communication step, one by one.
//!
//! Their number is not known in advance, so a description cannot list them. Its `VendorAnnotations`
//! say where their count and each of their quantities start. So a table of blows does not depend on
//! the length of steps.

use hammer::families::OF_BLOW;
use hammer::{MAX_STEP_BLOWS, Machine};

/// Name of their number.
pub const COUNT_NAME: &str = "step_blow_count";
/// Its description.
pub const COUNT_DESCRIPTION: &str = "Blows of the last communication step";
/// Value reference of their number.
pub const COUNT: u32 = 99_999;
/// Value reference of the first family's first member; above those of the waves.
const FIRST: u32 = 100_000;
/// From one family's first member to the next one's; more than the blows of a step.
const STRIDE: u32 = 100_000;
/// Number of value references that an instance can answer.
pub const CAPACITY: usize = OF_BLOW.len() * MAX_STEP_BLOWS + 1;

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
        (family < OF_BLOW.len()).then_some(Self::Of(family, index))
    }

    /// True of an instant.
    pub fn is_time(self) -> bool {
        matches!(self, Self::Of(family, _) if OF_BLOW[family].output == "blow_time")
    }

    /// Its value.
    ///
    /// # Errors
    /// A sentence, if the last step had fewer blows.
    pub fn read(self, machine: &Machine) -> Result<f64, String> {
        let blows = machine.step_blows();
        let Self::Of(family, index) = self else { return Ok(blows.len() as f64) };
        let count = blows.len();
        blows.get(index).map(OF_BLOW[family].value).ok_or_else(|| {
            let (name, number) = (OF_BLOW[family].name, index + 1);
            format!("there is no {name}[{number}]: the last step had {count} blows")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves;
    use hammer::families::ALONG;

    #[test]
    fn references_do_not_meet() {
        assert!(waves::first(ALONG.len()) <= COUNT);
        assert!(MAX_STEP_BLOWS <= STRIDE as usize);
        assert_eq!(Place::of(COUNT), Some(Place::Count));
        assert_eq!(Place::of(first(2) + 5), Some(Place::Of(2, 5)));
        assert_eq!(Place::of(COUNT - 1), None);
        assert_eq!(Place::of(first(OF_BLOW.len())), None);
        assert_eq!(Place::of(u32::MAX), None);
    }
}
