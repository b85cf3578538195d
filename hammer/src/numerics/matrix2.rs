//! Two by two matrices, stored row by row.

use crate::numerics::math::{exp, sin_cos};
use num_complex::Complex64 as C;

/// The matrix `[m11, m12, m21, m22]`.
pub type Matrix2 = [f64; 4];

/// `x y`.
pub fn product(x: &Matrix2, y: &Matrix2) -> Matrix2 {
    [
        x[0] * y[0] + x[1] * y[2],
        x[0] * y[1] + x[1] * y[3],
        x[2] * y[0] + x[3] * y[2],
        x[2] * y[1] + x[3] * y[3],
    ]
}

/// `exp(b t)` of a matrix that is diagonal or has equal diagonal entries. Nothing cancels, whether the motion
/// oscillates, decays critically, or decays without oscillation.
pub fn exponential(b: &Matrix2, t: f64) -> Matrix2 {
    if b[1] == 0.0 && b[2] == 0.0 {
        return [exp(b[0] * t), 0.0, 0.0, exp(b[3] * t)];
    }
    let (sigma, delta) = (b[0], -b[1] * b[2]);
    let x = delta.abs().sqrt() * t;
    // These are exp(sigma t) times cos(w t) and sin(w t)/w, or times the hyperbolic functions.
    let (c, s) = if delta >= 0.0 {
        let decay = exp(sigma * t);
        let (sin, cos) = sin_cos(x);
        let sinc = if x < 1e-4 { 1.0 - x * x / 6.0 } else { sin / x };
        (decay * cos, decay * t * sinc)
    } else {
        let (slow, fast) = (exp(sigma * t + x), exp(sigma * t - x));
        // Below 1 the difference of the two exponentials would cancel.
        let sinhc = if x < 1.0 { exp(sigma * t) * sinhc(x * x) } else { 0.5 * (slow - fast) / x };
        (0.5 * (slow + fast), t * sinhc)
    };
    [c, b[1] * s, b[2] * s, c]
}

/// `sinh(x) / x` as a function of `x^2`, for `x^2` up to 1; the first omitted term is at most `1 / 21!`.
fn sinhc(square: f64) -> f64 {
    (1..10).rev().fold(1.0, |sum, k| {
        let k = f64::from(k);
        1.0 + sum * square / (2.0 * k * (2.0 * k + 1.0))
    })
}

/// Solves Sylvester's equation `A^T X + X B = R`.
pub fn sylvester(a: &Matrix2, b: &Matrix2, r: Matrix2) -> Matrix2 {
    let is_spiral = |m: &Matrix2| m[1] == -m[2] && m[1] != 0.0;
    if is_spiral(a) && is_spiral(b) {
        // Both matrices are written as z' = (sigma - i omega) z, so that sums of eigenvalues do not cancel.
        let (la, lb) = (C::new(a[0], -a[1]), C::new(b[0], -b[1]));
        let equal_turn = 0.5 * C::new(r[0] - r[3], -(r[1] + r[2]));
        let cross = 0.5 * C::new(r[0] + r[3], -(r[1] - r[2]));
        let part = |x: C, l: C| if l == C::default() { C::default() } else { x / l };
        let (p, q) = (part(equal_turn, la + lb), part(cross, la.conj() + lb));
        return [p.re + q.re, -p.im - q.im, -p.im + q.im, q.re - p.re];
    }
    let t = [a[0], a[2], a[1], a[3]];
    let trace = b[0] + b[3];
    let det = b[0] * b[3] - b[1] * b[2];
    // (A^T^2 + tr B A^T + det B) X = A^T R + R (tr B - B), by Cayley and Hamilton.
    let mut m = product(&t, &t);
    for k in 0..4 {
        m[k] += trace * t[k];
    }
    m[0] += det;
    m[3] += det;
    let (x, y) = (product(&t, &r), product(&r, &[trace - b[0], -b[1], -b[2], trace - b[3]]));
    let rhs = [x[0] + y[0], x[1] + y[1], x[2] + y[2], x[3] + y[3]];
    let d = m[0] * m[3] - m[1] * m[2];
    product(&[m[3] / d, -m[1] / d, -m[2] / d, m[0] / d], &rhs)
}
