//! The power series of a window, scaled to its length.

use super::Window;
use crate::numerics::kernel::{Row, vectorised};
use crate::numerics::poly::OVER;
use crate::numerics::series::{LOW, ORDER, Powers, powers, projections};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};
use std::array::from_fn;

/// Lanes of the rows of a series after the forces on the piston and on the bit: pressures and masses of the chambers, and
/// the piston's positions.
pub(super) const PRESSURE: usize = 2;
pub(super) const MASS: usize = 4;
pub(super) const PLACE: usize = 6;
/// Series in time, scaled to a window's length, and projections of its forces and pressures.
#[derive(Clone, Debug, Default)]
pub(super) struct Fit {
    /// The powers of the length.
    powers: Powers,
    pub(super) rows: [Row; ORDER + 1],
    pub(super) parts: [[f64; 4]; LOW],
    /// Upper and lower bounds of the first four series over the window.
    pub(super) most: [f64; 4],
    pub(super) least: [f64; 4],
    /// What the projections leave out at the end of the window at which they leave out more.
    pub(super) left_out: [f64; 4],
}

vectorised! {
    /// Scales rows to a length and projects their first four numbers, unless `small` is `None`. Powers whose omission
    /// changes nothing by more than `small` may be left out of a projection.
    pub(super) fn scale(rows: &'a [Row; ORDER + 1], length: f64, small: Option<[f64; 4]>, fit: &'a mut Fit) -> () as Scale, _simd {
        let [mut whole, mut most, mut least]: [[f64; 4]; 3] = [from_fn(|i| rows[0][i]); 3];
        fit.rows[0] = rows[0];
        fit.powers = powers(length);
        let scaled = fit.rows[1..].iter_mut().zip(&fit.powers[1..]);
        for (row, (scaled, power)) in rows[1..].iter().zip(scaled) {
            let terms: Row = from_fn(|i| row[i] * power);
            *scaled = terms;
            for i in 0..4 {
                whole[i] += terms[i];
                most[i] += if terms[i] > 0.0 { terms[i] } else { 0.0 };
                least[i] += if terms[i] < 0.0 { terms[i] } else { 0.0 };
            }
        }
        (fit.most, fit.least) = (most, least);
        let Some(small) = small else { return };
        let parts = projections(&fit.rows, small);
        for i in 0..4 {
            let end = parts.iter().fold(0.0, |end, part| end + part[i]);
            fit.left_out[i] = (fit.rows[0][i] - parts[0][i]).abs().max((whole[i] - end).abs());
        }
        fit.parts = parts;
    }
}

/// What the air presses on, m2, and the volumes of the chambers at the positions zero, m3.
#[derive(Clone, Copy)]
pub(super) struct Swept {
    pub(super) areas: [f64; 2],
    pub(super) dead: [f64; 2],
    /// True if the piston's two positions differ.
    pub(super) apart: bool,
}

vectorised! {
    /// Writes the polynomials of a window whose length is known. `sums`, and the `works` of the chambers on rigid bodies,
    /// are not scaled to the length.
    pub(super) fn write(window: &'a mut Window, fit: &'a Fit, sums: &'a [[f64; 2]; ORDER + 1], works: Option<&'a Powers>, swept: Swept) -> () as Write, _simd {
        let Swept { areas, dead, apart } = swept;
        match works {
            // The work itself is a series.
            Some(works) => {
                window.push = [[0.0; LOW]; 2];
                window.moment = from_fn(|k| -fit.powers[k] * works[k]);
            }
            None => {
                for (k, part) in fit.parts.iter().enumerate() {
                    (0..2).for_each(|i| window.push[i][k] = areas[i] * part[PRESSURE + i]);
                }
                add_up_moment(window, &fit.rows, apart);
            }
        }
        let scaled = fit.rows.iter().zip(sums).zip(fit.powers);
        for (row, ((&[_, _, p, q, m, n, x, y], sums), power)) in window.rows.iter_mut().zip(scaled) {
            *row = [p, q, m, n, areas[0] * x, areas[1] * y, sums[0] * power, sums[1] * power];
        }
        (0..2).for_each(|i| window.rows[0][4 + i] += dead[i]);
    }
}

/// `int P' x`: the slopes of the forces times the positions.
#[inline(always)]
fn add_up_moment(window: &mut Window, rows: &[Row; ORDER + 1], apart: bool) {
    let [mut push, back] = window.push;
    // Where both forces act on the same position, their sum acts on it.
    push.iter_mut().zip(back).for_each(|(sum, back)| *sum += if apart { 0.0 } else { back });
    // Beyond the last power the sums are not wanted; they let all loops have the same length.
    let mut moment = [0.0; ORDER + LOW];
    for (i, forces) in [push, back].iter().enumerate().take(if apart { 2 } else { 1 }) {
        let place: Powers = from_fn(|k| rows[k][PLACE + i]);
        for (k, force) in forces.iter().enumerate().skip(1) {
            let slope = k as f64 * force;
            for (sum, x) in moment[k..][..=ORDER].iter_mut().zip(&place) {
                *sum += slope * x;
            }
        }
    }
    window.moment = from_fn(|k| if k == 0 { 0.0 } else { moment[k] * OVER[k - 1] });
}
