//! First roots of polynomials on the interval from 0 to 1, isolated by the signs of Bernstein's coefficients.
//!
//! At each point the value of a polynomial is a mean of its coefficients in Bernstein's form, with weights that are not
//! negative. If the sign never changes along the coefficients, there is no root; if it changes once, there is one root.
//! If it changes more often, the interval is halved.

use crate::numerics::bracket::{PASSES, admits};
use crate::numerics::kernel::vectorised;
use crate::numerics::series::{HIGH, HighPowers, ORDER, Powers, value_and_slope};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Limit of the halvings. After them, the start of the part counts as the root.
const HALVINGS: usize = 40;
/// The change of a zero at which its iteration stops.
const SETTLED: f64 = 1e-15;

/// Least factor that is assumed for the square of an error: that of a zero of a polynomial of some ten powers on the
/// interval.
const LEAST_FACTOR: f64 = 32.0;

/// Least distance of two changes of sign, over the interval.
const APART: f64 = 1e-9;

/// Most coefficients of a polynomial.
pub(crate) const MOST: usize = 24;

/// The coefficients of a polynomial, followed by zeros.
pub(crate) type Terms = [f64; MOST];

vectorised! {
    /// Bernstein's coefficients of the motion of a rigid body.
    pub(crate) fn of_motion(q: &'a HighPowers) -> Terms as OfMotion, _simd {
        summed(q, &OF_MOTION)
    }
}

vectorised! {
    /// Bernstein's coefficients of a power series up to [`ORDER`].
    fn of_series(q: &'a Powers) -> Terms as OfSeries, _simd {
        summed(q, &OF_SERIES)
    }
}

#[inline(always)]
fn summed<const COUNT: usize>(q: &[f64; COUNT], all: &[[f64; COUNT]; COUNT]) -> Terms {
    let mut b = [0.0; MOST];
    for (c, shares) in q.iter().zip(all) {
        for i in 0..COUNT {
            b[i] += c * shares[i];
        }
    }
    b
}

static OF_MOTION: [HighPowers; HIGH + 1] = shares();
static OF_SERIES: [Powers; ORDER + 1] = shares();

/// The contribution `C(i, j) / C(n, j)` of the power `j` to coefficient `i`, in the order `[j][i]`; `n` is the highest
/// power.
const fn shares<const COUNT: usize>() -> [[f64; COUNT]; COUNT] {
    let (mut all, mut j) = ([[0.0; COUNT]; COUNT], 0);
    while j < COUNT {
        let (mut last, mut i) = (1.0, COUNT - 1);
        while i + 1 > j {
            all[j][i] = last;
            if i == 0 {
                break;
            }
            last *= (i - j) as f64 / i as f64;
            i -= 1;
        }
        j += 1;
    }
    all
}

/// Bernstein's coefficients of `sum_k q_k t^k`: the power coefficients divided by binomials, then summed cumulatively
/// again and again.
fn coefficients(q: &[f64]) -> Terms {
    if let Ok(q) = q.try_into() {
        return of_motion(q);
    }
    if let Ok(q) = q.try_into() {
        return of_series(q);
    }
    let (mut b, last) = ([0.0; MOST], q.len() - 1);
    for ((b, c), over) in b.iter_mut().zip(q).zip(&OVER_CHOICES[last]) {
        *b = c * over;
    }
    for first in 0..last {
        let mut before = b[first];
        for b in &mut b[first + 1..=last] {
            (before, *b) = (*b, *b + before);
        }
    }
    b
}

/// Reciprocals of the binomials `C(n, k)`, in the order `[n][k]`.
static OVER_CHOICES: [Terms; MOST] = {
    let (mut all, mut n) = ([[0.0; MOST]; MOST], 0);
    while n < MOST {
        let (mut over, mut k) = (1.0, 0);
        while k < n {
            all[n][k] = over;
            over *= (k + 1) as f64 / (n - k) as f64;
            k += 1;
        }
        all[n][n] = over;
        n += 1;
    }
    all
};

/// The first point, not before a given one, at which a polynomial rises to zero. It is the given point if the
/// polynomial is not negative there.
pub(crate) fn first_rise(q: &[f64], from: f64) -> Option<f64> {
    let mut b = coefficients(q);
    if from > 0.0 {
        split(&mut b[..q.len()], from);
    }
    halved(q, &b, [from, 1.0], HALVINGS)
}

/// The points of the interval at which a polynomial changes its sign, in order.
pub(crate) fn changes(q: &[f64]) -> Vec<f64> {
    let mut found = Vec::new();
    let mut signed = q.to_vec();
    if signed.iter().find(|c| **c != 0.0).is_some_and(|first| *first > 0.0) {
        signed.iter_mut().for_each(|c| *c = -*c);
    }
    // Before the next change the polynomial is negative.
    let mut from = 0.0;
    while let Some(change) = first_rise(&signed, from) {
        found.extend((change > 0.0).then_some(change));
        // Two changes closer than this count as none.
        from = change + APART;
        if found.len() == q.len() || from >= 1.0 {
            break;
        }
        signed.iter_mut().for_each(|c| *c = -*c);
    }
    found
}

/// Splits the interval at a share of its length. `b` receives the coefficients of the upper part; those of the lower
/// part are returned.
fn split(b: &mut [f64], share: f64) -> Terms {
    let mut before = [0.0; MOST];
    for (before, last) in before.iter_mut().zip((0..b.len()).rev()) {
        *before = b[0];
        for i in 0..last {
            b[i] += share * (b[i + 1] - b[i]);
        }
    }
    before
}

/// [`first_rise`] on a part that has these coefficients.
fn halved(q: &[f64], b: &Terms, [start, end]: [f64; 2], halvings: usize) -> Option<f64> {
    let signs = &b[..q.len()];
    if b[0] >= 0.0 {
        return Some(start);
    }
    let first = signs.iter().position(|b| *b >= 0.0)?;
    if signs[first..].iter().all(|b| *b >= 0.0) {
        // The point at which the line through the two coefficients crosses zero.
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

/// The zero between a point where the polynomial is negative and one where it is positive, by Newton's method from `x`.
/// Bisection keeps it within the bracket.
pub(crate) fn rise_between(q: &[f64], [mut low, mut high]: [f64; 2], mut x: f64) -> f64 {
    let mut last = 0.0;
    for pass in 0..PASSES {
        let [value, slope] = value_and_slope(q, x);
        if value < 0.0 {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let is_newton = admits(pass, [low, high], newton);
        let next = if is_newton { newton } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        // Newton's method squares the error, with a factor that two steps show.
        let ahead = step * step * (step / (last * last)).max(LEAST_FACTOR);
        if step <= SETTLED || is_newton && ahead <= SETTLED {
            return next;
        }
        (x, last) = (next, step);
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

    /// The first of several roots is found, even if two are 1e-6 apart, and then the next one from a point beyond it. A
    /// polynomial that stays below -1e-9 has no root, and one that begins above zero has it at 0.
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
                // The error of two roots 1e-6 apart is the rounding over their distance.
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

    /// At every point the coefficients, with Bernstein's weights, sum to the polynomial's value.
    #[test]
    fn both_forms_have_the_same_values() {
        for last in [1, 8, 16, MOST - 1] {
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
