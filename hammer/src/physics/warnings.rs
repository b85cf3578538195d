//! What a user should know about parameters that are allowed.

use crate::physics::parameters::{Fidelity, Parameters};

/// In words; empty for an ordinary hammer.
pub(crate) fn warnings(parameters: &Parameters) -> Vec<String> {
    let mut list = Vec::new();
    if parameters.fidelity == Fidelity::Elastic {
        let (p, b) = (&parameters.piston, &parameters.bit);
        let stretch = parameters.material.youngs_modulus * parameters.cross_section;
        let element = stretch * (p.elements as f64 / p.length).max(b.elements as f64 / b.length);
        let ratio = parameters.contact.stiffness / element;
        if ratio > 2.0 {
            list.push(format!(
                "contact.stiffness = {} N/m is {ratio:.1} times the stiffness E A / h of the stiffest \
                 element; beyond 2 the contact nodes rattle",
                parameters.contact.stiffness
            ));
        }
    }
    list
}
