//! Passages: direct conversion from one system's modal coordinates to another's.
//!
//! At an event a state is converted from the old system's basis to the bodies' modes, and from there to the new basis.
//! For small systems the product of these two matrices is computed once for each pair of consecutive systems, which
//! halves the work of every event. The product takes `O(N^3)` operations and an event `O(N^2)`, so with more than
//! [`MAX_MODES`] modes it would take longer than it saves in a run. Each column of the product is a column of the old
//! basis, converted to the new one, so the product rounds no more than two conversions.

use crate::modal::system::basis::Basis;
use crate::numerics::combine::{Columns, combine};
use crate::numerics::kernel;
use crate::scene::graph::{CHANNELS, Overlap};

/// Largest number of modes of the larger of two systems.
pub(crate) const MAX_MODES: usize = 64;
/// Largest mismatch of the new system. Each column is corrected, and its error is then the square of the mismatch,
/// which is below rounding. (The old system contributes no error, since its columns define its coordinates.)
const CORRECTED: f64 = 1e-8;

/// The direct conversion of a modal state from one system to another.
#[derive(Debug)]
pub struct Passage {
    /// Number of blocks of the old system, with and without those that fill the last group of lanes.
    from: [usize; 2],
    /// Length of the new modal vector.
    len: usize,
    /// The new coordinates that each old coordinate contributes, column by column. After them come those of each unit
    /// load: the converted old static part minus the new static part.
    columns: Vec<f64>,
}

impl Passage {
    /// The passage from one basis to another; `None` if it would not save work, or would be less accurate than two
    /// conversions. `statics` are the static coordinates under unit loads in both systems.
    pub(crate) fn new(
        from: &Basis,
        to: &Basis,
        overlap: Overlap,
        statics: [[&[f64]; CHANNELS]; 2],
    ) -> Option<Self> {
        if from.modes.max(to.modes) > MAX_MODES || to.mismatch > CORRECTED {
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

    /// Converts the old modal state `y` to the new one, `out`.
    pub fn apply(&self, y: &[f64], out: &mut [f64]) {
        let [blocks, modes] = self.from;
        let (first, second) = y.split_at(blocks);
        let numbers = &self.columns[..2 * modes * self.len];
        let columns = Columns { numbers, stride: self.len, offset: 0 };
        combine(columns, [&first[..modes], &second[..modes]], out);
    }

    /// As [`Self::apply`], for states without the static part of constant loads.
    pub fn apply_moving(&self, y: &[f64], loads: [f64; CHANNELS], out: &mut [f64]) {
        let [blocks, modes] = self.from;
        let (first, second) = y.split_at(blocks);
        let mut second_and_loads = [0.0; MAX_MODES + CHANNELS];
        second_and_loads[..modes].copy_from_slice(&second[..modes]);
        second_and_loads[modes..modes + CHANNELS].copy_from_slice(&loads);
        let columns = Columns { numbers: &self.columns, stride: self.len, offset: 0 };
        combine(columns, [&first[..modes], &second_and_loads[..modes + CHANNELS]], out);
    }
}

impl Overlap {
    /// Copies the displacements and velocities of the shared modes from the old state (`halves`) to the new one.
    pub(crate) fn copy(&self, halves: [&[f64]; 2], state: &mut [f64]) {
        let modes = state.len() / 2;
        for (half, start) in halves.into_iter().zip([0, modes]) {
            let to = &mut state[start + self.to..][..self.count];
            to.copy_from_slice(&half[self.from..][..self.count]);
        }
    }
}
