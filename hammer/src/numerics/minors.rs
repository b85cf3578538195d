//! Determinants and cofactors of small matrices, by expansion along their rows: without division, so
//! in any commutative ring.

/// Largest order.
pub const MOST: usize = 6;

/// A matrix of which the first `order` rows and columns are used.
pub type Matrix<T> = [[T; MOST]; MOST];

/// A commutative ring.
pub trait Ring {
    /// The numbers.
    type Number: Copy + Default;

    /// `a b`.
    fn product(&self, a: Self::Number, b: Self::Number) -> Self::Number;

    /// `a - b`.
    fn difference(&self, a: Self::Number, b: Self::Number) -> Self::Number;
}

/// The determinant.
pub fn determinant<R: Ring>(ring: &R, matrix: &Matrix<R::Number>, order: usize) -> R::Number {
    minor(ring, matrix, all(order), all(order))
}

/// Cofactors of a row, for order two or more; zero beyond the order.
pub fn cofactors<R: Ring>(
    ring: &R,
    matrix: &Matrix<R::Number>,
    order: usize,
    row: usize,
) -> [R::Number; MOST] {
    std::array::from_fn(|column| {
        if column >= order {
            return R::Number::default();
        }
        let minor = minor(ring, matrix, all(order) & !(1 << row), all(order) & !(1 << column));
        let is_odd = (row + column) % 2 == 1;
        if is_odd { ring.difference(R::Number::default(), minor) } else { minor }
    })
}

/// Mask of the first `order` rows or columns, one bit each.
fn all(order: usize) -> u8 {
    (1 << order) - 1
}

/// Determinant of some rows and as many columns, expanded along the first of the rows:
/// `a_0 M_0 - (a_1 M_1 - (a_2 M_2 - ...))`.
fn minor<R: Ring>(ring: &R, matrix: &Matrix<R::Number>, rows: u8, columns: u8) -> R::Number {
    let row = &matrix[rows.trailing_zeros() as usize % MOST];
    let below = rows & rows.wrapping_sub(1);
    let last = &matrix[below.trailing_zeros() as usize % MOST];
    let term = |column: usize| {
        let others = columns & !(1 << column);
        match below.count_ones() {
            0 => row[column],
            1 => ring.product(row[column], last[others.trailing_zeros() as usize % MOST]),
            _ => ring.product(row[column], minor(ring, matrix, below, others)),
        }
    };
    let used = (0..MOST).rev().filter(|column| columns >> column & 1 == 1);
    let sum = used.map(term).reduce(|rest, term| ring.difference(term, rest));
    sum.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Integers;

    impl Ring for Integers {
        type Number = i64;

        fn product(&self, a: i64, b: i64) -> i64 {
            a * b
        }

        fn difference(&self, a: i64, b: i64) -> i64 {
            a - b
        }
    }

    /// Vandermonde's determinant is the product of all differences. A matrix times its cofactors is its determinant
    /// times the unit matrix.
    #[test]
    fn determinants_and_cofactors_are_those_of_vandermonde() {
        let x: [i64; MOST] = [2, -3, 5, 7, -11, 13];
        let matrix: Matrix<i64> = x.map(|x: i64| std::array::from_fn(|k| x.pow(k as u32)));
        for order in 2..=MOST {
            let pairs = (0..order).flat_map(|j| (0..j).map(move |i| x[j] - x[i]));
            let known: i64 = pairs.product();
            assert_eq!(determinant(&Integers, &matrix, order), known);
            for (i, j) in (0..order).flat_map(|i| (0..order).map(move |j| (i, j))) {
                let cofactors = cofactors(&Integers, &matrix, order, j);
                let sum: i64 = matrix[i].iter().zip(cofactors).map(|(a, c)| a * c).sum();
                assert_eq!(sum, if i == j { known } else { 0 }, "{order}: {i} {j}");
            }
        }
    }
}
