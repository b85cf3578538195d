//! Parameters as numbers that the host has set, right or wrong.
//!
//! They become [`Parameters`] only when they are needed, so that a wrong one is
//! reported where the contract asks for it, with the value that was set.

use hammer::variables::PARAMETERS;
use hammer::{ParameterError, Parameters};
use serde::{Deserialize, Serialize};

/// One number a parameter, by value reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings(Vec<f64>);

impl Settings {
    /// As the parameters stand.
    pub fn of(parameters: &Parameters) -> Self {
        Self(PARAMETERS.iter().map(|row| row.slot.read(parameters)).collect())
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

    /// True if there is a number for each parameter.
    pub fn is_complete(&self) -> bool {
        self.0.len() == PARAMETERS.len()
    }

    /// The parameters.
    ///
    /// # Errors
    /// The first number that is out of its domain.
    pub fn parameters(&self) -> Result<Parameters, ParameterError> {
        let mut parameters = Parameters::default();
        for (row, value) in PARAMETERS.iter().zip(&self.0) {
            row.slot.write(&mut parameters, *value);
        }
        for (row, value) in PARAMETERS.iter().zip(&self.0) {
            if row.is_checked(&parameters) {
                row.check(*value)?;
            }
        }
        Ok(parameters)
    }
}
