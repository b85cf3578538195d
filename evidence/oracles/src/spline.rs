//! B-splines by the recursion of Cox and de Boor, integrated exactly by Gauss's rule (de Boor, *A
//! Practical Guide to Splines*, 2001).

use crate::linear::Real;

/// `P_d` and `P_d'` at `x` inside of `[-1, 1]`: Bonnet's recursion.
fn legendre<T: Real>(degree: usize, x: T) -> [T; 2] {
    let (mut before, mut here) = (T::from(1.0), x);
    for k in 1..degree {
        let [n, next] = [k, k + 1].map(|k| T::from(k as f64));
        let ahead = ((n + next) * x * here - n * before) / next;
        (before, here) = (here, ahead);
    }
    [here, T::from(degree as f64) * (before - x * here) / (T::from(1.0) - x * x)]
}

/// Nodes and weights of Gauss's rule on `[0, 1]`: exact up to degree `2 count - 1`.
pub(crate) fn gauss<T: Real>(count: usize) -> Vec<[T; 2]> {
    let (one, half) = (T::from(1.0), T::from(0.5));
    let node = |i: usize| {
        let angle = std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5);
        let mut x = T::from(-angle.cos());
        for _ in 0..8 {
            let [p, slope] = legendre(count, x);
            x = x - p / slope;
        }
        let slope = legendre(count, x)[1];
        [half * (one + x), one / ((one - x * x) * slope * slope)]
    };
    (0..count).map(node).collect()
}

/// Open uniform knots of `spans` spans of length 1 for degree `degree`.
#[derive(Clone, Copy)]
pub(crate) struct Knots {
    pub(crate) degree: usize,
    pub(crate) spans: usize,
}

impl Knots {
    fn at<T: Real>(self, i: usize) -> T {
        T::from(i.saturating_sub(self.degree).min(self.spans) as f64)
    }

    /// The `degree + 1` splines of a degree up to the knots' that are not zero in a span, at `x`.
    pub(crate) fn values<T: Real>(self, degree: usize, span: usize, x: T) -> Vec<T> {
        let here = span + self.degree;
        let mut values = vec![T::from(1.0)];
        for d in 1..=degree {
            let mut next = vec![T::default(); d + 1];
            for (r, &value) in values.iter().enumerate() {
                let (low, high) = (self.at::<T>(here + 1 + r - d), self.at::<T>(here + 1 + r));
                let share = value / (high - low);
                next[r] = next[r] + (high - x) * share;
                next[r + 1] = (x - low) * share;
            }
            values = next;
        }
        values
    }

    /// Slopes of the splines of the knots' degree.
    pub(crate) fn slopes<T: Real>(self, span: usize, x: T) -> Vec<T> {
        let (p, here) = (self.degree, span + self.degree);
        let lower = self.values(p - 1, span, x);
        let mut slopes = vec![T::default(); p + 1];
        for (r, &value) in lower.iter().enumerate() {
            let width = self.at::<T>(here + 1 + r) - self.at::<T>(here + 1 + r - p);
            let share = T::from(p as f64) * value / width;
            slopes[r] = slopes[r] - share;
            slopes[r + 1] = slopes[r + 1] + share;
        }
        slopes
    }
}
