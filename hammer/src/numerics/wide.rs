//! Complex numbers in double-double precision.

use crate::numerics::instant::Double;
use num_complex::Complex64 as C;
use std::ops::{Add, Mul, Sub};

/// A complex number in double-double precision.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wide {
    pub(crate) re: Double,
    pub(crate) im: Double,
}

impl Wide {
    pub(crate) fn new(z: C) -> Self {
        Self { re: Double::new(z.re), im: Double::new(z.im) }
    }

    /// The nearest number in double precision.
    pub(crate) fn value(self) -> C {
        C::new(self.re.value(), self.im.value())
    }

    /// `1 / z`.
    pub(crate) fn inverse(self) -> Self {
        let square = self.re * self.re + self.im * self.im;
        Self { re: self.re / square, im: -self.im / square }
    }

    pub(crate) fn conjugate(self) -> Self {
        Self { re: self.re, im: -self.im }
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl Mul<f64> for Wide {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        let factor = Double::new(factor);
        Self { re: self.re * factor, im: self.im * factor }
    }
}
