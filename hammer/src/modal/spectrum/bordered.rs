//! The secular function of more than two attachments.
//!
//! It is one determinant. The modes that dominate near a root have their own rows and columns in it, so that no power
//! of their compliance has to cancel.

use crate::modal::spectrum::jet::Jet;
use crate::modal::spectrum::secular::{MAX_ORDER, PAIRS, Root, Secular, size};
use crate::numerics::poles;
use num_complex::Complex64 as C;

/// A matrix of which the first rows and columns are used.
type Matrix = [[Jet; MAX_ORDER]; MAX_ORDER];

/// Two modes dominate if the distance of a root from its pole, and that of the two poles from each other, are below
/// this share of their size.
const CLOSE: f64 = 1e-6;

/// A root that is nearer to its pole than this share of its size belongs to a mode that is trapped between the
/// attachments. So near to a pole, `d` consists of rounding.
const TRAPPED: f64 = 1e-12;

const ONE: Jet = Jet { at: C::new(1.0, 0.0), slope: C::new(0.0, 0.0) };

impl Secular {
    /// The modes whose compliance dominates near a root: that of its pole and, if the root is close to it, another one
    /// of nearly the same frequency.
    pub(crate) fn borders(&self, root: Root) -> Vec<usize> {
        let (omega2, own) = (&self.system.omega2, root.pole / 2);
        let twin = [own.wrapping_sub(1), own + 1].into_iter().filter_map(|mode| {
            let difference = (omega2.get(mode)? - omega2[own]).abs();
            (difference <= CLOSE * omega2[own]).then_some((difference, mode))
        });
        let close = size(root.offset) <= CLOSE * size(self.value(root));
        let twin = twin.filter(|_| close).min_by(|a, b| a.0.total_cmp(&b.0));
        [own].into_iter().chain(twin.map(|(_, mode)| mode)).collect()
    }

    /// Three parts of an expanded determinant: `1 + kappa R` without the modes that dominate ([`Self::borders`]);
    /// `sum 1 / (s - pole)` over all poles; and the compliances `1 / d` of the modes that dominate.
    fn matrix(&self, root: Root) -> (Matrix, C, Vec<(usize, Jet)>) {
        let (s, at, borders) = (self.value(root), self.point(root), self.borders(root));
        let mut others = self.others.borrow_mut();
        borders.iter().for_each(|mode| others.banish(*mode));
        let order = self.system.shapes.len();
        let (mut poles, sums) = match order {
            2 => poles::weighed::<4>(&others, at).list(),
            3 => poles::weighed::<6>(&others, at).list(),
            _ => poles::weighed::<10>(&others, at).list(),
        };
        for &mode in &borders {
            let [a, b] = [0, 1].map(|side| self.sites[2 * mode + side]);
            others.set(mode, 0, [a.re, a.im, b.re, b.im]);
        }
        let mut matrix = Matrix::default();
        let used = PAIRS.into_iter().take_while(|[_, b]| *b < order);
        for ([a, b], [at, slope]) in used.zip(sums) {
            for (row, column) in [(a, b), (b, a)] {
                matrix[row][column] = self.stiff(row, s) * Jet { at, slope };
            }
            if a == b {
                matrix[a][a].at += 1.0;
            }
        }
        let compliance = |mode: usize| {
            let [one, other] = [0, 1].map(|side| self.off_pole(root, 2 * mode + side).inv());
            let (both, compliance) = (one + other, one * other);
            poles += both;
            (mode, Jet { at: compliance, slope: -compliance * both })
        };
        let compliances = borders.into_iter().map(compliance).collect();
        (matrix, poles, compliances)
    }

    /// Adds row and column `order` for a mode to a matrix; the column is multiplied by `scale`.
    fn border(&self, matrix: &mut Matrix, s: C, (order, mode): (usize, usize), scale: Jet) {
        for (a, shape) in self.system.shapes.iter().enumerate() {
            let phi = Jet { at: shape[mode].into(), slope: C::default() };
            matrix[a][order] = self.stiff(a, s) * phi * scale;
            matrix[order][a].at = -phi.at;
        }
    }

    /// The matrix `((1 + kappa R, kappa phi), (-phi', d))` and its order.
    /// `phi` and `d` are those of the modes that dominate ([`Self::borders`]). `R` leaves these modes out, so that no
    /// power of `1 / d` has to cancel.
    /// At a root the matrix is singular. Its null vector consists of the forces of the attachments and the amplitudes
    /// of these modes.
    fn bordered(&self, root: Root) -> (Matrix, usize) {
        let (s, (mut matrix, _, compliances)) = (self.value(root), self.matrix(root));
        let mut order = self.system.shapes.len();
        for (mode, compliance) in compliances {
            self.border(&mut matrix, s, (order, mode), ONE);
            matrix[order][order].at = 1.0 / compliance.at;
            order += 1;
        }
        (matrix, order)
    }

    /// The determinant, its derivative, and `sum 1 / (s - pole)`.
    pub(crate) fn expanded_function(&self, root: Root) -> (C, C, C) {
        // This uses det(A + u v' / d) = det((A, u / d), (-v', 1)).
        let (s, (mut matrix, poles, compliances)) = (self.value(root), self.matrix(root));
        let mut order = self.system.shapes.len();
        for (mode, compliance) in compliances {
            self.border(&mut matrix, s, (order, mode), compliance);
            matrix[order][order].at = ONE.at;
            order += 1;
        }
        let f = minor(&matrix, all(order), all(order));
        (f.at, f.slope, poles)
    }

    /// The null vector of the [matrix](Self::bordered) of an expanded determinant, or zeros if the determinant is not
    /// expanded. It consists of the cofactors of one row: the one with the largest terms, or for a trapped mode that
    /// mode's row.
    pub(crate) fn row_forces(&self, root: Root) -> [C; MAX_ORDER] {
        if !self.expanded {
            return Default::default();
        }
        let (matrix, order) = self.bordered(root);
        let forces = |row| cofactors(&matrix, order, row).map(|cofactor| cofactor.at);
        if size(root.offset) < TRAPPED * size(self.value(root)) {
            let own = self.system.shapes.len();
            return forces(own);
        }
        let rows = (0..order).map(|row| {
            let forces = forces(row);
            let terms = forces.iter().zip(&matrix[row]).map(|(f, entry)| size(f * entry.at));
            (terms.sum::<f64>(), forces)
        });
        let best = rows.max_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(Default::default, |(_, forces)| forces)
    }
}

/// Cofactors of a row of a matrix of order two or more. Entries beyond the order are zero.
fn cofactors(matrix: &Matrix, order: usize, row: usize) -> [Jet; MAX_ORDER] {
    std::array::from_fn(|column| {
        if column >= order {
            return Jet::default();
        }
        let minor = minor(matrix, all(order) & !(1 << row), all(order) & !(1 << column));
        let is_odd = (row + column) % 2 == 1;
        if is_odd { Jet::default() - minor } else { minor }
    })
}

/// Mask of the first `order` rows or columns, one bit each.
fn all(order: usize) -> u8 {
    (1 << order) - 1
}

/// Determinant of some rows and as many columns. It is expanded along the first of the rows, without division:
/// `a_0 M_0 - (a_1 M_1 - (a_2 M_2 - ...))`.
fn minor(matrix: &Matrix, rows: u8, columns: u8) -> Jet {
    let row = &matrix[rows.trailing_zeros() as usize % MAX_ORDER];
    let below = rows & rows.wrapping_sub(1);
    let last = &matrix[below.trailing_zeros() as usize % MAX_ORDER];
    let term = |column: usize| {
        let others = columns & !(1 << column);
        match below.count_ones() {
            0 => row[column],
            1 => row[column] * last[others.trailing_zeros() as usize % MAX_ORDER],
            _ => row[column] * minor(matrix, below, others),
        }
    };
    let used = (0..MAX_ORDER).rev().filter(|column| columns >> column & 1 == 1);
    let sum = used.map(term).reduce(|rest, term| term - rest);
    sum.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vandermonde's determinant is the product of all differences, and a matrix times its cofactors is the unit matrix
    /// times its determinant. Arithmetic with whole numbers of this size is exact.
    #[test]
    fn determinants_and_cofactors_are_those_of_vandermonde() {
        let x: [i32; MAX_ORDER] = [2, -3, 5, 7, -11, 13];
        let jet = |x: f64| Jet { at: x.into(), slope: C::default() };
        let matrix = x.map(|x| std::array::from_fn(|k| jet(f64::from(x).powi(k as i32))));
        for order in 2..=MAX_ORDER {
            let pairs = (0..order).flat_map(|j| (0..j).map(move |i| f64::from(x[j] - x[i])));
            let determinant = pairs.product::<f64>();
            assert_eq!(minor(&matrix, all(order), all(order)).at, determinant.into());
            for (i, j) in (0..order).flat_map(|i| (0..order).map(move |j| (i, j))) {
                let cofactors = cofactors(&matrix, order, j);
                let sum: C = matrix[i].iter().zip(cofactors).map(|(a, c)| a.at * c.at).sum();
                assert_eq!(
                    sum,
                    if i == j { determinant.into() } else { C::default() },
                    "{order}: {i} {j}"
                );
            }
        }
    }
}
