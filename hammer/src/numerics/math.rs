//! Elementary functions that are the same on every machine.
//!
//! The C library's functions differ in the last bits between versions, systems, and even processors, so results would
//! depend on the machine. IEEE 754 defines `+ - * /` and the square root exactly; the functions here use nothing else.

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

/// `x` to an integer power, by squaring. The compiler's own function uses the C library on Windows.
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

/// The `N`-th root of a positive normal number, `N` 5 or 7, within two roundings. The start divides the exponent,
/// with an error of 4 %; Halley's iteration then turns an error `e` into `(N^2 - 1) / 12 e^3`: 3e-4, 7e-11, and below
/// rounding.
pub(crate) fn odd_root<const N: usize>(x: f64) -> f64 {
    // The bits are the binary logarithm, linear between powers of two and on average 0.0430 too low.
    const ONE: u64 = 1.0f64.to_bits();
    let slack = 0.043 * (1u64 << 52) as f64;
    let shift = ONE - ONE / N as u64 - (slack * (1.0 - 1.0 / N as f64)) as u64;
    let mut y = f64::from_bits(x.to_bits() / N as u64 + shift);
    let [less, more] = [(N - 1) as f64, (N + 1) as f64];
    for _ in 0..3 {
        let square = y * y;
        let power = if N == 5 { square * square * y } else { square * square * square * y };
        y *= (less * power + more * x) / (more * power + less * x);
    }
    y
}

/// The order of [`root`].
pub(crate) const ROOT: usize = 24;

/// The 24th root: three square roots of a cube root.
pub(crate) fn root(x: f64) -> f64 {
    cbrt(x).sqrt().sqrt().sqrt()
}

/// `x` to the power 2/5.
pub(crate) fn two_fifths(x: f64) -> f64 {
    let root = odd_root::<5>(x);
    root * root
}

/// `x` to the power 5/7.
pub(crate) fn five_sevenths(x: f64) -> f64 {
    let root = odd_root::<7>(x);
    let square = root * root;
    square * square * root
}

pub(crate) fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// Magnitude of a complex number.
pub(crate) fn norm(z: Complex64) -> f64 {
    hypot(z.re, z.im)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each step of Halley's is four roundings of a correction, of which an `N`-th counts, and one of the product; a
    /// power up to 5 multiplies them.
    #[test]
    fn roots_are_those_of_powers() {
        for k in -3000..3000 {
            let x = exp(f64::from(k) * 0.0123);
            for (found, power) in [(two_fifths(x), 0.4), (five_sevenths(x), 5.0 / 7.0)] {
                let off = found / pow(x, power) - 1.0;
                // The exponent 5/7 is itself rounded, which contributes half a rounding times the logarithm, 37.
                assert!(off.abs() < 32.0 * f64::EPSILON, "{x}: {off:e}");
            }
        }
        assert_eq!([two_fifths(32.0), five_sevenths(128.0)], [4.0, 32.0]);
    }
}
