//! The domain of a parameter, and the error of a value outside it.

use crate::numerics::display::DisplayNumber;
use thiserror::Error;

/// The error if a parameter's value is outside its domain.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{name} = {} is not allowed: it must be {allowed}", DisplayNumber(*.value))]
pub struct ParameterError {
    /// The parameter's dotted name, such as `rock.stiffness`.
    pub name: &'static str,
    /// The value.
    pub value: f64,
    /// The allowed range, in words.
    pub allowed: String,
}

/// The domain of a real parameter. All domains contain finite numbers only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// Any finite number.
    Any,
    /// At least this.
    AtLeast(f64),
    /// Strictly above this.
    Above(f64),
    /// Between the two values, inclusive.
    Between(f64, f64),
}

impl Domain {
    /// True if `value` is finite and allowed.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::AtLeast(low) => value >= low,
                Self::Above(low) => value > low,
                Self::Between(low, high) => (low..=high).contains(&value),
            }
    }

    /// Refuses a number outside the domain. `name` and `unit` appear in the error.
    ///
    /// # Errors
    /// The value is not finite, or not in the domain.
    pub fn check(self, name: &'static str, value: f64, unit: &str) -> Result<(), ParameterError> {
        if self.contains(value) {
            return Ok(());
        }
        let allowed = format!("{} {unit}", self.describe()).trim_end().into();
        Err(ParameterError { name, value, allowed })
    }

    /// The domain in words, for messages.
    pub fn describe(self) -> String {
        match self {
            Self::Any => "a finite number".into(),
            Self::AtLeast(low) => format!("a finite number of at least {low}"),
            Self::Above(low) => format!("a finite number above {low}"),
            Self::Between(low, high) => format!("{low} to {high}"),
        }
    }
}
