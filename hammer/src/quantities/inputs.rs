//! The four inputs, as polynomials of time.

use crate::MAX_INPUT_ORDER;
use crate::numerics::poly::Poly;
use crate::quantities::parameters::InputValues;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What is wrong with an input.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum InputError {
    /// Not even a value.
    #[error("no value")]
    NoValue,
    /// More derivatives than [`crate::MAX_INPUT_ORDER`].
    #[error("the order of a derivative is above {}", crate::MAX_INPUT_ORDER)]
    OrderTooHigh,
    /// Not a number, or infinite.
    #[error("not a finite number")]
    NotFinite,
}

/// An input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Input {
    /// Feed force on the bit's shoulder, N.
    FeedForce,
    /// Force on the piston, N.
    DriveForce,
    /// Pressure driving the piston down, Pa.
    DrivePressure,
    /// Pressure returning the piston, Pa.
    ReturnPressure,
}

impl Input {
    /// All inputs.
    pub const ALL: [Self; 4] =
        [Self::FeedForce, Self::DriveForce, Self::DrivePressure, Self::ReturnPressure];

    /// Its name in the FMU.
    pub fn name(self) -> &'static str {
        match self {
            Self::FeedForce => "feed_force",
            Self::DriveForce => "drive_force",
            Self::DrivePressure => "drive_pressure",
            Self::ReturnPressure => "return_pressure",
        }
    }

    /// The polynomial with this value and these derivatives now.
    ///
    /// # Errors
    /// A number that is not finite, no value, or more than [`MAX_INPUT_ORDER`] derivatives.
    pub(crate) fn polynomial(self, derivatives: &[f64]) -> Result<Poly, InputError> {
        if derivatives.is_empty() {
            return Err(InputError::NoValue);
        }
        if derivatives.len() > MAX_INPUT_ORDER + 1 {
            return Err(InputError::OrderTooHigh);
        }
        if derivatives.iter().any(|d| !d.is_finite()) {
            return Err(InputError::NotFinite);
        }
        Ok(Poly::taylor(derivatives))
    }
}

/// The inputs' polynomials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs(pub [Poly; 4]);

impl Inputs {
    /// Constant inputs.
    pub fn constant(values: &InputValues) -> Self {
        Self(
            [values.feed_force, values.drive_force, values.drive_pressure, values.return_pressure]
                .map(Poly::constant),
        )
    }

    /// One of them.
    pub fn of(&self, input: Input) -> &Poly {
        &self.0[input as usize]
    }

    /// Restarts the clock `t` later.
    pub fn shift(&mut self, t: f64) {
        self.0.iter_mut().for_each(|p| p.shift(t));
    }
}
