//! Products of a matrix, stored by columns, with a vector (see [`crate::numerics::kernel`]).

use crate::numerics::kernel::{LANES, MOST, vectorised};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Most groups whose sums fit into the registers.
const WIDEST: usize = 6;
/// Columns that are summed before they are added to the rest. A term of `n` is then rounded about `BLOCK + n / BLOCK`
/// times, not `n` times.
const BLOCK: usize = 24;
/// Vectors that hold the sums of [`WIDEST`] groups.
const SUMS: usize = WIDEST * MOST;

/// `out[at..] := sum x_k column_k`, for `WIDTH` groups.
#[inline(always)]
fn combine_with<S: Simd, const WIDTH: usize>(
    simd: S,
    columns: Columns,
    at: usize,
    x: [&[f64]; 2],
    out: &mut [f64],
) {
    let count = WIDTH * LANES / S::F64_LANES;
    let mut sums = [simd.splat_f64s(0.0); SUMS];
    let start = columns.offset + at;
    let last = columns.numbers.len() - x[1].len() * columns.stride;
    let (first, second) = columns.numbers.split_at(last);
    for (numbers, x) in [first, second].into_iter().zip(x) {
        for (block, x) in numbers.chunks(BLOCK * columns.stride).zip(x.chunks(BLOCK)) {
            let mut part = [simd.splat_f64s(0.0); SUMS];
            for (column, x) in block.chunks_exact(columns.stride).zip(x) {
                let column = S::as_simd_f64s(&column[start..start + WIDTH * LANES]).0;
                let x = simd.splat_f64s(*x);
                for (sum, c) in part[..count].iter_mut().zip(column) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(x, *c));
                }
            }
            for (sum, part) in sums[..count].iter_mut().zip(part) {
                *sum = simd.add_f64s(*sum, part);
            }
        }
    }
    S::as_mut_simd_f64s(&mut out[at..at + WIDTH * LANES]).0.copy_from_slice(&sums[..count]);
}

/// Most roundings in a product of [`combine`], multiplications included, each of half an `eps`; `n` is the length of
/// both parts. Sums begin with zeros, which round nothing.
pub fn roundings(n: usize) -> usize {
    let blocks = 2 + n / BLOCK; // Each part may end with one that is not full.
    BLOCK.min(n) + blocks
}

/// Columns, one after the other, each `stride` long and read from `offset`.
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    /// All numbers.
    pub numbers: &'a [f64],
    /// Length of a column.
    pub stride: usize,
    /// Numbers skipped at the start of each.
    pub offset: usize,
}

/// Numbers of a matrix that stays in the nearer caches: 256 kB. A larger one is read in its order in memory.
const NEAR: usize = 1 << 15;
/// Rows of a larger matrix whose sums stay in the nearest cache.
const ROWS_AT_ONCE: usize = 512;
/// Columns that are added to these sums together.
const TOGETHER: usize = 8;

/// `part += sum x_k column_k` for [`TOGETHER`] columns, in their order; `part` counts as zero if `FRESH`. (Chained
/// iterators need no bounds checks.)
#[inline(always)]
fn add_columns<S: Simd, const FRESH: bool>(
    simd: S,
    (columns, stride): (&[f64], usize),
    x: &[f64],
    part: &mut [f64],
) {
    let size = part.len();
    let column = |k: usize| S::as_simd_f64s(&columns[k * stride..][..size]).0.iter();
    let x: [S::f64s; TOGETHER] = std::array::from_fn(|k| simd.splat_f64s(x[k]));
    let (low, high) = (
        column(0).zip(column(1)).zip(column(2)).zip(column(3)),
        column(4).zip(column(5)).zip(column(6)).zip(column(7)),
    );
    let parts = S::as_mut_simd_f64s(part).0.iter_mut();
    for ((part, (((a, b), c), d)), (((e, f), g), h)) in parts.zip(low).zip(high) {
        let mut sum = if FRESH { simd.splat_f64s(0.0) } else { *part };
        for (x, column) in x.into_iter().zip([a, b, c, d, e, f, g, h]) {
            sum = simd.add_f64s(sum, simd.mul_f64s(x, *column));
        }
        *part = sum;
    }
}

/// The same for one column.
#[inline(always)]
fn add_column<S: Simd>(simd: S, column: &[f64], x: f64, part: &mut [f64]) {
    let x = simd.splat_f64s(x);
    let column = S::as_simd_f64s(&column[..part.len()]).0;
    for (part, c) in S::as_mut_simd_f64s(part).0.iter_mut().zip(column) {
        *part = simd.add_f64s(*part, simd.mul_f64s(x, *c));
    }
}

/// `part := sum x_k column_k` in the order of the columns, a few at a time.
#[inline(always)]
fn sum_columns<S: Simd>(simd: S, (columns, stride): (&[f64], usize), x: &[f64], part: &mut [f64]) {
    let whole = x.len() / TOGETHER * TOGETHER;
    if whole == 0 {
        part.fill(0.0);
    }
    for (k, x) in x[..whole].chunks_exact(TOGETHER).enumerate() {
        let columns = &columns[k * TOGETHER * stride..];
        if k == 0 {
            add_columns::<S, true>(simd, (columns, stride), x, part);
        } else {
            add_columns::<S, false>(simd, (columns, stride), x, part);
        }
    }
    for (k, x) in (whole..).zip(&x[whole..]) {
        add_column(simd, &columns[k * stride..], *x, part);
    }
}

/// [`combine`] of a matrix larger than [`NEAR`]: the same sums, by a few whole columns at a time.
#[inline(always)]
fn combine_far<S: Simd>(simd: S, columns: Columns, x: [&[f64]; 2], out: &mut [f64]) {
    let Columns { numbers, stride, offset } = columns;
    let (first, second) = numbers.split_at(numbers.len() - x[1].len() * stride);
    let mut part = [0.0; ROWS_AT_ONCE];
    for (step, out) in out.chunks_mut(ROWS_AT_ONCE).enumerate() {
        let (start, part) = (offset + step * ROWS_AT_ONCE, &mut part[..out.len()]);
        out.fill(0.0);
        for (numbers, x) in [first, second].into_iter().zip(x) {
            for (block, x) in numbers.chunks(BLOCK * stride).zip(x.chunks(BLOCK)) {
                sum_columns(simd, (&block[start..], stride), x, part);
                let parts = S::as_simd_f64s(part).0;
                for (sum, part) in S::as_mut_simd_f64s(out).0.iter_mut().zip(parts) {
                    *sum = simd.add_f64s(*sum, *part);
                }
            }
        }
    }
}

vectorised! {
    /// `out := sum x_k column_k` in the order of the columns, each as long as `out`, in whole groups. A term is
    /// rounded `n` times.
    pub fn combine_in_order(columns: &'a [f64], x: &'a [f64], out: &'a mut [f64]) -> () as CombineInOrder, simd {
        sum_columns(simd, (columns, out.len()), x, out);
    }
}

vectorised! {
    /// `out := sum x_k column_k`, in whole groups; `x` is in two parts, for the first and for the last columns. For
    /// the roundings see [`roundings`].
    pub fn combine(columns: Columns<'a>, x: [&'a [f64]; 2], out: &'a mut [f64]) -> () as Combine, simd {
        if columns.numbers.len() > NEAR {
            return combine_far(simd, columns, x, out);
        }
        let (size, mut at) = (out.len(), 0);
        while at < size {
            let left = (size - at) / LANES;
            match left {
                1 => combine_with::<S, 1>(simd, columns, at, x, out),
                2 => combine_with::<S, 2>(simd, columns, at, x, out),
                3 => combine_with::<S, 3>(simd, columns, at, x, out),
                4 => combine_with::<S, 4>(simd, columns, at, x, out),
                5 => combine_with::<S, 5>(simd, columns, at, x, out),
                _ => combine_with::<S, WIDEST>(simd, columns, at, x, out),
            }
            at += LANES * left.min(WIDEST);
        }
    }
}
