//! Products of power series, many side by side.

use super::PATHS;
use crate::numerics::series::ORDER;
use pulp::Simd;

/// Products that are summed together.
pub(super) const HALF: usize = 4;
/// Most halves: one or two of both chambers, and as many per flow path.
const HALVES: usize = 2 * (1 + PATHS);
/// Numbers in a row. All halves together are whole vectors on every processor.
const WIDE: usize = HALVES * HALF;

/// A number for each product of a half.
pub(super) type Half = [f64; HALF];

/// One number for each product.
type Wide = [f64; WIDE];

/// The factors of the products of series, one product a lane, of which only the first halves are in use. The right
/// factors are stored from the highest power down, so that the coefficients of a product stand in the order in which
/// they are multiplied.
#[derive(Clone, Debug)]
pub(super) struct Lanes {
    left: [Wide; ORDER + 1],
    right: [Wide; ORDER + 1],
    /// What [`Self::add_up`] found.
    sums: Wide,
    /// Halves in use.
    used: usize,
    /// Coefficients known.
    known: usize,
}

impl Default for Lanes {
    fn default() -> Self {
        let rows = [[0.0; WIDE]; ORDER + 1];
        Self { left: rows, right: rows, sums: [0.0; WIDE], used: 0, known: 1 }
    }
}

impl Lanes {
    /// Frees all halves.
    pub(super) fn clear(&mut self) {
        (self.used, self.known) = (0, 1);
    }

    /// Takes a half, with these first coefficients.
    pub(super) fn begin(&mut self, left: Half, right: Half) -> usize {
        let half = self.used;
        self.used += 1;
        self.put(0, half, left, right);
        half
    }

    /// Sets coefficient `k` of the factors in a half.
    #[inline(always)]
    pub(super) fn put(&mut self, k: usize, half: usize, left: Half, right: Half) {
        self.left[k].as_chunks_mut().0[half] = left;
        self.right[ORDER - k].as_chunks_mut().0[half] = right;
    }

    /// The last sums of a half.
    #[inline(always)]
    pub(super) fn sums(&self, half: usize) -> &Half {
        &self.sums.as_chunks().0[half]
    }

    /// Finds the next coefficient of each product, without the terms that contain a first coefficient. Of the last
    /// coefficients only the first half is wanted.
    #[inline(always)]
    pub(super) fn add_up<S: Simd>(&mut self, simd: S) {
        match if self.known < ORDER { self.used } else { 1 } {
            0 | 1 => self.add_up_of::<S, 1>(simd),
            2 => self.add_up_of::<S, 2>(simd),
            3 => self.add_up_of::<S, 3>(simd),
            4 => self.add_up_of::<S, 4>(simd),
            5 => self.add_up_of::<S, 5>(simd),
            6 => self.add_up_of::<S, 6>(simd),
            _ => self.add_up_of::<S, HALVES>(simd),
        }
        self.known += 1;
    }

    /// [`Self::add_up`] for a known number of halves, whose sums stay in the processor's registers.
    #[inline(always)]
    fn add_up_of<S: Simd, const USED: usize>(&mut self, simd: S) {
        let count = (HALF * USED).div_ceil(S::F64_LANES);
        let mut sums = [simd.splat_f64s(0.0); WIDE];
        if let Some(terms) = self.known.checked_sub(2) {
            // The two terms that contain the last coefficients come at the end: all others can be added up before
            // those are known.
            let (left, right) = (&self.left[2..][..terms], &self.right[ORDER - terms..][..terms]);
            let ((x, left), (y, right)) = (left.as_rchunks::<2>(), right.as_rchunks::<2>());
            if let ([x], [y]) = (x, y) {
                add(simd, &mut sums[..count], x, y);
            }
            for ([x, z], [y, w]) in left.iter().zip(right) {
                add(simd, &mut sums[..count], x, y);
                add(simd, &mut sums[..count], z, w);
            }
            add(simd, &mut sums[..count], &self.left[1], &self.right[ORDER - terms - 1]);
        }
        let out = S::as_mut_simd_f64s(&mut self.sums).0;
        out[..count].copy_from_slice(&sums[..count]);
    }
}

/// Adds the products of two rows to the sums.
#[inline(always)]
fn add<S: Simd>(simd: S, sums: &mut [S::f64s], x: &Wide, y: &Wide) {
    let factors = S::as_simd_f64s(x).0.iter().zip(S::as_simd_f64s(y).0);
    for (sum, (x, y)) in sums.iter_mut().zip(factors) {
        *sum = simd.add_f64s(*sum, simd.mul_f64s(*x, *y));
    }
}
