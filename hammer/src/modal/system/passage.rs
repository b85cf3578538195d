//! Passages: direct conversion from one system's modal coordinates to another's.
//!
//! At an event a state is converted from the old system's basis to the bodies' modes, and from
//! there to the new basis. For small systems the product of both is computed once for each pair of
//! consecutive systems, which halves the work of every event. The product takes `O(N^3)` and an
//! event `O(N^2)`, so beyond [`MOST`] modes it would take longer than it saves in a run. It
//! consists of the columns of the one basis, each converted to the other, so that it rounds no more
//! than the two products.

use crate::modal::system::basis::Basis;
use crate::numerics::combine::{Columns, combine};
use crate::numerics::kernel;
use crate::scene::graph::{CHANNELS, Overlap};

/// Modes of the larger of two systems.
pub(crate) const MOST: usize = 64;
/// A mismatch whose square, the error after correcting each column, is below rounding. (The old
/// system contributes none: its columns define its coordinates.)
const CORRECTED: f64 = 1e-8;

/// The direct conversion of a modal state from one system to another.
#[derive(Debug)]
pub struct Passage {
    /// Blocks of the old system, padded to whole lanes, and those that are.
    from: [usize; 2],
    /// Length of the new modal vector.
    len: usize,
    /// Column by column: the new coordinates due to each old coordinate, then those due to each
    /// unit load beyond the new statics.
    columns: Vec<f64>,
}

impl Passage {
    /// None if it is too expensive, or less accurate than two products. `statics` are the loads'
    /// shapes in both systems.
    pub(crate) fn new(
        from: &Basis,
        to: &Basis,
        overlap: Overlap,
        statics: [[&[f64]; CHANNELS]; 2],
    ) -> Option<Self> {
        if from.modes.max(to.modes) > MOST || to.mismatch > CORRECTED {
            return None;
        }
        let len = to.len();
        let mut columns = Vec::with_capacity((2 * from.modes + CHANNELS) * len);
        let (mut state, mut column) = (vec![0.0; 2 * to.modes], vec![0.0; len]);
        for (_, halves) in from.columns() {
            overlap.copy(halves, &mut state);
            to.enter_part(&state, overlap.to..overlap.to + overlap.count, &mut column);
            columns.extend_from_slice(&column);
        }
        let passage = Self { from: [from.len() / 2, from.modes], len, columns };
        Some(passage.with_statics(statics))
    }

    fn with_statics(mut self, [old, new]: [[&[f64]; CHANNELS]; 2]) -> Self {
        for (old, new) in old.into_iter().zip(new) {
            let mut column = vec![0.0; self.len];
            self.apply(old, &mut column);
            kernel::add(&mut column, -1.0, new);
            self.columns.extend(column);
        }
        self
    }

    /// `out :=` the new modal state of the old one `y`.
    pub fn apply(&self, y: &[f64], out: &mut [f64]) {
        let [blocks, modes] = self.from;
        let (first, second) = y.split_at(blocks);
        let numbers = &self.columns[..2 * modes * self.len];
        let columns = Columns { numbers, stride: self.len, offset: 0 };
        combine(columns, [&first[..modes], &second[..modes]], out);
    }

    /// The same for states without the static part of constant loads.
    pub fn apply_moving(&self, y: &[f64], loads: [f64; CHANNELS], out: &mut [f64]) {
        let [blocks, modes] = self.from;
        let (first, second) = y.split_at(blocks);
        let mut rest = [0.0; MOST + CHANNELS];
        rest[..modes].copy_from_slice(&second[..modes]);
        rest[modes..modes + CHANNELS].copy_from_slice(&loads);
        let columns = Columns { numbers: &self.columns, stride: self.len, offset: 0 };
        combine(columns, [&first[..modes], &rest[..modes + CHANNELS]], out);
    }
}

impl Overlap {
    /// Copies displacements and velocities of the shared modes.
    pub(crate) fn copy(&self, halves: [&[f64]; 2], state: &mut [f64]) {
        let modes = state.len() / 2;
        for (half, start) in halves.into_iter().zip([0, modes]) {
            let to = &mut state[start + self.to..][..self.count];
            to.copy_from_slice(&half[self.from..][..self.count]);
        }
    }
}
