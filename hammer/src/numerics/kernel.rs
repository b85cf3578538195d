//! The loops over modes, which determine the engine's speed.
//!
//! A modal vector is stored as `[first coordinates | second coordinates]`, each padded with zeros to whole groups of
//! [`LANES`]. Every loop works on such groups with the widest vectors of the processor ([`crate::numerics::vectors`]).
//! Sums are added in the same order on all processors, and products are never fused with sums, so the result does not
//! depend on the machine.

use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Numbers in a group.
pub const LANES: usize = 8;

/// Most vectors per group (on a machine without vector instructions).
pub(crate) const MOST: usize = LANES;

/// A group of sums held in vectors.
pub(crate) type Sums<S> = [<S as Simd>::f64s; MOST];

/// Groups of a slice as vectors: `LANES / S::F64_LANES` a group.
#[inline(always)]
pub(crate) fn groups<S: Simd>(x: &[f64]) -> std::slice::ChunksExact<'_, S::f64s> {
    S::as_simd_f64s(x).0.chunks_exact(LANES / S::F64_LANES)
}

/// Adds up a group, always in the same order.
#[inline(always)]
pub(crate) fn total<S: Simd>(sums: Sums<S>) -> f64 {
    let mut x = [0.0; LANES];
    for (out, s) in S::as_mut_simd_f64s(&mut x).0.iter_mut().zip(sums) {
        *out = s;
    }
    across(&x)
}

/// Adds the lanes of a sum.
#[inline(always)]
pub(crate) fn across(x: &[f64; LANES]) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}

/// Rows of a matrix that are processed together, so that their sums fit into the registers.
pub(crate) const TILE: usize = 4;

/// The products of [`TILE`] rows of `size` numbers with `x`, in the order of [`dot`]. The lanes of each sum are not yet
/// added up.
#[inline(always)]
pub(crate) fn tile_with<S: Simd>(simd: S, rows: &[f64], size: usize, x: &[f64]) -> [Sums<S>; TILE] {
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
    sums
}

/// Groups of a slice as vectors, to be written.
#[inline(always)]
pub(crate) fn groups_mut<S: Simd>(x: &mut [f64]) -> std::slice::ChunksExactMut<'_, S::f64s> {
    S::as_mut_simd_f64s(x).0.chunks_exact_mut(LANES / S::F64_LANES)
}

/// Vector `g` of a group of blocks, rotated.
#[inline(always)]
fn turned<S: Simd>(simd: S, e: &[S::f64s], g: usize, x: S::f64s, y: S::f64s) -> (S::f64s, S::f64s) {
    // Closures would be slow in an unoptimised build.
    let width = LANES / S::F64_LANES;
    let first = simd.mul_f64s(e[g], x);
    let second = simd.mul_f64s(e[2 * width + g], x);
    (
        simd.add_f64s(first, simd.mul_f64s(e[width + g], y)),
        simd.add_f64s(second, simd.mul_f64s(e[3 * width + g], y)),
    )
}

/// Declares a function that is compiled for each kind of vectors.
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
    /// `y := E y` block by block; `e` is [`interleaved`].
    pub fn rotate(e: &'a [f64], y: &'a mut [f64]) -> () as Rotate, simd {
        let (p, q) = y.split_at_mut(y.len() / 2);
        let e = S::as_simd_f64s(e).0.chunks_exact(4 * (LANES / S::F64_LANES));
        for ((p, q), e) in groups_mut::<S>(p).zip(groups_mut::<S>(q)).zip(e) {
            for g in 0..LANES / S::F64_LANES {
                (p[g], q[g]) = turned(simd, e, g, p[g], q[g]);
            }
        }
    }
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

vectorised! {
    /// `a . b`, in whole groups.
    pub fn dot(a: &'a [f64], b: &'a [f64]) -> f64 as Dot, simd {
        dot_with(simd, a, b)
    }
}

vectorised! {
    /// [`dot`] of `x` with each of the rows, which are as long and stored one after the other.
    pub fn products(x: &'a [f64], rows: &'a [f64], out: &'a mut [f64]) -> () as Products, simd {
        let size = x.len();
        let (tiles, rest) = out.as_chunks_mut::<TILE>();
        let (tiled, single) = rows.split_at(tiles.len() * TILE * size);
        for (out, rows) in tiles.iter_mut().zip(tiled.chunks_exact(TILE * size)) {
            *out = tile_with(simd, rows, size, x).map(total::<S>);
        }
        for (out, row) in rest.iter_mut().zip(single.chunks_exact(size)) {
            *out = dot_with(simd, row, x);
        }
    }
}

vectorised! {
    /// `a . b` for any length, in the order of [`dot`]. The last group may be partial.
    pub fn inner_product(a: &'a [f64], b: &'a [f64]) -> f64 as InnerProduct, simd {
        let length = a.len().min(b.len());
        let (a, b) = (&a[..length], &b[..length]);
        let mut sums: Sums<S> = [simd.splat_f64s(0.0); MOST];
        for (x, y) in groups::<S>(a).zip(groups::<S>(b)) {
            for g in 0..LANES / S::F64_LANES {
                sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(x[g], y[g]));
            }
        }
        let whole = length / LANES * LANES;
        let mut lanes = [0.0; LANES];
        for (out, s) in S::as_mut_simd_f64s(&mut lanes).0.iter_mut().zip(sums) {
            *out = s;
        }
        for ((sum, x), y) in lanes.iter_mut().zip(&a[whole..]).zip(&b[whole..]) {
            *sum += x * y;
        }
        across(&lanes)
    }
}

/// The length of a vector.
pub fn norm(x: &[f64]) -> f64 {
    inner_product(x, x).sqrt()
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

/// One number from each of several series.
pub type Row = [f64; LANES];

vectorised! {
    /// Values of polynomials side by side, by Horner's rule.
    pub fn horner(rows: &'a [Row], t: f64) -> Row as Horner, simd {
        let (t, mut sums): (_, Sums<S>) = (simd.splat_f64s(t), [simd.splat_f64s(0.0); MOST]);
        for row in rows.iter().rev() {
            let row = S::as_simd_f64s(row).0;
            for g in 0..LANES / S::F64_LANES {
                sums[g] = simd.add_f64s(simd.mul_f64s(sums[g], t), row[g]);
            }
        }
        let mut values = [0.0; LANES];
        S::as_mut_simd_f64s(&mut values).0.copy_from_slice(&sums[..LANES / S::F64_LANES]);
        values
    }
}

/// True if every number is finite. The slice has whole groups.
pub fn is_finite(y: &[f64]) -> bool {
    // A finite number times zero is zero; any other number times zero is NaN.
    let mut sums = [0.0; LANES];
    for group in y.chunks_exact(LANES) {
        sums.iter_mut().zip(group).for_each(|(sum, y)| *sum += 0.0 * y);
    }
    sums == [0.0; LANES]
}

/// Rows of an [`EvaluationRows`].
const ROWS: usize = 4;

/// Four rows in the order in which [`evaluate`] reads them: for every group of blocks, `[r | s | w | u]` of the first
/// coordinates, then of the second.
#[derive(Clone, Debug)]
pub struct EvaluationRows(Vec<f64>);

impl EvaluationRows {
    /// Interleaves two rows and two rows of weights.
    pub fn new(rows: [&[f64]; ROWS]) -> Self {
        let n = rows[0].len() / 2;
        let mut table = Vec::with_capacity(2 * ROWS * n);
        for group in (0..n).step_by(LANES) {
            for half in [group, n + group] {
                rows.iter().for_each(|row| table.extend_from_slice(&row[half..half + LANES]));
            }
        }
        Self(table)
    }
}

/// Columns of `n` numbers in the order in which the loops read them: group by group.
pub fn interleaved(columns: &[f64], n: usize) -> Vec<f64> {
    let mut table = Vec::with_capacity(columns.len());
    for group in (0..n).step_by(LANES) {
        columns.chunks_exact(n).for_each(|c| table.extend_from_slice(&c[group..group + LANES]));
    }
    table
}

/// The first `ASKED` sums of [`evaluate`], held in vectors.
type Values<S, const ASKED: usize> = [Sums<S>; ASKED];

/// Adds the products of one group's rows, `[r | s | w | u]`, with its vector `g` of `y`.
#[inline(always)]
fn see<S: Simd, const ASKED: usize>(
    simd: S,
    sums: &mut Values<S, ASKED>,
    rows: &[S::f64s],
    g: usize,
    y: S::f64s,
) {
    let (count, size) = (LANES / S::F64_LANES, simd.abs_f64s(y));
    for (k, of) in [y, y, size, size].into_iter().take(ASKED).enumerate() {
        sums[k][g] = simd.add_f64s(sums[k][g], simd.mul_f64s(rows[k * count + g], of));
    }
}

vectorised! {
    /// `[r . y, s . y, w . |y|, u . |y|]` in one pass.
    pub fn evaluate(rows: &'a EvaluationRows, y: &'a [f64]) -> [f64; 4] as Evaluate, simd {
        let count = LANES / S::F64_LANES;
        let (p, q) = y.split_at(y.len() / 2);
        let mut sums: Values<S, ROWS> = [[simd.splat_f64s(0.0); MOST]; ROWS];
        let rows = S::as_simd_f64s(&rows.0).0.chunks_exact(2 * ROWS * count);
        for ((p, q), rows) in groups::<S>(p).zip(groups::<S>(q)).zip(rows) {
            let (first, second) = rows.split_at(ROWS * count);
            for g in 0..count {
                see(simd, &mut sums, first, g, p[g]);
                see(simd, &mut sums, second, g, q[g]);
            }
        }
        sums.map(total::<S>)
    }
}

#[inline(always)]
fn rotate_and_sum<S: Simd, const ASKED: usize>(
    simd: S,
    e: &[f64],
    rows: &EvaluationRows,
    y: &[f64],
    out: &mut [f64],
) -> [f64; ASKED] {
    let count = LANES / S::F64_LANES;
    let (p, q) = y.split_at(y.len() / 2);
    let (first, second) = out.split_at_mut(y.len() / 2);
    let mut sums: Values<S, ASKED> = [[simd.splat_f64s(0.0); MOST]; ASKED];
    let rows = S::as_simd_f64s(&rows.0).0.chunks_exact(2 * ROWS * count);
    let e = S::as_simd_f64s(e).0.chunks_exact(4 * count);
    let from = groups::<S>(p).zip(groups::<S>(q));
    let to = groups_mut::<S>(first).zip(groups_mut::<S>(second));
    for ((((p, q), (first, second)), rows), e) in from.zip(to).zip(rows).zip(e) {
        for g in 0..count {
            let (x, y) = turned(simd, e, g, p[g], q[g]);
            (first[g], second[g]) = (x, y);
            see(simd, &mut sums, &rows[..ROWS * count], g, x);
            see(simd, &mut sums, &rows[ROWS * count..], g, y);
        }
    }
    sums.map(total::<S>)
}

vectorised! {
    /// `out := E y` as in [`rotate`], and [`evaluate`] of the result, in one pass.
    pub fn rotate_and_evaluate(e: &'a [f64], rows: &'a EvaluationRows, y: &'a [f64], out: &'a mut [f64]) -> [f64; ROWS] as RotateAndEvaluate, simd {
        rotate_and_sum(simd, e, rows, y, out)
    }
}

vectorised! {
    /// [`rotate_and_evaluate`] without the bounds, which takes little more than half the time.
    pub fn rotate_and_evaluate_two(e: &'a [f64], rows: &'a EvaluationRows, y: &'a [f64], out: &'a mut [f64]) -> [f64; 2] as RotateAndEvaluateTwo, simd {
        rotate_and_sum(simd, e, rows, y, out)
    }
}

/// Number of powers after the first in the series of [`short`].
pub const POWERS: usize = 11;

/// A short span, in seconds and in the unit of [`short`]'s series.
#[derive(Clone, Copy)]
pub struct Short {
    /// `span`, s.
    pub span: f64,
    /// `x`.
    pub x: f64,
}

#[inline(always)]
fn short_with<S: Simd, const TERMS: usize>(
    simd: S,
    [b, series]: [&[f64]; 2],
    Short { span, x }: Short,
    y: &mut [f64],
) {
    let width = LANES / S::F64_LANES;
    let (p, q) = y.split_at_mut(y.len() / 2);
    let [lane, square, step] = [x, x * x, span].map(|x| simd.splat_f64s(x));
    let b = S::as_simd_f64s(b).0.chunks_exact(4 * width);
    let series = S::as_simd_f64s(series).0.chunks_exact(2 * POWERS * width);
    for (((p, q), b), series) in groups_mut::<S>(p).zip(groups_mut::<S>(q)).zip(b).zip(series) {
        for g in 0..width {
            let (mut a, mut c) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
            for k in (0..TERMS).rev() {
                a = simd.add_f64s(simd.mul_f64s(a, lane), series[2 * k * width + g]);
                c = simd.add_f64s(simd.mul_f64s(c, lane), series[(2 * k + 1) * width + g]);
            }
            let a = simd.mul_f64s(square, a);
            let c = simd.add_f64s(step, simd.mul_f64s(step, simd.mul_f64s(lane, c)));
            let (u, v) = turned(simd, b, g, p[g], q[g]);
            p[g] = simd.add_f64s(p[g], simd.add_f64s(simd.mul_f64s(a, p[g]), simd.mul_f64s(c, u)));
            q[g] = simd.add_f64s(q[g], simd.add_f64s(simd.mul_f64s(a, q[g]), simd.mul_f64s(c, v)));
        }
    }
}

/// Numbers `k` of powers that [`short`] can use. With each comes the largest `x` for which the first omitted term,
/// `x^(k+2) / (k+2)!`, is below rounding.
const ENOUGH: [(f64, usize); 5] =
    [(SLIGHT, 3), (0.012, 5), (SHORT, 7), (0.13, 9), (LONGEST, POWERS)];
/// Up to this `x` the shortest series is enough.
const SLIGHT: f64 = 1e-3;
/// Up to this `x`, [`short`] costs as much as one or two tabulated rotations.
pub const SHORT: f64 = 0.03;
/// The largest `x` of [`short`].
pub const LONGEST: f64 = 0.25;

vectorised! {
    /// `y := exp(B span) y` for a short span of either sign. Every block's exponential is `1 + x^2 sum_k a_k x^k + span
    /// (1 + x sum_k c_k x^k) B`, with as many powers of `x` as necessary. `series` holds `[a_0 | c_0 | a_1 | c_1 ...]`
    /// for every group of blocks; `b` is [`interleaved`].
    pub fn short(b: &'a [f64], series: &'a [f64], span: Short, y: &'a mut [f64]) -> () as ShortRotation, simd {
        let tables = [b, series];
        let [(least, _), (less, _), (usual, _), (long, _), _] = ENOUGH;
        match span.x.abs() {
            x if x <= least => short_with::<S, { ENOUGH[0].1 }>(simd, tables, span, y),
            x if x <= less => short_with::<S, { ENOUGH[1].1 }>(simd, tables, span, y),
            x if x <= usual => short_with::<S, { ENOUGH[2].1 }>(simd, tables, span, y),
            x if x <= long => short_with::<S, { ENOUGH[3].1 }>(simd, tables, span, y),
            _ => short_with::<S, { ENOUGH[4].1 }>(simd, tables, span, y),
        }
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

vectorised! {
    /// `y += sum_k factors_k column_k`. The columns are as long as `y`, stored one after the other, in whole groups.
    pub fn add_columns(y: &'a mut [f64], factors: &'a [f64], columns: &'a [f64]) -> () as AddColumns, simd {
        let (size, width) = (y.len(), LANES / S::F64_LANES);
        for (at, y) in groups_mut::<S>(y).enumerate() {
            let mut sums: Sums<S> = [simd.splat_f64s(0.0); MOST];
            sums[..width].copy_from_slice(y);
            for (factor, column) in factors.iter().zip(columns.chunks_exact(size)) {
                let factor = simd.splat_f64s(*factor);
                let column = S::as_simd_f64s(&column[at * LANES..][..LANES]).0;
                for g in 0..width {
                    sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(factor, column[g]));
                }
            }
            y.copy_from_slice(&sums[..width]);
        }
    }
}

pub(crate) use vectorised;
