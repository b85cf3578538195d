//! Parameters as numbers that the host has set, valid or not.
//!
//! They become [`Parameters`] only when needed, so that an invalid one is reported in the call in which the standard
//! expects it, with the value that was set.

use crate::error::CallError;
use hammer::variables::{Parameter, Reader, Role, VARIABLES, Variable};
use hammer::{DisplayNumber, ParameterError, Parameters};
use serde::{Deserialize, Serialize};

/// A number for each variable, by value reference; 0 for variables that are not parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings(Vec<f64>);

impl Settings {
    /// The present values of these parameters.
    pub fn of(parameters: &Parameters) -> Self {
        let read = |row: Option<&Parameter>| row.map_or(0.0, |row| row.slot.read(parameters));
        Self((0..VARIABLES.len()).map(|k| read(parameter(k))).collect())
    }

    /// The number that was set.
    pub fn get(&self, reference: usize) -> f64 {
        self.0.get(reference).copied().unwrap_or_default()
    }

    /// The number of the parameter with this name.
    pub fn named(&self, name: &str) -> f64 {
        Variable::named(name).map_or(0.0, |(reference, _)| self.get(reference))
    }

    /// Sets a number, which may be outside its domain.
    pub fn set(&mut self, reference: usize, value: f64) {
        if let Some(slot) = self.0.get_mut(reference) {
            *slot = value;
        }
    }

    /// True if there is a number for each variable.
    pub fn is_complete(&self) -> bool {
        self.0.len() == VARIABLES.len()
    }

    /// The parameters and their numbers.
    fn rows(&self) -> impl Iterator<Item = (usize, &'static Parameter, f64)> {
        let row = |(k, value): (usize, &f64)| Some((k, parameter(k)?, *value));
        self.0.iter().enumerate().filter_map(row)
    }

    /// True if calls of a host can have led to these numbers. This is checked because a stored state may be corrupt.
    pub fn is_sound(&self) -> bool {
        self.0.iter().all(|value| value.is_finite())
    }

    /// Refuses a number that was set for a drive that does not act. The user meant that drive, but the host could not
    /// choose it: some hosts cannot set enumerations.
    ///
    /// # Errors
    /// The first such number that differs from its start.
    pub fn check_drive(&self, parameters: &Parameters, start: &Self) -> Result<(), CallError> {
        for (k, row, value) in self.rows() {
            let start = start.get(k);
            let reason =
                matches!(row.reader, Reader::Drive(_)).then(|| row.reader.reason(parameters));
            if let Some(reason) = reason.flatten().filter(|_| value != start) {
                return Err(CallError::Argument(format!(
                    "{} = {} is not allowed: {reason}. Set drive.source too, or leave it at {} (for a host that \
                     cannot set enumerations, make a unit or a system of that hammer: dth-hammer configure, system)",
                    row.name,
                    DisplayNumber(value),
                    DisplayNumber(start)
                )));
            }
        }
        Ok(())
    }

    /// The parameters.
    ///
    /// # Errors
    /// The first number outside its domain.
    pub fn parameters(&self) -> Result<Parameters, ParameterError> {
        let mut parameters = Parameters::default();
        for (_, row, value) in self.rows() {
            row.slot.write(&mut parameters, value);
        }
        for (_, row, value) in self.rows() {
            if row.is_checked(&parameters) {
                row.check(value)?;
            }
        }
        Ok(parameters)
    }
}

/// The parameter with this value reference.
fn parameter(reference: usize) -> Option<&'static Parameter> {
    match VARIABLES.get(reference)?.role {
        Role::Parameter(row) => Some(row),
        _ => None,
    }
}
