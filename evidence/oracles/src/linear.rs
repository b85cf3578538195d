//! Symmetric banded matrices over any kind of number, and the operations of such numbers.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The arithmetic that the matrices and the model need.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
}

impl Real for f64 {
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

/// A symmetric banded matrix, by its diagonals.
#[derive(Clone, Debug, PartialEq)]
pub struct Banded<T> {
    /// `a[i][i]`.
    pub diagonal: Vec<T>,
    /// `a[i][i + 1]`.
    pub off: Vec<T>,
    /// `a[i][i + 2]`, `a[i][i + 3]` and so on; linear elements have none.
    pub far: Vec<Vec<T>>,
}

impl<T: Real> Banded<T> {
    /// Of size `n`.
    pub fn zero(n: usize) -> Self {
        Self { diagonal: vec![T::default(); n], off: vec![T::default(); n - 1], far: Vec::new() }
    }

    /// Adds to `a[i][j]` and `a[j][i]`, `i <= j`.
    pub fn add(&mut self, [i, j]: [usize; 2], value: T) {
        let n = self.diagonal.len();
        while self.far.len() + 1 < j - i {
            self.far.push(vec![T::default(); n - self.far.len() - 2]);
        }
        let row = match j - i {
            0 => &mut self.diagonal,
            1 => &mut self.off,
            k => &mut self.far[k - 2],
        };
        row[i] = row[i] + value;
    }

    /// Every entry times a factor.
    pub fn scaled(&self, factor: T) -> Self {
        let row = |row: &Vec<T>| row.iter().map(|&a| factor * a).collect();
        Self {
            diagonal: row(&self.diagonal),
            off: row(&self.off),
            far: self.far.iter().map(row).collect(),
        }
    }

    /// `out -= A x`.
    #[inline]
    pub fn subtract_product(&self, x: &[T], out: &mut [T]) {
        let n = x.len();
        for i in 0..n {
            let mut sum = self.diagonal[i] * x[i];
            if i > 0 {
                sum = sum + self.off[i - 1] * x[i - 1];
            }
            if i + 1 < n {
                sum = sum + self.off[i] * x[i + 1];
            }
            out[i] = out[i] - sum;
        }
        for (row, k) in self.far.iter().zip(2..) {
            for (i, &a) in row.iter().enumerate() {
                out[i] = out[i] - a * x[i + k];
                out[i + k] = out[i + k] - a * x[i];
            }
        }
    }

    /// `x.A x` of a matrix whose rows sum to zero, computed from differences, which do not cancel.
    pub fn square_of_differences(&self, x: &[T]) -> T {
        let rows = std::iter::once(&self.off).chain(&self.far).zip(1..);
        rows.fold(T::default(), |sum, (row, k)| {
            row.iter().enumerate().fold(sum, |sum, (i, &a)| {
                let stretch = x[i + k] - x[i];
                sum - a * stretch * stretch
            })
        })
    }

    /// `A = L D L^T` of the `n` rows and columns from `first` on, for [`Factor::solve`].
    pub fn factor(&self, first: usize, n: usize) -> Factor<T> {
        let row =
            |row: &[T], k: usize| row[first..(first + n).saturating_sub(k).max(first)].to_vec();
        let beyond = std::iter::once(&self.off).chain(&self.far).zip(1..);
        let mut a = vec![row(&self.diagonal, 0)];
        a.extend(beyond.map(|(all, k)| row(all, k)));
        let mut inverse = vec![T::default(); n];
        for i in 0..n {
            inverse[i] = T::from(1.0) / a[0][i];
            let reach = (n - 1 - i).min(a.len() - 1);
            let column: Vec<T> = (1..=reach).map(|k| a[k][i]).collect();
            for k in 1..=reach {
                a[k][i] = column[k - 1] * inverse[i];
                for m in k..=reach {
                    a[m - k][i + k] = a[m - k][i + k] - a[k][i] * column[m - 1];
                }
            }
        }
        let lower = a.remove(1);
        Factor { inverse, lower, far: a.split_off(1) }
    }
}

/// `L D L^T` of a [`Banded`].
#[derive(Clone, Debug)]
pub struct Factor<T> {
    /// `1 / D[i][i]`.
    pub inverse: Vec<T>,
    /// `L[i + 1][i]`.
    pub lower: Vec<T>,
    /// `L[i + 2][i]` and so on.
    far: Vec<Vec<T>>,
}

impl<T: Real> Factor<T> {
    /// Solves in place, in `O(n)`.
    #[inline]
    pub fn solve(&self, x: &mut [T]) {
        let n = x.len();
        for i in 1..n {
            x[i] = x[i] - self.lower[i - 1] * x[i - 1];
            for (row, k) in self.far.iter().zip(2..=i) {
                x[i] = x[i] - row[i - k] * x[i - k];
            }
        }
        x[n - 1] = x[n - 1] * self.inverse[n - 1];
        for i in (0..n - 1).rev() {
            x[i] = x[i] * self.inverse[i] - self.lower[i] * x[i + 1];
            for (row, k) in self.far.iter().zip(2..n - i) {
                x[i] = x[i] - row[i] * x[i + k];
            }
        }
    }
}
