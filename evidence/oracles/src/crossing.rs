//! The first crossing of a guard that is a polynomial.
//!
//! A guard crosses where it rises through zero. The crossing counts once the guard exceeds its height (its
//! resolution) before it returns; the event's time is the zero. A guard of height 0 never falls, and crosses at once
//! if it starts at zero. A rise may begin in one polynomial and be decided in a later one, so a scan may start and
//! end *pending*.
//!
//! A step covers two or three radians of the fastest mode. The guard is sampled at 64 points, and at the extrema that
//! changes of its slope's sign reveal between them. A missed pair of crossings would need an oscillation some forty
//! times faster than the fastest mode.

use crate::model::Real;
use crate::taylor::horner;

const SAMPLES: usize = 64;

/// A zero from which the guard has risen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zero<T> {
    /// In an earlier polynomial.
    Earlier,
    /// At this abscissa.
    At(T),
}

/// What a scan found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome<T> {
    /// No crossing.
    Clear,
    /// A rise that has not yet exceeded the height.
    Pending(Zero<T>),
    /// The first crossing that counts.
    Crossed(Zero<T>),
}

/// Scans the guard `c` over `[0, end]`.
pub fn scan<T: Real>(c: &[T], end: f64, height: f64, pending: bool) -> Outcome<T> {
    let rounded: Vec<f64> = c.iter().map(|x| x.to_f64()).collect();
    let slope: Vec<f64> = rounded.iter().enumerate().skip(1).map(|(k, &c)| k as f64 * c).collect();
    if height == 0.0 && rounded[0] >= 0.0 {
        return Outcome::Crossed(if pending { Zero::Earlier } else { Zero::At(T::default()) });
    }
    let mut zero = pending.then_some(Zero::Earlier);
    let mut last = (0.0, rounded[0]);
    let mut last_slope = horner(&slope, 0.0);
    if let Some(found) = visit(c, last, last, height, &mut zero) {
        return found;
    }
    for i in 1..=SAMPLES {
        let x = end * i as f64 / SAMPLES as f64;
        let here = (x, horner(&rounded, x));
        let here_slope = horner(&slope, x);
        if last_slope * here_slope < 0.0 {
            let top = bisect(&slope, last.0, x);
            let top = (top, horner(&rounded, top));
            if let Some(found) = visit(c, last, top, height, &mut zero) {
                return found;
            }
            last = top;
        }
        if let Some(found) = visit(c, last, here, height, &mut zero) {
            return found;
        }
        (last, last_slope) = (here, here_slope);
    }
    zero.map_or(Outcome::Clear, Outcome::Pending)
}

/// Advances the pending zero over a monotone piece from `a` to `b`.
fn visit<T: Real>(
    c: &[T],
    a: (f64, f64),
    b: (f64, f64),
    height: f64,
    zero: &mut Option<Zero<T>>,
) -> Option<Outcome<T>> {
    if b.1 <= 0.0 {
        *zero = None;
        return None;
    }
    let from = *zero
        .get_or_insert_with(|| Zero::At(if a.1 > 0.0 { T::from(a.0) } else { root(c, a.0, b.0) }));
    (b.1 > height).then_some(Outcome::Crossed(from))
}

/// A sign change of `c` in `[a, b]`, to rounding.
fn bisect(c: &[f64], a: f64, b: f64) -> f64 {
    let (mut a, mut b) = (a, b);
    let falling = horner(c, a) > 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if (horner(c, middle) > 0.0) == falling {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

/// The rise of `c` through zero in `(a, b]`, to double-double rounding.
fn root<T: Real>(c: &[T], a: f64, b: f64) -> T {
    let (mut a, mut b) = (T::from(a), T::from(b));
    for _ in 0..105 {
        let middle = (a + b) * T::from(0.5);
        if horner(c, middle) > T::default() {
            b = middle;
        } else {
            a = middle;
        }
    }
    b
}
