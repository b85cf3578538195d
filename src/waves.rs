//! Stress and velocity along the bars, for wave diagrams: velocities at the ends of the
//! mesh's elements and stresses at their middles, whatever the degree.
//!
//! How many values there are follows from the mesh, which a description cannot say. So the
//! general one lists none and only says, in `VendorAnnotations`, where each family of value
//! references starts; a variant of it (`variant.rs`) lists as many as one mesh needs.

use hammer::families::{ALONG, Along};
use hammer::variables::{PARAMETERS, Parameter};
use hammer::{Body, MAX_ELEMENTS, Parameters, Profile};

/// Value reference of the first family's first member; above those of the table.
pub const FIRST: u32 = 1000;
/// From one family's first member to the next one's; more than a mesh has nodes.
const STRIDE: u32 = 1000;
/// Number of value references that an instance can answer.
pub const CAPACITY: usize = ALONG.len() * (MAX_ELEMENTS + 1);

/// The parameter that counts a body's elements.
pub fn elements(body: Body) -> &'static str {
    let named = |row: &&Parameter| row.name.strip_prefix(body.name()) == Some(".elements");
    PARAMETERS.iter().find(named).map_or("", |row| row.name)
}

/// A value reference beyond the table's: its family, and its index from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    family: usize,
    index: usize,
}

impl Place {
    /// The place of a value reference; `None` if it is of no family.
    pub fn of(reference: u32) -> Option<Self> {
        let beyond = reference.checked_sub(FIRST)?;
        let place = Self { family: (beyond / STRIDE) as usize, index: (beyond % STRIDE) as usize };
        (place.family < ALONG.len()).then_some(place)
    }

    /// Its family.
    pub fn family(self) -> &'static Along {
        &ALONG[self.family]
    }

    /// Its value.
    ///
    /// # Errors
    /// A sentence, if the mesh does not have it.
    pub fn read(self, profile: &Profile, parameters: &Parameters) -> Result<f64, String> {
        let value = self.family().value(profile, self.index);
        value.ok_or_else(|| self.family().missing(self.index, parameters))
    }
}

/// Value reference of a family's first member.
pub fn first(family: usize) -> u32 {
    FIRST + STRIDE * family as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use hammer::variables::VARIABLES;

    #[test]
    fn references_do_not_meet() {
        assert!(VARIABLES.len() < FIRST as usize);
        assert!(MAX_ELEMENTS + 1 < STRIDE as usize);
        for (family, expected) in ALONG.iter().enumerate() {
            let place = Place::of(first(family) + 2).unwrap();
            assert_eq!((place.family().name, place.index), (expected.name, 2));
        }
        assert_eq!(Place::of(FIRST - 1), None);
        assert_eq!(Place::of(first(ALONG.len())), None);
        assert_eq!(Place::of(u32::MAX), None);
    }
}
