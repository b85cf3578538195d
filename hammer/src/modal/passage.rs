//! From one system's modal coordinates straight into another's.
//!
//! At an event a state goes through the old system's basis to the bodies' modes and through the
//! new one's from there. Of small systems the product of both is made once for each pair that
//! follow each other, which halves the work at every event. It takes `O(N^3)` and every event
//! `O(N^2)`: beyond [`MOST`] modes it would cost more than a run gives back. It is made of the
//! columns of the one basis, each entered into the other, so that it rounds no more than the two
//! products do.

use crate::modal::basis::Basis;
use crate::numerics::kernel::{self, Columns};

/// Modes of the larger of two systems.
pub(crate) const MOST: usize = 64;
/// A mismatch whose square, which is what a correction of each column leaves, is below rounding.
/// (The system that is left adds none: its columns are what its coordinates mean.)
const CORRECTED: f64 = 1e-8;

/// Where the free modes that two systems share begin in each, and how many they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// In the one that is left.
    pub from: usize,
    /// In the one that is entered.
    pub to: usize,
    /// How many.
    pub count: usize,
}

/// The way of a modal state from one system to another.
#[derive(Debug)]
pub struct Passage {
    /// Blocks of the old system, padded to whole lanes, and those that are.
    from: [usize; 2],
    /// Length of the new modal vector.
    len: usize,
    /// Column by column: what each old coordinate makes of the new ones.
    columns: Vec<f64>,
}

impl Passage {
    /// None where it takes more than it gives, or where it would not be as sharp as two products.
    pub(crate) fn new(from: &Basis, to: &Basis, overlap: Overlap) -> Option<Self> {
        if from.modes.max(to.modes) > MOST || to.mismatch > CORRECTED {
            return None;
        }
        let len = to.len();
        let mut columns = vec![0.0; 2 * from.modes * len];
        let mut state = vec![0.0; 2 * to.modes];
        for ((_, halves), column) in from.columns().zip(columns.chunks_exact_mut(len)) {
            overlap.copy(halves, &mut state);
            to.enter(&state, column);
        }
        Some(Self { from: [from.len() / 2, from.modes], len, columns })
    }

    /// `out :=` the new modal state of the old one `y`.
    pub fn apply(&self, y: &[f64], out: &mut [f64]) {
        let [blocks, modes] = self.from;
        let (first, second) = y.split_at(blocks);
        let columns = Columns { numbers: &self.columns, stride: self.len, offset: 0 };
        kernel::combine(columns, [&first[..modes], &second[..modes]], out);
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
