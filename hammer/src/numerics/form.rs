//! A symmetric quadratic form, packed, in vectors (see [`crate::numerics::kernel`]).

use crate::numerics::kernel::{LANES, MOST, Sums, TILE, tile_with, total, vectorised};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// A symmetric form `x . m x`, packed: row `i` up to its diagonal, rounded up to whole
/// lanes, off-diagonal entries doubled. Half the memory, and it stays in the nearest cache.
#[derive(Clone, Debug, Default)]
pub struct Form {
    rows: Vec<f64>,
}

impl Form {
    /// Zero, of a size that is a multiple of [`LANES`].
    pub fn zero(size: usize) -> Self {
        Self { rows: vec![0.0; Self::row(size)] }
    }

    /// Where row `i` begins.
    fn row(i: usize) -> usize {
        // Of every block before LANES rows, each as long as the block's end.
        let (block, rest) = (i / LANES, i % LANES);
        LANES * (block + 1) * (LANES * block / 2 + rest)
    }

    /// Sets the entries of the symmetric matrix at `(i, k)` and `(k, i)`, `k` not above `i`.
    #[inline]
    pub(crate) fn set(&mut self, i: usize, k: usize, value: f64) {
        debug_assert!(k <= i, "above the diagonal");
        self.rows[Self::row(i) + k] = if k == i { value } else { 2.0 * value };
    }

    /// From the full matrix, row by row.
    #[cfg(test)]
    fn new(full: &[f64], size: usize) -> Self {
        let mut form = Self::zero(size);
        for i in 0..size {
            (0..=i).for_each(|k| form.set(i, k, 0.5 * (full[i * size + k] + full[k * size + i])));
        }
        form
    }

    /// `x . m x`.
    pub fn of(&self, x: &[f64]) -> f64 {
        quadratic(&self.rows, x)
    }
}

vectorised! {
    fn quadratic(rows: &'a [f64], x: &'a [f64]) -> f64 as Quadratic, simd {
        // Lane by lane: only the last sum is across the lanes.
        let (mut sums, mut rest): (Sums<S>, _) = ([simd.splat_f64s(0.0); MOST], rows);
        for (block, values) in x.chunks_exact(LANES).enumerate() {
            // The rows of a block are equally long.
            let size = (block + 1) * LANES;
            for values in values.chunks_exact(TILE) {
                let (tile, next) = rest.split_at(TILE * size);
                rest = next;
                for (part, value) in tile_with(simd, tile, size, &x[..size]).iter().zip(values) {
                    let value = simd.splat_f64s(*value);
                    for g in 0..LANES / S::F64_LANES {
                        sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(value, part[g]));
                    }
                }
            }
        }
        total::<S>(sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packed_form_is_the_full_one() {
        let n = 16;
        let m: Vec<f64> = (0..n * n).map(|i| (i as f64).sin()).collect();
        let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.3).cos()).collect();
        let full: f64 =
            (0..n).map(|i| (0..n).map(|k| x[i] * m[i * n + k] * x[k]).sum::<f64>()).sum();
        // 256 terms of size at most 1, each rounded.
        let form = Form::new(&m, n);
        assert!((form.of(&x) - full).abs() < 256.0 * f64::EPSILON);
    }
}
