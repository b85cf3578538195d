//! Functions of `s` with their derivatives: what the secular function's determinants are made of.

use num_complex::Complex64 as C;
use std::ops::{Mul, Sub};

/// A function of `s` and its derivative.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Jet {
    pub(crate) at: C,
    pub(crate) slope: C,
}

impl Jet {
    pub(crate) fn add(&mut self, factor: f64, other: Self) {
        self.at += factor * other.at;
        self.slope += factor * other.slope;
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { at: self.at * other.at, slope: self.slope * other.at + self.at * other.slope }
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { at: self.at - other.at, slope: self.slope - other.slope }
    }
}
