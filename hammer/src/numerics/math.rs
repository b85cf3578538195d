//! Elementary functions that are the same on every machine.
//!
//! The C library's functions differ in the last bits between versions, systems, and even
//! processors, so results would depend on the machine. IEEE 754 defines `+ - * /` and the square
//! root exactly; the functions here use nothing else.

use num_complex::Complex64;

pub(crate) fn sin(x: f64) -> f64 {
    libm::sin(x)
}

pub(crate) fn cos(x: f64) -> f64 {
    libm::cos(x)
}

pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

pub(crate) fn exp(x: f64) -> f64 {
    libm::exp(x)
}

pub(crate) fn ln(x: f64) -> f64 {
    libm::log(x)
}

pub(crate) fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// `x` to a whole power, by squaring; the compiler's own uses the C library on Windows.
pub(crate) fn powi(mut x: f64, mut exponent: usize) -> f64 {
    let mut product = 1.0;
    loop {
        if exponent % 2 == 1 {
            product *= x;
        }
        exponent /= 2;
        if exponent == 0 {
            return product;
        }
        x *= x;
    }
}

pub(crate) fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// The order of [`root`].
pub(crate) const ROOT: usize = 24;

/// The 24th root: three square roots of a cube root.
pub(crate) fn root(x: f64) -> f64 {
    cbrt(x).sqrt().sqrt().sqrt()
}

pub(crate) fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// Magnitude of a complex number.
pub(crate) fn norm(z: Complex64) -> f64 {
    hypot(z.re, z.im)
}
