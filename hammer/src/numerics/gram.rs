//! Inner products of all pairs of many vectors (see [`crate::numerics::kernel`]).

use crate::numerics::kernel::{TILE, tile_with, total, vectorised};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Number of rows that stay in the first-level cache while all others are read.
const STRIP: usize = 16;

vectorised! {
    /// Inner products of all pairs of rows of a matrix, up to the diagonal. Rows have the length `size`, a whole number
    /// of groups of lanes. If `stops` returns true, the function returns at once with an incomplete result.
    pub fn gram(rows: &'a [f64], size: usize, stops: fn() -> bool) -> Vec<f64> as Gram, simd {
        let count = rows.len() / size;
        let mut out = vec![0.0; count * count];
        for (s, strip) in rows.chunks(STRIP * size).enumerate() {
            if stops() {
                break;
            }
            for (i, row) in rows.chunks_exact(size).enumerate().skip(s * STRIP) {
                let out = &mut out[i * count + s * STRIP..];
                let tiles = strip.chunks_exact(TILE * size).zip(out.chunks_exact_mut(TILE));
                for (tile, out) in tiles {
                    out.copy_from_slice(&tile_with(simd, tile, size, row).map(total::<S>));
                }
            }
        }
        out
    }
}
