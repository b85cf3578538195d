//! The matrices of Newton's method over a window.

use crate::numerics::collocation::{Nodal, Rule, STAGES, dot};
use std::array::from_fn;

/// What goes on from one solution of a window to the next.
#[derive(Debug)]
pub(crate) struct Newton {
    /// The rates, at first guessed.
    pub(super) rates: [Nodal; 4],
    pub(super) factors: Option<[Option<Factors>; 2]>,
    /// How many it took.
    pub(crate) iterations: u64,
}

/// The factorised matrix of a chamber, `1 - h A (x) J`, with a `J` that is triangular.
#[derive(Debug)]
pub(super) struct Factors {
    pub mass: Triangles,
    pub entropy: Triangles,
    /// `h` times the slope of the mass's rate by the entropy.
    pub cross: f64,
}

impl Factors {
    pub fn solve(&self, mass: &Nodal, entropy: &Nodal) -> [Nodal; 2] {
        let entropy = self.entropy.solve(entropy);
        let known = from_fn(|i| mass[i] + self.cross * dot(&Rule::get().once[i], &entropy));
        [self.mass.solve(&known), entropy]
    }
}

/// A factorised matrix `1 - slope A`. Where a rate falls with its content, as in all but a trial, nothing
/// in it cancels, in whatever order it is factorised.
#[derive(Debug)]
pub(crate) struct Triangles([Nodal; STAGES]);

impl Triangles {
    /// None if it is nearly singular.
    pub fn new(slope: f64) -> Option<Self> {
        let mut rows = Rule::get().once.map(|row| row.map(|a| -slope * a));
        (0..STAGES).for_each(|i| rows[i][i] += 1.0);
        for c in 0..STAGES {
            let head = rows[c];
            if head[c].is_nan() || head[c].abs() < 1e-6 {
                return None;
            }
            for row in rows.iter_mut().skip(c + 1) {
                let factor = row[c] / head[c];
                row[c] = factor;
                (c + 1..STAGES).for_each(|k| row[k] -= factor * head[k]);
            }
        }
        Some(Self(rows))
    }

    pub fn solve(&self, given: &Nodal) -> Nodal {
        let (rows, mut x) = (&self.0, *given);
        for r in 1..STAGES {
            x[r] -= (0..r).map(|c| rows[r][c] * x[c]).sum::<f64>();
        }
        for r in (0..STAGES).rev() {
            let known: f64 = (r + 1..STAGES).map(|c| rows[r][c] * x[c]).sum();
            x[r] = (x[r] - known) / rows[r][r];
        }
        x
    }
}
