//! The power series of a window, scaled to its length.

use crate::numerics::kernel::{Row, vectorised};
use crate::numerics::series::{LOW, ORDER, projections};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Series in time, scaled to a window's length, and projections of its forces and pressures.
#[derive(Clone, Debug, Default)]
pub(super) struct Fit {
    pub(super) rows: [Row; ORDER + 1],
    pub(super) parts: [[f64; 4]; LOW],
    /// Upper and lower bounds of the first four series over the window.
    pub(super) most: [f64; 4],
    pub(super) least: [f64; 4],
}

vectorised! {
    /// Scales rows to a length and projects their first four numbers. Powers whose omission changes nothing by more
    /// than `small` may be left out of a projection.
    pub(super) fn scale(rows: &'a [Row; ORDER + 1], length: f64, small: [f64; 4], fit: &'a mut Fit) -> () as Scale, _simd {
        let (mut power, mut first) = (1.0, [[0.0; 4]; ORDER + 1]);
        for ((row, scaled), first) in rows.iter().zip(&mut fit.rows).zip(&mut first) {
            scaled.iter_mut().zip(row).for_each(|(scaled, c)| *scaled = c * power);
            first.copy_from_slice(&scaled[..4]);
            power *= length;
        }
        let (mut most, mut least) = (first[0], first[0]);
        for row in &first[1..] {
            most.iter_mut().zip(row).for_each(|(most, c)| *most += if *c > 0.0 { *c } else { 0.0 });
            least.iter_mut().zip(row).for_each(|(least, c)| *least += if *c < 0.0 { *c } else { 0.0 });
        }
        (fit.most, fit.least) = (most, least);
        fit.parts = projections(&first, small);
    }
}
