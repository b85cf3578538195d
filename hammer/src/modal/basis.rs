//! The modal basis: from free modes to a system's own coordinates and back.

use crate::modal::block::Block;
use crate::modal::structure::Structure;
use crate::numerics::kernel::{self, inner_product};

/// Beyond this mismatch, a state that enters the basis is corrected once.
const ROUGH: f64 = 1e-11;

/// A basis of the phase space `[q | q']` of the free modes, and its inverse.
///
/// The columns are `[shape | shape B]`; the rows of the inverse are their duals in the
/// bilinear form `x . [[C, 1], [1, 0]] x`, in which vectors of different eigenvalues are
/// orthogonal: no matrix is inverted.
#[derive(Debug)]
pub(crate) struct Basis {
    /// Blocks, padded to whole lanes.
    n: usize,
    /// Free modes.
    pub(crate) modes: usize,
    /// Length of `[q | q']`, padded to whole lanes.
    phase: usize,
    from_modal: Vec<f64>,
    to_modal: Vec<f64>,
    /// How far a state that goes into the basis and back comes from where it was, over its
    /// size, a displacement times its frequency.
    pub(crate) mismatch: f64,
}

impl Basis {
    /// `slowest` is a rate below which displacements are not weighed more.
    pub(crate) fn new(structure: &Structure, blocks: &[Block], slowest: f64) -> Self {
        let modes = blocks.len();
        let n = modes.next_multiple_of(kernel::LANES);
        let phase = (2 * modes).next_multiple_of(kernel::LANES);
        let len = 2 * n;
        let mut basis = Self {
            n,
            modes,
            phase,
            from_modal: vec![0.0; 2 * modes * len],
            to_modal: vec![0.0; phase * len],
            mismatch: 0.0,
        };
        for (i, block) in blocks.iter().enumerate() {
            basis.add(i, block, structure);
        }
        basis.mismatch = basis.tested(structure.omega2, slowest);
        basis
    }

    /// Writes the columns and dual rows of block `i`.
    fn add(&mut self, i: usize, block: &Block, structure: &Structure) {
        let (n, modes, phase, b) = (self.n, self.modes, self.phase, &block.b);
        let [first, second] = &block.shapes;
        let rates = [(b[0], b[2]), (b[1], b[3])];
        let velocities = rates.map(|(p, q)| -> Vec<f64> {
            (0..modes).map(|h| p * first[h] + q * second[h]).collect()
        });
        let duals: [Vec<f64>; 2] = std::array::from_fn(|c| {
            let mut low = structure.damped(&block.shapes[c]);
            low.iter_mut().zip(&velocities[c]).for_each(|(x, v)| *x += v);
            low.extend_from_slice(&block.shapes[c]);
            low
        });
        let inner = |c: usize, d: usize| {
            inner_product(&duals[c][..modes], &block.shapes[d])
                + inner_product(&duals[c][modes..], &velocities[d])
        };
        let (g11, g22) = (inner(0, 0), inner(1, 1));
        let g12 = if block.is_diagonal() { 0.0 } else { 0.5 * (inner(0, 1) + inner(1, 0)) };
        let det = g11 * g22 - g12 * g12;
        for (k, (x, y)) in duals[0].iter().zip(&duals[1]).enumerate() {
            self.to_modal[i * phase + k] = (g22 * x - g12 * y) / det;
            self.to_modal[(n + i) * phase + k] = (g11 * y - g12 * x) / det;
        }
        for (c, at) in [(0, i), (1, n + i)] {
            for (h, (shape, velocity)) in block.shapes[c].iter().zip(&velocities[c]).enumerate() {
                self.from_modal[h * 2 * n + at] = *shape;
                self.from_modal[(modes + h) * 2 * n + at] = *velocity;
            }
        }
    }

    /// True if every entry is a number.
    pub(crate) fn is_finite(&self) -> bool {
        self.from_modal.iter().chain(&self.to_modal).all(|x| x.is_finite())
    }

    fn tested(&self, omega2: &[f64], slowest: f64) -> f64 {
        if slowest == 0.0 {
            return 0.0; // Nothing but translations: shapes are their own duals.
        }
        let rate = |i: usize| omega2[i].sqrt().max(slowest);
        let mut worst = 0.0f64;
        for step in [5, 7] {
            // Any state will do that has a share of every mode.
            let share = |i: usize| 1.0 - ((i * step) % 11) as f64 / 8.0;
            let displacements = (0..self.modes).map(|i| share(i) / rate(i));
            let state: Vec<f64> =
                displacements.chain((0..self.modes).map(|i| share(i + 3))).collect();
            let (mut y, mut back) = (vec![0.0; 2 * self.n], vec![0.0; 2 * self.modes]);
            self.enter(&state, &mut y);
            self.leave(&y, &mut back);
            for (i, (x, b)) in state.iter().zip(&back).enumerate() {
                let weight = if i < self.modes { rate(i) } else { 1.0 };
                let apart = weight * (x - b).abs();
                worst = if apart.is_nan() { f64::INFINITY } else { worst.max(apart) };
            }
        }
        worst
    }

    /// Modal coordinates of a state `[q | q']` of the free modes.
    pub(crate) fn enter(&self, state: &[f64], y: &mut [f64]) {
        let mut padded = vec![0.0; self.phase];
        padded[..state.len()].copy_from_slice(state);
        kernel::multiply(&self.to_modal, &padded, y);
        if self.mismatch > ROUGH {
            let mut back = vec![0.0; 2 * self.modes];
            self.leave(y, &mut back);
            padded.iter_mut().zip(&back).for_each(|(x, b)| *x -= b);
            let mut more = vec![0.0; y.len()];
            kernel::multiply(&self.to_modal, &padded, &mut more);
            y.iter_mut().zip(&more).for_each(|(y, m)| *y += m);
        }
    }

    /// The reverse of [`Self::enter`].
    pub(crate) fn leave(&self, y: &[f64], state: &mut [f64]) {
        kernel::multiply(&self.from_modal, y, state);
    }

    /// Coefficients that give free mode `mode`'s displacement.
    pub(crate) fn displacement_row(&self, mode: usize) -> &[f64] {
        let len = 2 * self.n;
        &self.from_modal[mode * len..(mode + 1) * len]
    }

    /// Coefficients that give free mode `mode`'s velocity.
    pub(crate) fn velocity_row(&self, mode: usize) -> &[f64] {
        self.displacement_row(self.modes + mode)
    }
}
