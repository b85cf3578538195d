//! Stress and velocity along the bars, for wave diagrams: velocities at the ends of the
//! mesh's elements and stresses at their middles, whatever the degree.
//!
//! How many values there are follows from the mesh, which a description cannot say. So the
//! plain one lists none and only tells, in `VendorAnnotations`, where each family of value
//! references starts; a variant of it (`variant.rs`) lists as many as one mesh needs.
//!
//! Also compiled into `build.rs`.

use hammer::quantity::{Quantity, STRESS, VELOCITY};
use hammer::{Body, Fidelity, MAX_ELEMENTS, Machine, Parameters};

/// Value reference of the first family's first member; above those of the table.
pub const FIRST: u32 = 1000;
/// From one family's first member to the next one's; more than a mesh has nodes.
const STRIDE: u32 = 1000;
/// Number of value references that an instance can answer.
pub const CAPACITY: usize = FAMILIES.len() * (MAX_ELEMENTS + 1);

/// Variables of one kind along one body, counted from 1 at its upper end.
pub struct Family {
    /// Name without index.
    pub name: &'static str,
    /// What they are.
    pub description: &'static str,
    /// Type.
    pub quantity: Quantity,
    /// Order of magnitude.
    pub nominal: f64,
    /// Whose.
    pub body: Body,
    /// One a node; else one an element.
    pub nodal: bool,
}

/// All families, in the order of their value references.
#[rustfmt::skip]
pub const FAMILIES: [Family; 4] = [
    Family { name: "piston_stress", description: "Axial stress at the middle of an element of the piston, tension positive",
        quantity: STRESS, nominal: 1e8, body: Body::Piston, nodal: false },
    Family { name: "bit_stress", description: "Axial stress at the middle of an element of the bit, tension positive",
        quantity: STRESS, nominal: 1e8, body: Body::Bit, nodal: false },
    Family { name: "piston_node_velocity", description: "Velocity of a node of the piston, positive downward",
        quantity: VELOCITY, nominal: 10.0, body: Body::Piston, nodal: true },
    Family { name: "bit_node_velocity", description: "Velocity of a node of the bit, positive downward",
        quantity: VELOCITY, nominal: 10.0, body: Body::Bit, nodal: true },
];

/// The parameter that counts a body's elements.
pub const fn elements(body: Body) -> &'static str {
    match body {
        Body::Piston => "piston.elements",
        Body::Bit => "bit.elements",
    }
}

/// The parameter that counts a body's sections: elements are never fewer.
pub const fn segments(body: Body) -> &'static str {
    match body {
        Body::Piston => "piston.segments",
        Body::Bit => "bit.segments",
    }
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
        (place.family < FAMILIES.len()).then_some(place)
    }

    /// Its family.
    pub fn family(self) -> &'static Family {
        &FAMILIES[self.family]
    }

    /// What is wrong with it on a mesh that does not have it.
    pub fn out_of_mesh(self, parameters: &Parameters) -> String {
        let family = self.family();
        let (name, number) = (family.name, self.index + 1);
        match parameters.fidelity {
            Fidelity::Rigid => format!("there is no {name}[{number}]: fidelity is Rigid"),
            Fidelity::Elastic => {
                let (elements, count) = (elements(family.body), parameters.spans(family.body));
                format!("there is no {name}[{number}]: {elements} = {count}")
            }
        }
    }
}

/// All values of all families at one instant.
pub struct Values([Vec<f64>; FAMILIES.len()]);

impl Values {
    /// As the engine stands.
    pub fn of(machine: &mut Machine) -> Self {
        let profile = machine.profile();
        let velocities = |nodes: &[[f64; 2]]| nodes.iter().map(|[_, v]| *v).collect();
        let (piston, bit) = (velocities(&profile.piston), velocities(&profile.bit));
        Self([profile.piston_stress, profile.bit_stress, piston, bit])
    }

    /// One of them; `None` if the mesh does not have it.
    pub fn get(&self, place: Place) -> Option<f64> {
        self.0[place.family].get(place.index).copied()
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
        for (family, expected) in FAMILIES.iter().enumerate() {
            let place = Place::of(first(family) + 2).unwrap();
            assert_eq!((place.family().name, place.index), (expected.name, 2));
        }
        assert_eq!(Place::of(FIRST - 1), None);
        assert_eq!(Place::of(first(FAMILIES.len())), None);
        assert_eq!(Place::of(u32::MAX), None);
    }
}
