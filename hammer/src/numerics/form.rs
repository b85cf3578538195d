//! A packed symmetric quadratic form, evaluated with vector instructions (see [`crate::numerics::kernel`]).

use crate::numerics::kernel::{LANES, MOST, Sums, TILE, across, groups, total, vectorised};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// A symmetric form `x . m x`. Each row is stored up to its diagonal, rounded up to whole groups of lanes, with its
/// off-diagonal entries doubled. This halves the memory, so that the form stays in the nearest cache. [`TILE`] rows are
/// interleaved, so that a loop over them reads all numbers in order.
#[derive(Clone, Debug, Default)]
pub struct Form {
    rows: Vec<f64>,
    /// If the form consists of 2 by 2 blocks, the three entries of every block, instead of the rows.
    blocks: Option<[Vec<f64>; 3]>,
}

impl Form {
    /// The zero form of a size that is a multiple of [`LANES`].
    pub fn zero(size: usize) -> Self {
        Self { rows: vec![0.0; Self::at(size, 0)], blocks: None }
    }

    /// Index of the entry at `(i, k)`. If `i` is a multiple of [`LANES`] and `k` is 0, this is the number of entries of
    /// all rows before.
    fn at(i: usize, k: usize) -> usize {
        // The rows of a block of LANES rows all have the length that ends with the block's diagonal.
        let (block, tile) = (i / LANES, i % LANES / TILE * TILE);
        let start = LANES * (block + 1) * (LANES * block / 2 + tile);
        start + LANES * (k / LANES * TILE + i % TILE) + k % LANES
    }

    /// Sets the entries of the symmetric matrix at `(i, k)` and `(k, i)`, where `k <= i`.
    #[inline]
    pub(crate) fn set(&mut self, i: usize, k: usize, value: f64) {
        debug_assert!(k <= i, "above the diagonal");
        self.rows[Self::at(i, k)] = if k == i { value } else { 2.0 * value };
    }

    /// The same form, if only its entries at `(i, i)` and `(i, i + apart)` are not zero. Sums then skip the other
    /// entries, and the result is identical to the last binary digit.
    pub(crate) fn of_blocks(self, apart: usize) -> Self {
        debug_assert!(apart.is_multiple_of(LANES), "both coordinates are in one lane");
        let entries = |[first, second]: [usize; 2]| {
            (0..apart).map(|i| self.rows[Self::at(first + i, second + i)]).collect()
        };
        let blocks = [[0, 0], [apart, 0], [apart, apart]].map(entries);
        Self { rows: Vec::new(), blocks: Some(blocks) }
    }

    /// `x . m x`.
    pub fn of(&self, x: &[f64]) -> f64 {
        self.blocks.as_ref().map_or_else(|| quadratic(&self.rows, x), |blocks| of_blocks(blocks, x))
    }

    /// `2 m x`.
    pub(crate) fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; x.len()];
        let mut add = |i: usize, k: usize, entry: f64| {
            product[i] += entry * x[k];
            product[k] += entry * x[i];
        };
        if let Some([upper, cross, lower]) = &self.blocks {
            let n = upper.len();
            for i in 0..n {
                add(i, i, upper[i]);
                add(n + i, i, cross[i]);
                add(n + i, n + i, lower[i]);
            }
        } else {
            for i in 0..x.len() {
                (0..=i).for_each(|k| add(i, k, self.rows[Self::at(i, k)]));
            }
        }
        product
    }
}

/// The sums of [`quadratic`] for a form of 2 by 2 blocks.
fn of_blocks([upper, cross, lower]: &[Vec<f64>; 3], x: &[f64]) -> f64 {
    let (first, second) = x.split_at(upper.len());
    let groups = |x| <[f64]>::chunks_exact(x, LANES);
    let mut sums = [0.0; LANES];
    for (x, a) in groups(first).zip(groups(upper)) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * (0.0 + a[lane] * x[lane]);
        }
    }
    for (((x, y), b), c) in groups(first).zip(groups(second)).zip(groups(cross)).zip(groups(lower))
    {
        for lane in 0..LANES {
            sums[lane] += y[lane] * ((0.0 + b[lane] * x[lane]) + c[lane] * y[lane]);
        }
    }
    across(&sums)
}

vectorised! {
    fn quadratic(rows: &'a [f64], x: &'a [f64]) -> f64 as Quadratic, simd {
        // The lanes of the sums stay separate until the end.
        let (mut sums, mut rest): (Sums<S>, _) = ([simd.splat_f64s(0.0); MOST], rows);
        let width = LANES / S::F64_LANES;
        for (block, values) in x.chunks_exact(LANES).enumerate() {
            // The rows of a block all have this length.
            let size = (block + 1) * LANES;
            for values in values.chunks_exact(TILE) {
                let (tile, next) = rest.split_at(TILE * size);
                rest = next;
                let mut parts: [Sums<S>; TILE] = [[simd.splat_f64s(0.0); MOST]; TILE];
                let entries = S::as_simd_f64s(tile).0.chunks_exact(TILE * width);
                for (entries, x) in entries.zip(groups::<S>(&x[..size])) {
                    for (k, part) in parts.iter_mut().enumerate() {
                        for g in 0..width {
                            let product = simd.mul_f64s(entries[k * width + g], x[g]);
                            part[g] = simd.add_f64s(part[g], product);
                        }
                    }
                }
                for (part, value) in parts.iter().zip(values) {
                    let value = simd.splat_f64s(*value);
                    for g in 0..width {
                        sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(value, part[g]));
                    }
                }
            }
        }
        total::<S>(sums)
    }
}
