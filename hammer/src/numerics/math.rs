//! Elementary functions that are the same on every machine.
//!
//! The C library's functions differ in their last binary digits between versions, systems, and even processors, so
//! results would depend on the machine. IEEE 754 defines `+ - * /` and the square root exactly; the functions here use
//! nothing else.

pub(crate) use libm::{cbrt, cos, exp, hypot, log as ln, pow, sin, sincos as sin_cos};
use num_complex::Complex64;

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

/// The `N`-th root of a positive normal number, for `N` 5 or 7, within two roundings. The first estimate divides the
/// exponent, with an error of 4 %. Halley's iteration turns an error `e` into `(N^2 - 1) / 12 e^3`: 3e-4, then 7e-11,
/// then below rounding.
pub(crate) fn odd_root<const N: usize>(x: f64) -> f64 {
    // A double's bits approximate its binary logarithm: linear between powers of two, and on average 0.0430 too low.
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

/// `x` to the power 2/7.
pub(crate) fn two_sevenths(x: f64) -> f64 {
    let root = odd_root::<7>(x);
    root * root
}

/// The `n`-th root of a positive number, to `0.06 / n` and 0.002. A double's bits approximate its binary logarithm,
/// linearly between powers of two; within an octave the inverse is a parabola.
pub(crate) fn rough_root(x: f64, n: u64) -> f64 {
    const BITS: u64 = f64::MANTISSA_DIGITS as u64 - 1;
    const BIAS: f64 = (f64::MAX_EXP - 1) as f64;
    let logarithm = x.to_bits() as f64 / (1u64 << BITS) as f64 - BIAS;
    let shifted = logarithm / n as f64 + BIAS;
    let octave = shifted as u64;
    let part = shifted - octave as f64;
    f64::from_bits(octave << BITS) * (1.0 + part * (0.6565 + 0.3435 * part))
}

/// The root of the sum of the squares.
pub(crate) fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Magnitude of a complex number.
pub(crate) fn norm(z: Complex64) -> f64 {
    hypot(z.re, z.im)
}
