//! Determinants and cofactors of small matrices, by expansion along their rows: without division, so in any commutative
//! ring.

use std::ops::{Mul, Sub};

/// Largest order.
pub const MOST: usize = 6;

/// A matrix of which the first `order` rows and columns are used.
pub type Matrix<T> = [[T; MOST]; MOST];

/// An entry: an element of a commutative ring.
pub trait Number: Copy + Default + Mul<Output = Self> + Sub<Output = Self> {}

impl<T: Copy + Default + Mul<Output = T> + Sub<Output = T>> Number for T {}

/// The determinant.
pub fn determinant<T: Number>(matrix: &Matrix<T>, order: usize) -> T {
    minor(matrix, all(order), all(order))
}

/// Cofactors of a row, for order two or more; zero beyond the order.
pub fn cofactors<T: Number>(matrix: &Matrix<T>, order: usize, row: usize) -> [T; MOST] {
    std::array::from_fn(|column| {
        if column >= order {
            return T::default();
        }
        let minor = minor(matrix, all(order) & !(1 << row), all(order) & !(1 << column));
        let is_odd = (row + column) % 2 == 1;
        if is_odd { T::default() - minor } else { minor }
    })
}

/// Mask of the first `order` rows or columns, one bit each.
fn all(order: usize) -> u8 {
    (1 << order) - 1
}

/// Determinant of some rows and as many columns, expanded along the first of the rows:
/// `a_0 M_0 - (a_1 M_1 - (a_2 M_2 - ...))`.
fn minor<T: Number>(matrix: &Matrix<T>, rows: u8, columns: u8) -> T {
    let row = &matrix[rows.trailing_zeros() as usize % MOST];
    let below = rows & rows.wrapping_sub(1);
    let last = &matrix[below.trailing_zeros() as usize % MOST];
    let term = |column: usize| {
        let others = columns & !(1 << column);
        match below.count_ones() {
            0 => row[column],
            1 => row[column] * last[others.trailing_zeros() as usize % MOST],
            _ => row[column] * minor(matrix, below, others),
        }
    };
    let used = (0..MOST).rev().filter(|column| columns >> column & 1 == 1);
    let sum = used.map(term).reduce(|rest, term| term - rest);
    sum.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vandermonde's determinant is the product of all differences. A matrix times its cofactors is its determinant
    /// times the unit matrix.
    #[test]
    fn determinants_and_cofactors_are_those_of_vandermonde() {
        let x: [i64; MOST] = [2, -3, 5, 7, -11, 13];
        let matrix: Matrix<i64> = x.map(|x: i64| std::array::from_fn(|k| x.pow(k as u32)));
        for order in 2..=MOST {
            let pairs = (0..order).flat_map(|j| (0..j).map(move |i| x[j] - x[i]));
            let known: i64 = pairs.product();
            assert_eq!(determinant(&matrix, order), known);
            for (i, j) in (0..order).flat_map(|i| (0..order).map(move |j| (i, j))) {
                let cofactors = cofactors(&matrix, order, j);
                let sum: i64 = matrix[i].iter().zip(cofactors).map(|(a, c)| a * c).sum();
                assert_eq!(sum, if i == j { known } else { 0 }, "{order}: {i} {j}");
            }
        }
    }
}
