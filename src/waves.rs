//! Stress and velocity along the bars, for wave diagrams: velocities at the ends of the
//! mesh's elements and stresses at their middles, whatever the degree.
//!
//! How many values there are follows from the mesh, which a description cannot say. So the
//! plain one lists none and only tells, in `VendorAnnotations`, where each family of value
//! references starts; a variant of it lists as many as one mesh needs. It names the mesh in
//! its GUID, because a host need not set a parameter that stays at its start value.
//!
//! Also compiled into `build.rs`.

use crate::quantity::{Quantity, STRESS, VELOCITY};
use hammer::{Body, Fidelity, MAX_ELEMENTS, Machine, ParameterError, Parameters};

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

/// What a description lists: the table alone, or also the waves on one mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Variant(Option<[usize; 2]>);

/// Between the plain GUID and the element counts of piston and bit.
const MARK: &str = "-waves-";

impl Variant {
    /// The variant that a GUID names; `None` if it is not of this build.
    pub fn named(guid: &str, plain: &str) -> Option<Self> {
        let rest = guid.strip_prefix(plain)?;
        if rest.is_empty() {
            return Some(Self(None));
        }
        let (piston, bit) = rest.strip_prefix(MARK)?.split_once('-')?;
        let mesh = [piston.parse().ok()?, bit.parse().ok()?];
        let fits = mesh.iter().all(|count| (1..=MAX_ELEMENTS).contains(count));
        (fits && rest == Self::suffix(mesh[0], mesh[1])).then_some(Self(Some(mesh)))
    }

    /// What a variant's GUID has beyond the plain one.
    pub fn suffix(piston: impl std::fmt::Display, bit: impl std::fmt::Display) -> String {
        format!("{MARK}{piston}-{bit}")
    }

    /// The start values of its description.
    pub fn parameters(self) -> Parameters {
        let mut parameters = Parameters::default();
        if let Self(Some([piston, bit])) = self {
            parameters.fidelity = Fidelity::Elastic;
            (parameters.piston.elements, parameters.bit.elements) = (piston, bit);
        }
        parameters
    }

    /// Refuses a mesh other than that of the description.
    ///
    /// # Errors
    /// The parameter, its value and the one that is allowed.
    pub fn check(self, parameters: &Parameters) -> Result<(), ParameterError> {
        let Self(Some(mesh)) = self else { return Ok(()) };
        for (body, count) in Body::ALL.into_iter().zip(mesh) {
            let value = parameters.spans(body);
            if value != count {
                let allowed = format!("{count}, as the description's outputs are listed");
                return Err(ParameterError { name: elements(body), value: value as f64, allowed });
            }
        }
        if parameters.fidelity == Fidelity::Rigid {
            let allowed = "2 (Elastic), as the description lists stresses".into();
            return Err(ParameterError { name: "fidelity", value: 1.0, allowed });
        }
        Ok(())
    }
}

/// Value reference of a family's first member.
pub fn first(family: usize) -> u32 {
    FIRST + STRIDE * family as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::VARIABLES;

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

    #[test]
    fn a_guid_names_one_mesh_or_is_wrong() {
        assert_eq!(Variant::named("g", "g"), Some(Variant(None)));
        assert_eq!(Variant::named("g-waves-40-7", "g"), Some(Variant(Some([40, 7]))));
        for wrong in ["", "h", "g-", "g-waves-40", "g-waves-40-0", "g-waves-401-1"] {
            assert_eq!(Variant::named(wrong, "g"), None, "{wrong}");
        }
        for wrong in ["g-waves-040-7", "g-waves-40-7-", "g-waves-+40-7", "g-waves-40-7 "] {
            assert_eq!(Variant::named(wrong, "g"), None, "{wrong}");
        }
    }
}
