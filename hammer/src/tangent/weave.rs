//! The change of a system's matrix, in modal coordinates.

use crate::modal::system::System;
use crate::numerics::kernel;
use crate::numerics::matrix2::Matrix2;
use crate::tangent::variation::Variation;
use std::borrow::Cow;

/// `W`, in modal coordinates.
#[derive(Debug)]
pub(super) enum Weave {
    Nothing,
    /// Sum of columns times rows.
    Slim(Vec<[Vec<f64>; 2]>),
    /// Row by row.
    Full(Vec<f64>),
}

impl Weave {
    pub(super) fn times(&self, z: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; z.len()];
        self.add(z, &mut out);
        out
    }

    /// `y += W z`.
    pub(super) fn add(&self, z: &[f64], y: &mut [f64]) {
        match self {
            Self::Nothing => {}
            Self::Slim(products) => {
                for [column, row] in products {
                    kernel::add(y, kernel::dot(row, z), column);
                }
            }
            Self::Full(matrix) => {
                let mut product = vec![0.0; z.len()];
                kernel::multiply(matrix, z, &mut product);
                kernel::add(y, 1.0, &product);
            }
        }
    }

    /// `row W`.
    pub(super) fn pulled(&self, row: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; row.len()];
        match self {
            Self::Nothing => {}
            Self::Slim(products) => {
                for [column, weights] in products {
                    kernel::add(&mut out, kernel::dot(column, row), weights);
                }
            }
            Self::Full(matrix) => {
                let lines = matrix.chunks_exact(row.len()).zip(row);
                lines.for_each(|(line, x)| kernel::add(&mut out, *x, line));
            }
        }
        out
    }

    /// Row by row.
    pub(super) fn full(&self, len: usize) -> Cow<'_, [f64]> {
        match self {
            Self::Nothing => vec![0.0; len * len].into(),
            Self::Slim(products) => {
                let mut full = vec![0.0; len * len];
                for [column, row] in products {
                    let lines = full.chunks_exact_mut(len).zip(column);
                    lines.for_each(|(line, c)| kernel::add(line, *c, row));
                }
                full.into()
            }
            Self::Full(matrix) => matrix.into(),
        }
    }

    pub(super) fn block(&self, n: usize, i: usize, k: usize) -> Matrix2 {
        match self {
            Self::Nothing => [0.0; 4],
            Self::Slim(products) => {
                let mut b = [0.0; 4];
                for [column, row] in products {
                    let (p, q, r, s) = (column[i], column[n + i], row[k], row[n + k]);
                    for (b, x) in b.iter_mut().zip([p * r, p * s, q * r, q * s]) {
                        *b += x;
                    }
                }
                b
            }
            Self::Full(matrix) => corners(n, 2 * n, i, k).map(|at| matrix[at]),
        }
    }
}

pub(super) fn corners(n: usize, len: usize, i: usize, k: usize) -> [usize; 4] {
    [i * len + k, i * len + n + k, (n + i) * len + k, (n + i) * len + n + k]
}

/// The change of a system's matrix.
pub(super) fn weave(system: &System, variation: &Variation) -> Weave {
    let (n, modes, len) = (system.blocks(), system.modes(), 2 * system.blocks());
    if variation.is_slim() {
        let mut products = Vec::new();
        for hold in variation.holds.iter().filter(|h| h.changes != [0.0; 2]) {
            let body_state = [vec![0.0; modes], hold.shape.iter().map(|x| -x).collect()].concat();
            let mut column = vec![0.0; len];
            system.to_modal(&body_state, &mut column);
            let rows = &system.functionals[hold.functional].rows;
            let [k, c] = hold.changes;
            let row = rows[0].iter().zip(&rows[1]).map(|(r, s)| k * r + c * s).collect();
            products.push([column, row]);
        }
        return if products.is_empty() { Weave::Nothing } else { Weave::Slim(products) };
    }
    let mut full = vec![0.0; len * len];
    let (mut body_state, mut y) = (vec![0.0; 2 * modes], vec![0.0; len]);
    let (mut unit, mut pushed) = (vec![0.0; len], vec![0.0; 2 * modes]);
    for column in (0..len).filter(|c| c % n < modes) {
        unit[column] = 1.0;
        system.to_bodies(&unit, &mut body_state);
        unit[column] = 0.0;
        variation.accelerations(&body_state, &mut pushed[modes..]);
        system.to_modal(&pushed, &mut y);
        for (row, y) in y.iter().enumerate() {
            full[row * len + column] = *y;
        }
    }
    Weave::Full(full)
}
