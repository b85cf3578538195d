//! Numbers in messages.

use std::fmt;

/// Writes a number as people do: with a power of ten if it is very large or very small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayNumber(pub f64);

impl fmt::Display for DisplayNumber {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let plain = self.0 == 0.0 || (1e-5..1e16).contains(&self.0.abs()) || !self.0.is_finite();
        if plain { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

/// A number, rounded to four digits for display.
pub fn digits(number: f64) -> DisplayNumber {
    DisplayNumber(format!("{number:.3e}").parse().unwrap_or(number))
}
