//! The modal basis: from free modes to a system's own coordinates and back.

use crate::interrupt;
use crate::modal::spectrum::block::Block;
use crate::modal::structure::Structure;
use crate::numerics::combine::{Columns, combine};
use crate::numerics::kernel::{self, inner_product};
use std::ops::Range;

/// If the mismatch is above this, a state that is converted to the basis is corrected once.
const ROUGH: f64 = 1e-11;

/// A basis of the phase space `[q | q']` of the free modes, and its inverse.
///
/// The columns are `[shape | shape B]`. The rows of the inverse are their duals in the bilinear form
/// `x . [[C, 1], [1, 0]] x`. In this form vectors of different eigenvalues are orthogonal, so no matrix is inverted.
#[derive(Debug)]
pub(crate) struct Basis {
    /// Number of blocks, padded to whole groups of lanes.
    n: usize,
    /// Number of free modes.
    pub(crate) modes: usize,
    /// Length of `[q | q']`, padded to whole groups of lanes.
    phase: usize,
    /// The part of `[q | q']` that each modal coordinate contributes, column by column.
    from_modal: Vec<f64>,
    /// The inverse of `from_modal`, column by column.
    to_modal: Vec<f64>,
    /// Relative error of a state that is converted to the basis and back. A displacement is weighted with its
    /// frequency.
    pub(crate) mismatch: f64,
}

impl Basis {
    /// The basis of these blocks; `None` if the call is interrupted. In the mismatch, displacements with a frequency
    /// below `slowest` are weighted with `slowest`.
    pub(crate) fn new(structure: &Structure, blocks: &[Block], slowest: f64) -> Option<Self> {
        let modes = blocks.len();
        let n = modes.next_multiple_of(kernel::LANES);
        let phase = (2 * modes).next_multiple_of(kernel::LANES);
        let len = 2 * n;
        let mut basis = Self {
            n,
            modes,
            phase,
            from_modal: vec![0.0; 2 * modes * phase],
            to_modal: vec![0.0; 2 * modes * len],
            mismatch: 0.0,
        };
        for (i, block) in blocks.iter().enumerate() {
            if interrupt::is_set() {
                return None;
            }
            basis.add(i, block, structure);
        }
        let errors = basis.errors(structure.omega2, slowest);
        let sizes = errors.iter().flatten().map(|error| error.abs());
        basis.mismatch =
            sizes.fold(0.0, |m: f64, x| if x.is_nan() { f64::INFINITY } else { m.max(x) });
        Some(basis)
    }

    /// Writes the columns and dual rows of block `i`.
    fn add(&mut self, i: usize, block: &Block, structure: &Structure) {
        let (n, len, modes, b) = (self.n, 2 * self.n, self.modes, &block.b);
        let shapes = &block.shapes;
        let velocities = [(b[0], b[2]), (b[1], b[3])].map(|(p, q)| -> Vec<f64> {
            shapes[0].iter().zip(&shapes[1]).map(|(x, y)| p * x + q * y).collect()
        });
        // These are the upper halves of the duals; the lower halves are the shapes.
        let mut duals = shapes.each_ref().map(|shape| structure.damped(shape));
        for (dual, velocity) in duals.iter_mut().zip(&velocities) {
            dual.iter_mut().zip(velocity).for_each(|(x, v)| *x += v);
        }
        let inner = |c: usize, d: usize| {
            inner_product(&duals[c], &shapes[d]) + inner_product(&shapes[c], &velocities[d])
        };
        let (g11, g22) = (inner(0, 0), inner(1, 1));
        let g12 = if block.is_diagonal() { 0.0 } else { 0.5 * (inner(0, 1) + inner(1, 0)) };
        let det = g11 * g22 - g12 * g12;
        let inverse = 1.0 / det;
        let upper = duals[0].iter().zip(&duals[1]);
        let rows = upper.chain(shapes[0].iter().zip(&shapes[1]));
        for (column, (x, y)) in self.to_modal.chunks_exact_mut(len).zip(rows) {
            column[i] = (g22 * x - g12 * y) * inverse;
            column[n + i] = (g11 * y - g12 * x) * inverse;
        }
        for (c, index) in [i, modes + i].into_iter().enumerate() {
            let column = &mut self.from_modal[index * self.phase..][..2 * modes];
            column[..modes].copy_from_slice(&block.shapes[c]);
            column[modes..].copy_from_slice(&velocities[c]);
        }
    }

    /// Length of a modal vector.
    pub(crate) fn len(&self) -> usize {
        2 * self.n
    }

    /// Adds `change` to the displacement of free mode `mode` in the modal state `y`.
    pub(crate) fn displace(&self, mode: usize, change: f64, y: &mut [f64]) {
        kernel::add(y, change, &self.to_modal[mode * self.len()..][..self.len()]);
    }

    /// True if every entry is finite.
    pub(crate) fn is_finite(&self) -> bool {
        kernel::is_finite(&self.from_modal) && kernel::is_finite(&self.to_modal)
    }

    /// What two states that contain every mode lose when they are converted to the basis and back, each displacement
    /// times its rate.
    fn errors(&self, omega2: &[f64], slowest: f64) -> Vec<Vec<f64>> {
        if slowest == 0.0 {
            return Vec::new(); // There are only translations, whose shapes are their own duals.
        }
        let rate = |i: usize| omega2[i].sqrt().max(slowest);
        let error = |step: usize| {
            let share = |i: usize| 1.0 - ((i * step) % 11) as f64 / 8.0;
            let displacements = (0..self.modes).map(|i| share(i) / rate(i));
            let mut state: Vec<f64> =
                displacements.chain((0..self.modes).map(|i| share(i + 3))).collect();
            let (mut y, mut back) = (vec![0.0; 2 * self.n], vec![0.0; 2 * self.modes]);
            self.combined(&state, 0..self.modes, &mut y);
            self.leave(&y, &mut back);
            state.iter_mut().zip(&back).for_each(|(x, b)| *x -= b);
            (0..self.modes).for_each(|i| state[i] *= rate(i));
            state
        };
        [5, 7].map(error).into()
    }

    /// The blocks whose coordinates have a part above `bound` in what the states of the [mismatch](Self::mismatch)
    /// lose. A wrong vector leaves there what it lacks, which is a part of others.
    pub(crate) fn suspects(&self, omega2: &[f64], slowest: f64, bound: f64) -> Vec<usize> {
        let rate = |i: usize| omega2[i].sqrt().max(slowest);
        let mut parts = vec![0.0; self.modes];
        for mut error in self.errors(omega2, slowest) {
            let mut y = vec![0.0; 2 * self.n];
            (0..self.modes).for_each(|i| error[i] /= rate(i));
            self.enter(&error, &mut y);
            for (k, [displacements, velocities]) in self.columns() {
                let strains = displacements.iter().enumerate().map(|(i, x)| rate(i) * x);
                let largest =
                    strains.chain(velocities.iter().copied()).fold(0.0, |m, x| x.abs().max(m));
                let part: &mut f64 = &mut parts[k % self.n];
                *part = part.max(largest * y[k].abs());
            }
        }
        (0..self.modes).filter(|i| parts[*i] > bound).collect()
    }

    /// Modal coordinates of a state `[q | q']` of the free modes.
    pub(crate) fn enter(&self, state: &[f64], y: &mut [f64]) {
        self.enter_part(state, 0..self.modes, y);
    }

    /// [`Self::enter`] for a state that is zero in all modes except those of `moving`.
    pub(crate) fn enter_part(&self, state: &[f64], moving: Range<usize>, y: &mut [f64]) {
        self.combined(state, moving, y);
        if self.mismatch > ROUGH {
            let mut residual = vec![0.0; 2 * self.modes];
            self.leave(y, &mut residual);
            residual.iter_mut().zip(state).for_each(|(b, x)| *b = x - *b);
            let mut correction = vec![0.0; y.len()];
            self.combined(&residual, 0..self.modes, &mut correction);
            y.iter_mut().zip(&correction).for_each(|(y, m)| *y += m);
        }
    }

    fn combined(&self, state: &[f64], moving: Range<usize>, y: &mut [f64]) {
        let stride = self.len();
        let numbers = &self.to_modal[moving.start * stride..(self.modes + moving.end) * stride];
        let (displacements, velocities) = state.split_at(self.modes);
        let x = [&displacements[moving.clone()], &velocities[moving]];
        combine(Columns { numbers, stride, offset: 0 }, x, y);
    }

    /// The reverse of [`Self::enter`].
    pub(crate) fn leave(&self, y: &[f64], state: &mut [f64]) {
        let columns = Columns { numbers: &self.from_modal, stride: self.phase, offset: 0 };
        let (first, second) = y.split_at(self.n);
        let mut padded = vec![0.0; self.phase];
        combine(columns, [&first[..self.modes], &second[..self.modes]], &mut padded);
        state.copy_from_slice(&padded[..2 * self.modes]);
    }

    /// For each modal coordinate of the actual blocks: its index in a modal vector, and the displacements and
    /// velocities of the free modes that it contributes.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (usize, [&[f64]; 2])> {
        let index = |k: usize| if k < self.modes { k } else { self.n + k - self.modes };
        self.from_modal.chunks_exact(self.phase).enumerate().map(move |(k, column)| {
            let (displacements, rest) = column.split_at(self.modes);
            (index(k), [displacements, &rest[..self.modes]])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of undamped modes, which are their own duals, one has a share of another in its vector: to first order both lose
    /// that share of the other's amplitude, and nobody else loses anything.
    #[test]
    fn a_wrong_vector_is_found_with_what_it_lacks() {
        let omega2: Vec<f64> = (1..=12).map(|i| 1e6 * f64::from(i * i)).collect();
        let structure = Structure::free(&omega2, 0.0);
        let shape = |i: usize| (0..12).map(|k| f64::from(u8::from(k == i))).collect();
        let mut blocks: Vec<Block> =
            (0..12).map(|i| Block::free(omega2[i], 0.0, shape(i))).collect();
        let suspects = |blocks: &[Block]| {
            let basis = Basis::new(&structure, blocks, 1e3).expect("a basis");
            basis.suspects(&omega2, 1e3, 1e-9)
        };
        assert_eq!(suspects(&blocks), []);
        for shape in &mut blocks[3].shapes {
            shape[7] = 1e-6 * shape[3];
        }
        assert_eq!(suspects(&blocks), [3, 7]);
    }
}
