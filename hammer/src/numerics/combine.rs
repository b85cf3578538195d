//! Products of a matrix, stored by columns, with a vector (see [`crate::numerics::kernel`]).

use crate::numerics::kernel::{LANES, MOST, vectorised};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Largest number of groups of lanes whose sums fit into the registers.
const WIDEST: usize = 6;
/// Number of columns that are summed before their sum is added to the total. A term of a sum of `n` terms is then
/// rounded about `BLOCK + n / BLOCK` times instead of `n` times.
const BLOCK: usize = 24;
/// Number of vectors that hold the sums of [`WIDEST`] groups.
const SUMS: usize = WIDEST * MOST;

/// `out[at..] := sum x_k column_k`, for `WIDTH` groups of lanes.
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

/// Largest number of roundings that a term of [`combine`] undergoes, including that of its product. Each is at most
/// half an `eps`. `n` is the length of both parts together. Sums begin with zero, and adding to zero does not round.
pub fn roundings(n: usize) -> usize {
    let blocks = 2 + n / BLOCK; // The last block of each part may be shorter.
    BLOCK.min(n) + blocks
}

/// Columns of a matrix that are stored one after the other.
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    /// The numbers of all columns.
    pub numbers: &'a [f64],
    /// Length of a column.
    pub stride: usize,
    /// Number of entries that are skipped at the start of each column.
    pub offset: usize,
}

/// A matrix of at most this many numbers (256 kB) stays in the nearer caches. A larger one is read in its order in
/// memory.
const NEAR: usize = 1 << 15;
/// Number of rows of a larger matrix whose sums stay in the nearest cache.
const ROWS_AT_ONCE: usize = 512;
/// Number of columns that are added to these sums in one pass.
const TOGETHER: usize = 8;

/// `part += sum x_k column_k` for [`TOGETHER`] columns, in their order. If `FRESH`, `part` starts at zero. (Chained
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

/// `part += x column`.
#[inline(always)]
fn add_column<S: Simd>(simd: S, column: &[f64], x: f64, part: &mut [f64]) {
    let x = simd.splat_f64s(x);
    let column = S::as_simd_f64s(&column[..part.len()]).0;
    for (part, c) in S::as_mut_simd_f64s(part).0.iter_mut().zip(column) {
        *part = simd.add_f64s(*part, simd.mul_f64s(x, *c));
    }
}

/// `part := sum x_k column_k` in the order of the columns, in passes of [`TOGETHER`] columns.
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

/// [`combine`] for a matrix larger than [`NEAR`]. It makes the same sums, but reads a few whole columns at a time.
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
    /// `out := sum x_k column_k` in the order of the columns. Each column is as long as `out`, which is a whole number
    /// of groups of lanes. A term is rounded up to `n` times.
    pub fn combine_in_order(columns: &'a [f64], x: &'a [f64], out: &'a mut [f64]) -> () as CombineInOrder, simd {
        sum_columns(simd, (columns, out.len()), x, out);
    }
}

vectorised! {
    /// `out := sum x_k column_k`, where `out` is a whole number of groups of lanes. `x` has two parts, for the first
    /// and the last columns. [`roundings`] bounds the rounding.
    pub fn combine(columns: Columns<'a>, x: [&'a [f64]; 2], out: &'a mut [f64]) -> () as Combine, simd {
        if columns.numbers.len() > NEAR {
            return combine_far(simd, columns, x, out);
        }
        let (size, mut at) = (out.len(), 0);
        while at < size {
            let groups = (size - at) / LANES;
            match groups {
                1 => combine_with::<S, 1>(simd, columns, at, x, out),
                2 => combine_with::<S, 2>(simd, columns, at, x, out),
                3 => combine_with::<S, 3>(simd, columns, at, x, out),
                4 => combine_with::<S, 4>(simd, columns, at, x, out),
                5 => combine_with::<S, 5>(simd, columns, at, x, out),
                _ => combine_with::<S, WIDEST>(simd, columns, at, x, out),
            }
            at += LANES * groups.min(WIDEST);
        }
    }
}
