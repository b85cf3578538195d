//! Time and displacement as unevaluated sums of two doubles.
//!
//! After a million blows a double resolves 7e-12 s and 2e-13 m: too coarse for a period or
//! a gap. Events and origins are therefore kept to twice the digits.

use serde::{Deserialize, Serialize};

/// `high + low`, `|low|` below half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Double {
    high: f64,
    low: f64,
}

impl Double {
    /// From a double.
    pub fn new(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    /// Rounded.
    pub fn value(self) -> f64 {
        self.high
    }

    /// What [`Self::value`] lacks.
    pub fn rest(self) -> f64 {
        self.low
    }

    /// Moves by `step` (two-sum).
    pub fn add(&mut self, step: f64) {
        let sum = self.high + step;
        let back = sum - self.high;
        let lost = (self.high - (sum - back)) + (step - back) + self.low;
        self.high = sum + lost;
        self.low = lost - (self.high - sum);
    }

    /// `self - other`.
    pub fn since(self, other: Self) -> f64 {
        (self.high - other.high) + (self.low - other.low)
    }

    /// `other - self` for a plain number.
    pub fn until(self, other: f64) -> f64 {
        (other - self.high) - self.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A million steps of 45.389 ms lose nothing that a double's sum would.
    #[test]
    fn a_long_sum_keeps_twice_the_digits() {
        let step = 0.045389;
        let (mut sum, mut start) = (Double::new(0.0), Double::new(0.0));
        for _ in 0..1_000_000 {
            sum.add(step);
        }
        start.add(step * 1e6);
        // step * 1e6 is itself rounded to half a unit of 45389: 4e-12.
        assert!(sum.since(start).abs() < 4e-12);
        let before = sum;
        sum.add(1e-14);
        assert!((sum.since(before) - 1e-14).abs() < 1e-26);
    }
}
