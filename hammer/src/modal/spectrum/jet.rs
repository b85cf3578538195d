//! Jets: functions of `s` with their derivatives. The determinants of the secular function are made of them.

use num_complex::Complex64 as C;
use std::ops::{Mul, Sub};

/// The value of a function at `s`, and its derivative there.
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
