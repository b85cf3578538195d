//! Quotients and powers of power series, coefficient by coefficient.

use crate::linear::Real;

/// `u^(power / root)`.
pub(crate) fn raised<T: Real>(u: T, (power, root): (i32, i32)) -> T {
    let integer = |y: T, n: i32| (0..n).fold(T::from(1.0), |product, _| product * y);
    let mut y = T::from(u.to_f64().powf(1.0 / f64::from(root)));
    for _ in 0..3 {
        let slope = T::from(f64::from(root)) * integer(y, root - 1);
        y = y - (integer(y, root) - u) / slope;
    }
    let result = integer(y, power.abs());
    if power < 0 { T::from(1.0) / result } else { result }
}

/// Coefficient `k` of `c = a / b`, given the lower ones.
pub(crate) fn quotient<T: Real>(a: T, b: &[T], c: &[T], k: usize) -> T {
    ((0..k).fold(a, |rest, i| rest - c[i] * b[k - i])) / b[0]
}

/// Coefficient `k` of `y = u^(power / root)`, given the lower ones.
pub(crate) fn power<T: Real>(u: &[T], y: &[T], exponent: (i32, i32), k: usize) -> T {
    if k == 0 {
        return raised(u[0], exponent);
    }
    let exponent = T::from(f64::from(exponent.0)) / T::from(f64::from(exponent.1));
    let term =
        |i: usize| (exponent * T::from(i as f64) - T::from((k - i) as f64)) * u[i] * y[k - i];
    (1..=k).fold(T::default(), |sum, i| sum + term(i)) / (T::from(k as f64) * u[0])
}
