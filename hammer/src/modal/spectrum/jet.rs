//! Functions of `s` with their derivatives: what the secular function's determinants are made of.

use crate::numerics::minors::Ring;
use num_complex::Complex64 as C;

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

    pub(crate) fn times(self, other: Self) -> Self {
        Self { at: self.at * other.at, slope: self.slope * other.at + self.at * other.slope }
    }
}

/// Arithmetic of functions of `s` with their derivatives.
pub(crate) struct Jets;

impl Ring for Jets {
    type Number = Jet;

    fn product(&self, a: Jet, b: Jet) -> Jet {
        a.times(b)
    }

    fn difference(&self, mut a: Jet, b: Jet) -> Jet {
        a.add(-1.0, b);
        a
    }
}
