//! First roots of polynomials on the interval from 0 to 1, certified by the signs of Bernstein's coefficients.
//!
//! A polynomial is a mean of its coefficients in Bernstein's form, weighted by functions that are not negative. If no
//! sign changes along the coefficients, there is no root; one change means one root. With more the interval is halved.

use crate::numerics::poly::TERMS;

/// Halvings, after which the part's start counts as the root.
const HALVINGS: usize = 40;
/// Steps of Newton's method, and the change that ends it.
const STEPS: usize = 60;
const SETTLED: f64 = 1e-15;

/// Coefficients, as many as the polynomial has.
type Terms = [f64; TERMS];

/// Bernstein's coefficients of `sum_k q_k t^k`: the power coefficients divided by binomials, then cumulated repeatedly.
fn coefficients(q: &[f64]) -> Terms {
    let (mut b, mut over, last) = ([0.0; TERMS], 1.0, q.len() - 1);
    for (k, c) in q.iter().enumerate() {
        b[k] = c * over;
        over *= (k + 1) as f64 / (last - k).max(1) as f64;
    }
    for first in 0..last {
        for i in (first..last).rev() {
            b[i + 1] += b[i];
        }
    }
    b
}

/// The first point from a given one on at which a polynomial rises to zero; the given point if the polynomial is
/// already zero or positive there.
pub(crate) fn first_rise(q: &[f64], from: f64) -> Option<f64> {
    let mut b = coefficients(q);
    if from > 0.0 {
        split(&mut b[..q.len()], from);
    }
    halved(q, &b, [from, 1.0], HALVINGS)
}

/// Splits the interval at a fraction of its length. Keeps the coefficients of the upper part; returns the lower part's.
fn split(b: &mut [f64], share: f64) -> Terms {
    let mut before = [0.0; TERMS];
    for (before, last) in before.iter_mut().zip((0..b.len()).rev()) {
        *before = b[0];
        for i in 0..last {
            b[i] += share * (b[i + 1] - b[i]);
        }
    }
    before
}

/// [`first_rise`] on a part, of which these are the coefficients.
fn halved(q: &[f64], b: &Terms, [start, end]: [f64; 2], halvings: usize) -> Option<f64> {
    let signs = &b[..q.len()];
    if b[0] >= 0.0 {
        return Some(start);
    }
    let first = signs.iter().position(|b| *b >= 0.0)?;
    if signs[first..].iter().all(|b| *b >= 0.0) {
        // Where the line between both coefficients crosses.
        let part = (first as f64 - b[first] / (b[first] - b[first - 1])) / (q.len() - 1) as f64;
        return Some(rise_between(q, [start, end], start + part * (end - start)));
    }
    if halvings == 0 {
        return Some(start);
    }
    let mut right = *b;
    let left = split(&mut right[..q.len()], 0.5);
    let middle = 0.5 * (start + end);
    let early = halved(q, &left, [start, middle], halvings - 1);
    early.or_else(|| halved(q, &right, [middle, end], halvings - 1))
}

/// The zero between a place below and one above, by Newton's method from `x`, kept in the bracket by bisection.
pub(crate) fn rise_between(q: &[f64], [mut low, mut high]: [f64; 2], mut x: f64) -> f64 {
    for _ in 0..STEPS {
        let (mut value, mut slope) = (0.0, 0.0);
        for c in q.iter().rev() {
            slope = slope * x + value;
            value = value * x + c;
        }
        if value < 0.0 {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= SETTLED {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::series::value;

    /// `(t - roots[0]) (t - roots[1]) ...`, times `lead`.
    fn with_roots(roots: &[f64], lead: f64) -> Vec<f64> {
        let mut q = vec![lead];
        for root in roots {
            q.insert(0, 0.0);
            (1..q.len()).for_each(|k| q[k - 1] -= root * q[k]);
        }
        q
    }

    /// The first of several roots is found, also of two that are 1e-6 apart, and the next one from a place beyond it. A
    /// polynomial that stays below zero by 1e-9 has none, and one that begins above zero has it at 0.
    #[test]
    fn the_first_rise_is_that_of_the_known_roots() {
        let cases: [(&[f64], f64, f64, Option<f64>); 8] = [
            (&[0.3, 0.6, 0.9], 1.0, 0.0, Some(0.3)),
            (&[0.3, 0.6, 0.9], 1.0, 0.6000001, Some(0.9)),
            (&[0.7, 0.7 + 1e-6], -1.0, 0.0, Some(0.7)),
            (&[1.2, 2.0, -1.0], 1.0, 0.0, Some(0.0)),
            (&[1.2, 2.0, -1.0], -1.0, 0.0, None),
            (&[0.25], -1.0, 0.0, Some(0.0)),
            (&[-0.5, 0.999], 2.0, 0.2, Some(0.999)),
            (&[0.2, 0.4, 0.5, 0.8, 0.95], 3.0, 0.0, Some(0.2)),
        ];
        for (roots, lead, from, expected) in cases {
            let q = with_roots(roots, lead);
            match (first_rise(&q, from), expected) {
                // Two roots 1e-6 apart are known to the rounding over their distance.
                (Some(found), Some(root)) => {
                    assert!((found - root).abs() < 1e-9, "{roots:?}: {found}");
                }
                (found, expected) => assert_eq!(found, expected, "{roots:?}"),
            }
        }
        let mut touching = with_roots(&[0.5, 0.5], -1.0);
        touching[0] -= 1e-9;
        assert_eq!(first_rise(&touching, 0.0), None);
    }

    /// At a place the coefficients sum to the polynomial's value, with Bernstein's weights.
    #[test]
    fn both_forms_have_the_same_values() {
        for last in [1, 8, 16, TERMS - 1] {
            let q: Vec<f64> = (0..=last).map(|k| 1.0 / (k + 1) as f64 - 0.3).collect();
            let b = coefficients(&q);
            let choose = |j: usize| (0..j).fold(1.0, |c, i| c * (last - i) as f64 / (i + 1) as f64);
            for t in [0.0, 0.2, 0.7, 1.0f64] {
                let weight =
                    |i: usize| choose(i) * t.powi(i as i32) * (1.0 - t).powi((last - i) as i32);
                let sum: f64 = (0..=last).map(|i| b[i] * weight(i)).sum();
                assert!((sum - value(&q, t)).abs() < 1e-13, "{last} {t}");
            }
        }
    }
}
