//! Eigenvalues of a small Hessenberg matrix: the shifted QR iteration in complex numbers.

use crate::numerics::math::norm;
use num_complex::Complex64 as C;

/// Sweeps per eigenvalue; two or three are needed.
const MOST_SWEEPS: usize = 200;

/// Ritz values of Arnoldi's columns (column `k` has `k + 2` entries), largest first, each with
/// its residual: what the matrix does not map into the space, `h_(m+1,m) |y_m|`.
pub(crate) fn ritz(columns: &[Vec<f64>]) -> Vec<(C, f64)> {
    let m = columns.len();
    let at = |i: usize, k: usize| C::new(columns[k].get(i).copied().unwrap_or(0.0), 0.0);
    let full: Vec<Vec<C>> = (0..m).map(|i| (0..m).map(|k| at(i, k)).collect()).collect();
    let beyond = columns[m - 1][m];
    let mut pairs: Vec<(C, f64)> =
        eigenvalues(full.clone()).into_iter().map(|l| (l, beyond * last_entry(&full, l))).collect();
    // A conjugate pair in a fixed order.
    pairs.sort_by(|a, b| {
        let near = (norm(a.0) - norm(b.0)).abs() <= 1e-12 * norm(a.0);
        if near { b.0.im.total_cmp(&a.0.im) } else { norm(b.0).total_cmp(&norm(a.0)) }
    });
    pairs
}

/// Magnitude of the last entry of the eigenvector over its length, by back substitution from
/// there: rows from the last up give the entries before.
fn last_entry(h: &[Vec<C>], l: C) -> f64 {
    let m = h.len();
    let mut y = vec![C::default(); m];
    y[m - 1] = C::new(1.0, 0.0);
    for i in (1..m).rev() {
        let sum: C = (i..m).map(|k| h[i][k] * y[k]).sum();
        let below = h[i][i - 1];
        if below == C::default() {
            break;
        }
        y[i - 1] = (l * y[i] - sum) / below;
    }
    1.0 / y.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt()
}

/// Eigenvalues of an upper Hessenberg matrix.
pub(crate) fn eigenvalues(mut h: Vec<Vec<C>>) -> Vec<C> {
    let mut eigenvalues = Vec::new();
    let mut n = h.len();
    let mut sweeps = 0;
    while n > 0 {
        let split = (1..n).rev().find(|&i| {
            let near = norm(h[i][i]) + norm(h[i - 1][i - 1]);
            norm(h[i][i - 1]) <= f64::EPSILON * near.max(1e-300)
        });
        let low = split.unwrap_or(0);
        if low == n - 1 || sweeps > MOST_SWEEPS {
            eigenvalues.push(h[n - 1][n - 1]);
            n -= 1;
            sweeps = 0;
            continue;
        }
        sweeps += 1;
        let shift = if sweeps % 11 == 10 {
            // A shift that goes round in circles is left.
            h[n - 1][n - 1] + norm(h[n - 1][n - 2])
        } else {
            wilkinson(&h, n)
        };
        sweep(&mut h, low, n, shift);
    }
    eigenvalues
}

/// The eigenvalue of the last 2 by 2 block that is nearer to its last entry.
fn wilkinson(h: &[Vec<C>], n: usize) -> C {
    let (a, b) = (h[n - 2][n - 2], h[n - 2][n - 1]);
    let (c, d) = (h[n - 1][n - 2], h[n - 1][n - 1]);
    let half = 0.5 * (a + d);
    let root = square_root(0.25 * (a - d) * (a - d) + b * c);
    let (x, y) = (half + root, half - root);
    if norm(x - d) < norm(y - d) { x } else { y }
}

/// A square root; by the real one alone, which is the same on every machine.
fn square_root(z: C) -> C {
    let size = norm(z);
    let (re, im) = ((0.5 * (size + z.re)).max(0.0).sqrt(), (0.5 * (size - z.re)).max(0.0).sqrt());
    C::new(re, if z.im < 0.0 { -im } else { im })
}

/// One QR step on rows and columns `low..n`, by Givens rotations.
fn sweep(h: &mut [Vec<C>], low: usize, n: usize, shift: C) {
    for (i, row) in h.iter_mut().enumerate().take(n).skip(low) {
        row[i] -= shift;
    }
    let mut turns = Vec::with_capacity(n - low - 1);
    for i in low..n - 1 {
        let (x, y) = (h[i][i], h[i + 1][i]);
        let r = (x.norm_sqr() + y.norm_sqr()).sqrt();
        let (c, s) = if r > 0.0 { (x / r, y / r) } else { (C::new(1.0, 0.0), C::default()) };
        let (upper, lower) = h.split_at_mut(i + 1);
        for (a, b) in upper[i][i..n].iter_mut().zip(&mut lower[0][i..n]) {
            let (p, q) = (*a, *b);
            *a = c.conj() * p + s.conj() * q;
            *b = c * q - s * p;
        }
        turns.push((c, s));
    }
    for (j, (c, s)) in turns.into_iter().enumerate() {
        let i = low + j;
        for row in h.iter_mut().take((i + 2).min(n)).skip(low) {
            let (p, q) = (row[i], row[i + 1]);
            row[i] = p * c + q * s;
            row[i + 1] = q * c.conj() - p * s.conj();
        }
    }
    for (i, row) in h.iter_mut().enumerate().take(n).skip(low) {
        row[i] += shift;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The companion matrix of a polynomial has its roots; residuals of a whole space are zero.
    #[test]
    fn a_companion_matrix_has_the_roots_of_its_polynomial() {
        // (x - 2)(x + 1)(x^2 - x + 1) = x^4 - 2 x^3 + x + ... expanded below.
        let coefficients = [-2.0, 1.0, 0.0, -2.0]; // constant term first
        let m = coefficients.len();
        let mut h = vec![vec![C::default(); m]; m];
        for i in 0..m {
            h[i][m - 1] = C::new(-coefficients[i], 0.0);
            if i > 0 {
                h[i][i - 1] = C::new(1.0, 0.0);
            }
        }
        for root in eigenvalues(h) {
            let value = root.powi(4)
                + coefficients.iter().enumerate().map(|(k, c)| root.powi(k as i32) * c).sum::<C>();
            assert!(value.norm() < 1e-13, "{root}: {value}");
        }
    }
}
