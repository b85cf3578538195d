//! Double-double numbers: unevaluated sums of two doubles.
//!
//! After a million blows a double resolves 7e-12 s and 2e-13 m, which is too coarse for a period or a gap.
//! The instants of events and the origins are therefore double-double numbers, and so are sums in which nearly
//! everything cancels.
//! Source: Dekker, A floating-point technique for extending the available precision, Numer. Math. 18, 1971.

use serde::{Deserialize, Serialize};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The number `high + low`, where `|low|` is at most half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Double {
    high: f64,
    low: f64,
}

impl Double {
    /// The double-double number that equals a double.
    pub fn new(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    /// The nearest double.
    pub fn value(self) -> f64 {
        self.high
    }

    /// The number minus [`Self::value`].
    pub fn rest(self) -> f64 {
        self.low
    }

    /// Adds `step` (two-sum).
    pub fn move_by(&mut self, step: f64) {
        let sum = self.high + step;
        let back = sum - self.high;
        let error = (self.high - (sum - back)) + (step - back) + self.low;
        self.high = sum + error;
        self.low = error - (self.high - sum);
    }

    /// `self - other`.
    pub fn since(self, other: Self) -> f64 {
        (self.high - other.high) + (self.low - other.low)
    }

    /// `other - self` for a double `other`.
    pub fn until(self, other: f64) -> f64 {
        (other - self.high) - self.low
    }
}

/// `a + b` and its rounding error (two-sum).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let back = sum - a;
    (sum, (a - (sum - back)) + (b - back))
}

/// `a b` and its rounding error. The factors are split into halves of 26 bits (Veltkamp), because some machines have no
/// fused product.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let halves = |x: f64| {
        let scaled = 134_217_729.0 * x;
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let ((a1, a2), (b1, b2)) = (halves(a), halves(b));
    let product = a * b;
    (product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2)
}

impl Double {
    fn of(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (sum, sum_error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let first = Self::of(sum, sum_error + low);
        Self::of(first.high, first.low + low_error)
    }
}

impl Neg for Double {
    type Output = Self;

    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Double {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.high, other.high);
        Self::of(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Double {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = Self::new(self.high / other.high);
        let rest = self - first * other;
        let second = Self::new(rest.high / other.high);
        let last = rest - second * other;
        first + (second + Self::new(last.high / other.high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A million steps of 45.389 ms add up exactly, where a double's sum would round.
    #[test]
    fn a_long_sum_keeps_twice_the_digits() {
        let step = 0.045389;
        let (mut sum, mut start) = (Double::new(0.0), Double::new(0.0));
        for _ in 0..1_000_000 {
            sum.move_by(step);
        }
        start.move_by(step * 1e6);
        // The product step * 1e6 is itself rounded, by half a unit in the last place of 45389: 4e-12.
        assert!(sum.since(start).abs() < 4e-12);
        let before = sum;
        sum.move_by(1e-14);
        assert!((sum.since(before) - 1e-14).abs() < 1e-26);
    }
}
