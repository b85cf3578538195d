//! Tridiagonal matrices over any field, and what a number must do.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The arithmetic that the matrices need.
pub trait Field:
    Copy
    + Debug
    + Default
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
}

impl<T> Field for T where
    T: Copy
        + Debug
        + Default
        + From<f64>
        + Add<Output = Self>
        + Sub<Output = Self>
        + Mul<Output = Self>
        + Div<Output = Self>
        + Neg<Output = Self>
{
}

/// The arithmetic that the model needs.
pub trait Real: Field + PartialOrd {
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
}

impl Real for f64 {
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

/// A symmetric tridiagonal matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Tridiagonal<T> {
    /// `a[i][i]`.
    pub diagonal: Vec<T>,
    /// `a[i][i + 1]`.
    pub off: Vec<T>,
}

impl<T: Field> Tridiagonal<T> {
    /// Of size `n`.
    pub fn zero(n: usize) -> Self {
        Self { diagonal: vec![T::default(); n], off: vec![T::default(); n - 1] }
    }

    /// `sum c_i A_i`.
    pub fn combine(terms: [(T, &Self); 3]) -> Self {
        let row = |pick: fn(&Self) -> &[T]| {
            let [a, b, c] = terms.map(|(factor, matrix)| (factor, pick(matrix)));
            (0..a.1.len()).map(|i| a.0 * a.1[i] + b.0 * b.1[i] + c.0 * c.1[i]).collect()
        };
        Self { diagonal: row(|m| &m.diagonal), off: row(|m| &m.off) }
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
    }

    /// `A = L D L^T`, for [`Factor::solve`].
    pub fn factor(&self) -> Factor<T> {
        let n = self.diagonal.len();
        let mut lower = vec![T::default(); n - 1];
        let mut inverse = vec![T::default(); n];
        let mut pivot = self.diagonal[0];
        for i in 0..n {
            inverse[i] = T::from(1.0) / pivot;
            if i + 1 < n {
                lower[i] = self.off[i] * inverse[i];
                pivot = self.diagonal[i + 1] - lower[i] * self.off[i];
            }
        }
        Factor { lower, inverse }
    }
}

/// `L D L^T` of a [`Tridiagonal`].
#[derive(Clone, Debug)]
pub struct Factor<T> {
    /// `L[i + 1][i]`.
    pub lower: Vec<T>,
    /// `1 / D[i][i]`.
    pub inverse: Vec<T>,
}

impl<T: Field> Factor<T> {
    /// Solves in place, in `O(n)`.
    #[inline]
    pub fn solve(&self, x: &mut [T]) {
        let n = x.len();
        for i in 1..n {
            x[i] = x[i] - self.lower[i - 1] * x[i - 1];
        }
        x[n - 1] = x[n - 1] * self.inverse[n - 1];
        for i in (0..n - 1).rev() {
            x[i] = x[i] * self.inverse[i] - self.lower[i] * x[i + 1];
        }
    }
}
