//! Parameters as numbers that the host has set, valid or not.
//!
//! They become [`Parameters`] only when needed, so that an invalid one is reported where the
//! standard asks for it, with the value that was set.

use hammer::variables::PARAMETERS;
use hammer::{ParameterError, Parameters};
use serde::{Deserialize, Serialize};

/// One number per parameter, by value reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings(Vec<f64>);

impl Settings {
    /// The present values of these parameters.
    pub fn of(parameters: &Parameters) -> Self {
        Self(PARAMETERS.iter().map(|row| row.slot.read(parameters)).collect())
    }

    /// The number set.
    pub fn get(&self, reference: usize) -> f64 {
        self.0.get(reference).copied().unwrap_or_default()
    }

    /// The number set of the parameter of this name.
    pub fn named(&self, name: &str) -> f64 {
        let row = PARAMETERS.iter().position(|row| row.name == name);
        row.map_or(0.0, |reference| self.get(reference))
    }

    /// Sets a number, which may be outside its domain.
    pub fn set(&mut self, reference: usize, value: f64) {
        if let Some(slot) = self.0.get_mut(reference) {
            *slot = value;
        }
    }

    /// True if there is a number for each parameter.
    pub fn is_complete(&self) -> bool {
        self.0.len() == PARAMETERS.len()
    }

    /// Whether calls of the host could have led here. Checked because a stored state may be corrupt.
    pub fn is_sound(&self) -> bool {
        self.0.iter().all(|value| value.is_finite())
    }

    /// The parameters.
    ///
    /// # Errors
    /// The first number outside its domain.
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
