//! The modal basis of a system and the algebra of its 2 by 2 blocks.

use crate::modal::spectrum::Block;
use crate::modal::system::Recipe;
use crate::numerics::kernel;
use crate::numerics::math::{exp, sin_cos};

/// `exp(b t)` of a 2 by 2 block, without cancellation in any regime.
pub(crate) fn block_exponential(b: &[f64; 4], t: f64) -> [f64; 4] {
    if b[1] == 0.0 && b[2] == 0.0 {
        return [exp(b[0] * t), 0.0, 0.0, exp(b[3] * t)];
    }
    let (sigma, delta) = (b[0], -b[1] * b[2]);
    let x = delta.abs().sqrt() * t;
    // cos(w t) and sin(w t)/w, or their hyperbolic kin, times exp(sigma t).
    let (c, s) = if delta >= 0.0 {
        let decay = exp(sigma * t);
        let (sin, cos) = sin_cos(x);
        let sinc = if x < 1e-4 { 1.0 - x * x / 6.0 } else { sin / x };
        (decay * cos, decay * t * sinc)
    } else {
        let (slow, fast) = (exp(sigma * t + x), exp(sigma * t - x));
        let sinhc =
            if x < 1e-4 { exp(sigma * t) * (1.0 + x * x / 6.0) } else { 0.5 * (slow - fast) / x };
        (0.5 * (slow + fast), t * sinhc)
    };
    [c, b[1] * s, b[2] * s, c]
}

/// Solves `A^T X + X B = R` for 2 by 2 blocks.
pub(crate) fn sylvester(a: &[f64; 4], b: &[f64; 4], r: [f64; 4]) -> [f64; 4] {
    use num_complex::Complex64 as C;
    let turns = |m: &[f64; 4]| m[1] == -m[2] && m[1] != 0.0;
    if turns(a) && turns(b) {
        // As complex numbers z' = (sigma - i omega) z: sums of eigenvalues do not cancel.
        let (la, lb) = (C::new(a[0], -a[1]), C::new(b[0], -b[1]));
        let like = 0.5 * C::new(r[0] - r[3], -(r[1] + r[2]));
        let cross = 0.5 * C::new(r[0] + r[3], -(r[1] - r[2]));
        let part = |x: C, l: C| if l == C::default() { C::default() } else { x / l };
        let (p, q) = (part(like, la + lb), part(cross, la.conj() + lb));
        return [p.re + q.re, -p.im - q.im, -p.im + q.im, q.re - p.re];
    }
    let t = [a[0], a[2], a[1], a[3]];
    let trace = b[0] + b[3];
    let det = b[0] * b[3] - b[1] * b[2];
    let mul = |x: &[f64; 4], y: &[f64; 4]| {
        [
            x[0] * y[0] + x[1] * y[2],
            x[0] * y[1] + x[1] * y[3],
            x[2] * y[0] + x[3] * y[2],
            x[2] * y[1] + x[3] * y[3],
        ]
    };
    // (A^T^2 + tr B A^T + det B) X = A^T R + R (tr B - B), by Cayley and Hamilton.
    let mut m = mul(&t, &t);
    for k in 0..4 {
        m[k] += trace * t[k];
    }
    m[0] += det;
    m[3] += det;
    let (x, y) = (mul(&t, &r), mul(&r, &[trace - b[0], -b[1], -b[2], trace - b[3]]));
    let rhs = [x[0] + y[0], x[1] + y[1], x[2] + y[2], x[3] + y[3]];
    let d = m[0] * m[3] - m[1] * m[2];
    mul(&[m[3] / d, -m[1] / d, -m[2] / d, m[0] / d], &rhs)
}

/// `[b11 | b12 | b21 | b22]`, padded.
pub(crate) fn columns(blocks: &[Block], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; 4 * n];
    for (i, block) in blocks.iter().enumerate().filter(|(_, block)| !block.rigid) {
        for k in 0..4 {
            out[k * n + i] = block.b[k];
        }
    }
    out
}

/// The bases: columns `x` of `[q | q']` a coordinate, and their duals in the bilinear form
/// `x . [[C, 1], [1, 0]] x`, in which vectors of different eigenvalues are orthogonal.
/// Padded to `n` blocks.
pub(crate) fn bases(recipe: &Recipe, blocks: &[Block], n: usize) -> (Vec<f64>, Vec<f64>) {
    let modes = blocks.len();
    let len = 2 * n;
    let hub = (2 * modes).next_multiple_of(kernel::LANES);
    let (mut from, mut to) = (vec![0.0; 2 * modes * len], vec![0.0; hub * len]);
    for (i, block) in blocks.iter().enumerate() {
        let b = &block.b;
        let shapes = [&block.first, &block.second];
        let rates = [(b[0], b[2]), (b[1], b[3])];
        let columns = rates.map(|(p, q)| -> Vec<f64> {
            (0..modes).map(|h| p * block.first[h] + q * block.second[h]).collect()
        });
        let duals: [Vec<f64>; 2] = std::array::from_fn(|c| {
            let mut low = damped(recipe, shapes[c]);
            low.iter_mut().zip(&columns[c]).for_each(|(x, v)| *x += v);
            low.extend_from_slice(shapes[c]);
            low
        });
        let inner = |c: usize, d: usize| {
            inner_product(&duals[c][..modes], shapes[d])
                + inner_product(&duals[c][modes..], &columns[d])
        };
        let scalar = b[1] == 0.0 && b[2] == 0.0;
        let (g11, g22) = (inner(0, 0), inner(1, 1));
        let g12 = if scalar { 0.0 } else { 0.5 * (inner(0, 1) + inner(1, 0)) };
        let det = g11 * g22 - g12 * g12;
        for k in 0..2 * modes {
            let (x, y) = (duals[0][k], duals[1][k]);
            to[i * hub + k] = (g22 * x - g12 * y) / det;
            to[(n + i) * hub + k] = (g11 * y - g12 * x) / det;
        }
        for (c, at) in [(0, i), (1, n + i)] {
            for h in 0..modes {
                from[h * len + at] = shapes[c][h];
                from[(modes + h) * len + at] = columns[c][h];
            }
        }
    }
    (from, to)
}

/// `a . b` of any length.
pub(crate) fn inner_product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// `C q` with the dashpots.
fn damped(recipe: &Recipe, q: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> =
        recipe.omega2.iter().zip(q).map(|(w2, x)| recipe.beta * w2 * x).collect();
    for a in &recipe.attachments {
        let force = a.viscosity * inner_product(a.shape, q);
        out.iter_mut().zip(a.shape).for_each(|(o, s)| *o += force * s);
    }
    out
}
