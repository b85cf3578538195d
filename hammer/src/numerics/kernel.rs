//! Loops over modes: the only code whose speed is felt.
//!
//! A modal vector is stored as `[first coordinates | second coordinates]`, each padded with
//! zeros to whole groups of [`LANES`]. Every loop works on such groups, in vectors of
//! whatever width the processor at hand has ([`crate::numerics::vectors`]), adds in the same
//! order on all of them, and never fuses a product with a sum: the answer does not depend on
//! the machine.

use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Numbers in a group.
pub const LANES: usize = 8;

/// Most vectors that a group can take (a machine without any).
const MOST: usize = LANES;

/// A group of sums held in vectors.
type Sums<S> = [<S as Simd>::f64s; MOST];

/// Groups of a slice as vectors: `LANES / S::F64_LANES` a group.
#[inline(always)]
fn groups<S: Simd>(x: &[f64]) -> std::slice::ChunksExact<'_, S::f64s> {
    S::as_simd_f64s(x).0.chunks_exact(LANES / S::F64_LANES)
}

/// Adds up a group: always in the same order.
#[inline(always)]
fn total<S: Simd>(sums: Sums<S>) -> f64 {
    let mut x = [0.0; LANES];
    for (out, s) in S::as_mut_simd_f64s(&mut x).0.iter_mut().zip(sums) {
        *out = s;
    }
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}

#[inline(always)]
fn dot_with<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> f64 {
    let mut sums: Sums<S> = [simd.splat_f64s(0.0); MOST];
    for (x, y) in groups::<S>(a).zip(groups::<S>(b)) {
        for g in 0..LANES / S::F64_LANES {
            sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(x[g], y[g]));
        }
    }
    total::<S>(sums)
}

/// Rows of a matrix that are worked on together: their sums fit the registers.
const TILE: usize = 4;

/// The products of [`TILE`] rows of `size` numbers with `x`, each as [`dot_with`] makes it.
#[inline(always)]
fn dots_with<S: Simd>(simd: S, rows: &[f64], size: usize, x: &[f64]) -> [f64; TILE] {
    let row = |k: usize| groups::<S>(&rows[k * size..][..size]);
    let mut sums: [Sums<S>; TILE] = [[simd.splat_f64s(0.0); MOST]; TILE];
    for ((((x, a), b), c), d) in groups::<S>(x).zip(row(0)).zip(row(1)).zip(row(2)).zip(row(3)) {
        for g in 0..LANES / S::F64_LANES {
            sums[0][g] = simd.add_f64s(sums[0][g], simd.mul_f64s(a[g], x[g]));
            sums[1][g] = simd.add_f64s(sums[1][g], simd.mul_f64s(b[g], x[g]));
            sums[2][g] = simd.add_f64s(sums[2][g], simd.mul_f64s(c[g], x[g]));
            sums[3][g] = simd.add_f64s(sums[3][g], simd.mul_f64s(d[g], x[g]));
        }
    }
    sums.map(total::<S>)
}

/// `y := E y`, block by block.
#[inline(always)]
fn rotate_with<S: Simd>(simd: S, e: &[f64], y: &mut [f64]) {
    let n = y.len() / 2;
    let (p, q) = y.split_at_mut(n);
    let part = |k: usize| S::as_simd_f64s(&e[k * n..][..n]).0;
    let (p, q) = (S::as_mut_simd_f64s(p).0, S::as_mut_simd_f64s(q).0);
    let coefficients = part(0).iter().zip(part(1)).zip(part(2)).zip(part(3));
    for ((p, q), (((e11, e12), e21), e22)) in p.iter_mut().zip(q).zip(coefficients) {
        let (x, y) = (*p, *q);
        *p = simd.add_f64s(simd.mul_f64s(*e11, x), simd.mul_f64s(*e12, y));
        *q = simd.add_f64s(simd.mul_f64s(*e21, x), simd.mul_f64s(*e22, y));
    }
}

/// Declares a function whose body is compiled for each kind of processor.
macro_rules! vectorised {
    ($(#[$doc:meta])* $vis:vis fn $name:ident($($arg:ident: $kind:ty),*) -> $out:ty as $op:ident, $simd:ident $body:block) => {
        struct $op<'a> {
            $($arg: $kind),*
        }

        impl<'a> WithSimd for $op<'a> {
            type Output = $out;

            #[inline(always)]
            fn with_simd<S: Simd>(self, $simd: S) -> $out {
                let Self { $($arg),* } = self;
                $body
            }
        }

        $(#[$doc])*
        #[inline]
        $vis fn $name<'a>($($arg: $kind),*) -> $out {
            dispatch($op { $($arg),* })
        }
    };
}

vectorised! {
    /// `y := E y` block by block; `e` holds `[e11 | e12 | e21 | e22]`.
    pub fn rotate(e: &'a [f64], y: &'a mut [f64]) -> () as Rotate, simd {
        rotate_with(simd, e, y);
    }
}

vectorised! {
    /// `a . b`, in whole groups.
    pub fn dot(a: &'a [f64], b: &'a [f64]) -> f64 as Dot, simd {
        dot_with(simd, a, b)
    }
}

/// `a . b` of any length, from the first term to the last.
pub fn inner_product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

vectorised! {
    /// `w . |y|`, in whole groups.
    pub fn bound(w: &'a [f64], y: &'a [f64]) -> f64 as Bound, simd {
        let mut sums: Sums<S> = [simd.splat_f64s(0.0); MOST];
        for (w, y) in groups::<S>(w).zip(groups::<S>(y)) {
            for g in 0..LANES / S::F64_LANES {
                sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(w[g], simd.abs_f64s(y[g])));
            }
        }
        total::<S>(sums)
    }
}

vectorised! {
    /// `[r . y, s . y, w . |y|, u . |y|]` in one pass, in whole groups.
    pub fn probe(rows: [&'a [f64]; 2], weights: [&'a [f64]; 2], y: &'a [f64]) -> [f64; 4] as Probe, simd {
        let mut sums: [Sums<S>; 4] = [[simd.splat_f64s(0.0); MOST]; 4];
        let plain = groups::<S>(rows[0]).zip(groups::<S>(rows[1]));
        let sized = groups::<S>(weights[0]).zip(groups::<S>(weights[1]));
        for ((y, (r, s)), (w, u)) in groups::<S>(y).zip(plain).zip(sized) {
            for g in 0..LANES / S::F64_LANES {
                let size = simd.abs_f64s(y[g]);
                sums[0][g] = simd.add_f64s(sums[0][g], simd.mul_f64s(r[g], y[g]));
                sums[1][g] = simd.add_f64s(sums[1][g], simd.mul_f64s(s[g], y[g]));
                sums[2][g] = simd.add_f64s(sums[2][g], simd.mul_f64s(w[g], size));
                sums[3][g] = simd.add_f64s(sums[3][g], simd.mul_f64s(u[g], size));
            }
        }
        [total::<S>(sums[0]), total::<S>(sums[1]), total::<S>(sums[2]), total::<S>(sums[3])]
    }
}

/// Powers in the series of [`short`], from the second on.
pub const POWERS: usize = 11;

vectorised! {
    /// `y := exp(B span) y` for a short span: every block's exponential is
    /// `1 + x^2 sum_k a_k x^k + span (1 + x sum_k c_k x^k) B`, both sums over `terms` powers of
    /// `x`; `series` holds `[a_0 | c_0 | a_1 | c_1 ...]`, `b` is `[b11 | b12 | b21 | b22]`.
    pub fn short(b: &'a [f64], series: &'a [f64], terms: usize, x: f64, span: f64, y: &'a mut [f64]) -> () as Short, simd {
        let n = y.len() / 2;
        let (p, q) = y.split_at_mut(n);
        let (p, q) = (S::as_mut_simd_f64s(p).0, S::as_mut_simd_f64s(q).0);
        let part = |k: usize| S::as_simd_f64s(&b[k * n..][..n]).0;
        let series = S::as_simd_f64s(&series[..2 * terms * n]).0;
        let (lane, square, step) = (simd.splat_f64s(x), simd.splat_f64s(x * x), simd.splat_f64s(span));
        let columns = part(0).iter().zip(part(1)).zip(part(2)).zip(part(3));
        let count = p.len();
        for (i, ((p, q), (((b11, b12), b21), b22))) in p.iter_mut().zip(q).zip(columns).enumerate() {
            let (mut a, mut c) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
            for pair in series.chunks_exact(2 * count).rev() {
                a = simd.add_f64s(simd.mul_f64s(a, lane), pair[i]);
                c = simd.add_f64s(simd.mul_f64s(c, lane), pair[count + i]);
            }
            let a = simd.mul_f64s(square, a);
            let c = simd.add_f64s(step, simd.mul_f64s(step, simd.mul_f64s(lane, c)));
            let u = simd.add_f64s(simd.mul_f64s(*b11, *p), simd.mul_f64s(*b12, *q));
            let v = simd.add_f64s(simd.mul_f64s(*b21, *p), simd.mul_f64s(*b22, *q));
            *p = simd.add_f64s(*p, simd.add_f64s(simd.mul_f64s(a, *p), simd.mul_f64s(c, u)));
            *q = simd.add_f64s(*q, simd.add_f64s(simd.mul_f64s(a, *q), simd.mul_f64s(c, v)));
        }
    }
}

vectorised! {
    /// `out := m x`, `m` row by row, in whole groups.
    pub fn multiply(m: &'a [f64], x: &'a [f64], out: &'a mut [f64]) -> () as Multiply, simd {
        let size = x.len();
        let (tiles, rest) = m.split_at(m.len() / (TILE * size) * TILE * size);
        let (out, last) = out.split_at_mut(tiles.len() / size);
        for (rows, o) in tiles.chunks_exact(TILE * size).zip(out.chunks_exact_mut(TILE)) {
            o.copy_from_slice(&dots_with(simd, rows, size, x));
        }
        for (row, o) in rest.chunks_exact(size).zip(last) {
            *o = dot_with(simd, row, x);
        }
    }
}

/// Rows that stay in the nearest cache while others pass by.
const STRIP: usize = 16;

vectorised! {
    /// Inner products of all rows of a matrix with each other; rows of `size`, whole groups.
    pub fn gram(rows: &'a [f64], size: usize) -> Vec<f64> as Gram, simd {
        let count = rows.len() / size;
        let mut out = vec![0.0; count * count];
        for (s, strip) in rows.chunks(STRIP * size).enumerate() {
            for (i, row) in rows.chunks_exact(size).enumerate().skip(s * STRIP) {
                for (k, other) in strip.chunks_exact(size).enumerate().map(|(k, o)| (s * STRIP + k, o)) {
                    let product = dot_with(simd, row, other);
                    out[i * count + k] = product;
                    out[k * count + i] = product;
                }
            }
        }
        out
    }
}

vectorised! {
    /// `y += factor x`, in whole groups.
    pub fn add(y: &'a mut [f64], factor: f64, x: &'a [f64]) -> () as Add, simd {
        let factor = simd.splat_f64s(factor);
        for (a, b) in S::as_mut_simd_f64s(y).0.iter_mut().zip(S::as_simd_f64s(x).0) {
            *a = simd.add_f64s(*a, simd.mul_f64s(factor, *b));
        }
    }
}

/// A symmetric form `x . m x`, packed: row `i` up to its diagonal, rounded up to whole
/// lanes, off-diagonal entries doubled. Half the memory, and it stays in the nearest cache.
#[derive(Clone, Debug, Default)]
pub struct Form {
    rows: Vec<f64>,
}

impl Form {
    /// From the full matrix, row by row, of a size that is a multiple of [`LANES`].
    pub fn new(full: &[f64], size: usize) -> Self {
        let mut rows = Vec::new();
        for i in 0..size {
            for k in 0..(i + 1).next_multiple_of(LANES) {
                rows.push(match k.cmp(&i) {
                    std::cmp::Ordering::Less => full[i * size + k] + full[k * size + i],
                    std::cmp::Ordering::Equal => full[i * size + i],
                    std::cmp::Ordering::Greater => 0.0,
                });
            }
        }
        Self { rows }
    }

    /// `x . m x`.
    pub fn of(&self, x: &[f64]) -> f64 {
        quadratic(&self.rows, x)
    }

    /// The gradient of `x . m x`.
    pub fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let (mut out, mut rest) = (vec![0.0; x.len()], &self.rows[..]);
        for i in 0..x.len() {
            let (row, next) = rest.split_at((i + 1).next_multiple_of(LANES));
            rest = next;
            for k in 0..=i {
                out[i] += row[k] * x[k];
                out[k] += row[k] * x[i];
            }
        }
        out
    }
}

vectorised! {
    fn quadratic(rows: &'a [f64], x: &'a [f64]) -> f64 as Quadratic, simd {
        let (mut total, mut rest) = (0.0, rows);
        for (block, values) in x.chunks_exact(LANES).enumerate() {
            // The rows of a block are equally long.
            let size = (block + 1) * LANES;
            let (lines, next) = rest.split_at(LANES * size);
            rest = next;
            for (tile, values) in lines.chunks_exact(TILE * size).zip(values.chunks_exact(TILE)) {
                for (dot, value) in dots_with(simd, tile, size, &x[..size]).iter().zip(values) {
                    total += value * dot;
                }
            }
        }
        total
    }
}

/// Points of a [`Grid`].
pub const GRID: usize = 32;

/// A polynomial at the points `(i + 1) / GRID`.
pub struct Grid {
    /// Values.
    pub value: [f64; GRID],
    /// Second derivatives.
    pub second: [f64; GRID],
    /// Bounds on the third derivative from 0 to there (the polynomial of absolute
    /// coefficients, which only rises).
    pub third_bound: [f64; GRID],
}

/// The points of a [`Grid`].
static POINTS: [f64; GRID] = {
    let (mut x, mut i) = ([0.0; GRID], 0);
    while i < GRID {
        x[i] = (i + 1) as f64 / GRID as f64;
        i += 1;
    }
    x
};

/// `sum c_k x^k` at every point, the highest power first, by Horner's rule.
#[inline(always)]
fn horner_with<S: Simd>(simd: S, out: &mut [f64; GRID], c: impl Iterator<Item = f64>) {
    // Of a length that is known, so that nothing but sums is left.
    let x = &S::as_simd_f64s(&POINTS).0[..GRID / S::F64_LANES];
    let mut y = [simd.splat_f64s(0.0); GRID];
    for c in c {
        let c = simd.splat_f64s(c);
        for i in 0..GRID / S::F64_LANES {
            y[i] = simd.add_f64s(simd.mul_f64s(y[i], x[i]), c);
        }
    }
    let count = GRID / S::F64_LANES;
    S::as_mut_simd_f64s(out).0[..count].copy_from_slice(&y[..count]);
}

vectorised! {
    /// Looks at `sum q_k x^k` all over `[0, 1]` at once.
    pub fn on_grid(q: &'a [f64]) -> Grid as OnGrid, simd {
        let mut f = Grid { value: [0.0; GRID], second: [0.0; GRID], third_bound: [0.0; GRID] };
        let powers = || q.iter().enumerate().rev();
        let falling = |k: usize, n: usize| (k + 1 - n..=k).product::<usize>() as f64;
        horner_with(simd, &mut f.value, q.iter().rev().copied());
        let second = powers().take_while(|(k, _)| *k >= 2).map(|(k, c)| falling(k, 2) * c);
        horner_with(simd, &mut f.second, second);
        let third = powers().take_while(|(k, _)| *k >= 3).map(|(k, c)| falling(k, 3) * c.abs());
        horner_with(simd, &mut f.third_bound, third);
        f
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same sums without vectors, in the declared order: equal to the last bit. (That
    /// every width gives them is shown over whole runs, in `tests/vectors.rs`.)
    #[test]
    fn sums_are_made_in_the_declared_order() {
        let a: Vec<f64> = (0..48).map(|i| (f64::from(i) * 0.7).sin()).collect();
        let b: Vec<f64> = (0..48).map(|i| (f64::from(i) * 1.3).cos() * 1e3).collect();
        let mut x = [0.0; LANES];
        for (p, q) in a.chunks(LANES).zip(b.chunks(LANES)) {
            for l in 0..LANES {
                x[l] += p[l] * q[l];
            }
        }
        let plain = ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
        assert_eq!(dot(&a, &b).to_bits(), plain.to_bits());
    }

    #[test]
    fn a_packed_form_is_the_full_one() {
        let n = 16;
        let m: Vec<f64> = (0..n * n).map(|i| (i as f64).sin()).collect();
        let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.3).cos()).collect();
        let full: f64 =
            (0..n).map(|i| (0..n).map(|k| x[i] * m[i * n + k] * x[k]).sum::<f64>()).sum();
        // 256 terms of size at most 1, each rounded.
        assert!((Form::new(&m, n).of(&x) - full).abs() < 256.0 * f64::EPSILON);
    }
}
