//! Parameters as numbers that the host has set, right or wrong.
//!
//! They become [`Parameters`] only when they are needed, so that a wrong one is
//! reported where the contract asks for it, with the value that was set.

use hammer::variables::{Role, Slot, VARIABLES};
use hammer::{ParameterError, Parameters};
use serde::{Deserialize, Serialize};

/// One number a variable, by value reference; only those of parameters mean something.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings(Vec<f64>);

impl Settings {
    /// As the parameters stand.
    pub fn of(parameters: &Parameters) -> Self {
        let number = |role: &Role| match role {
            Role::Parameter { slot, .. } => slot.read(parameters),
            _ => 0.0,
        };
        Self(VARIABLES.iter().map(|variable| number(&variable.role)).collect())
    }

    /// The number set.
    pub fn get(&self, reference: usize) -> f64 {
        self.0.get(reference).copied().unwrap_or_default()
    }

    /// Sets a number, which may lie out of its domain.
    pub fn set(&mut self, reference: usize, value: f64) {
        if let Some(slot) = self.0.get_mut(reference) {
            *slot = value;
        }
    }

    /// True if there is a number for each variable.
    pub fn is_complete(&self) -> bool {
        self.0.len() == VARIABLES.len()
    }

    /// The parameters.
    ///
    /// # Errors
    /// The first number that is out of its domain.
    pub fn parameters(&self) -> Result<Parameters, ParameterError> {
        let mut parameters = Parameters::default();
        for (reference, slot) in slots() {
            let value = self.get(reference);
            // The number of sections stands before the sections.
            if VARIABLES[reference].applies(&parameters) {
                check(reference, value)?;
            }
            slot.write(&mut parameters, value);
        }
        Ok(parameters)
    }
}

/// Refuses a number that is out of its parameter's domain.
///
/// # Errors
/// The variable, the number and the allowed range.
pub fn check(reference: usize, value: f64) -> Result<(), ParameterError> {
    let Some(variable) = VARIABLES.get(reference) else { return Ok(()) };
    match variable.domain() {
        Some(domain) if !domain.contains(value) => {
            Err(ParameterError { name: variable.name, value, allowed: domain.describe() })
        }
        _ => Ok(()),
    }
}

fn slots() -> impl Iterator<Item = (usize, &'static Slot)> {
    VARIABLES.iter().enumerate().filter_map(|(reference, variable)| match &variable.role {
        Role::Parameter { slot, .. } => Some((reference, slot)),
        _ => None,
    })
}
