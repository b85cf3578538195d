//! Windows: a guard's Taylor polynomial over a short time, with steps below a level, zeros and minima.

use crate::modal::system::TAYLOR;
use crate::numerics::bracket::{PASSES, admits};
use crate::numerics::grid::{self, GRID, Grid};
use crate::numerics::math;

/// Limit of the halvings of a window, which shorten it by a factor of up to a million.
const MAX_HALVINGS: u32 = 20;

/// Length of the part between two points of the grid, as a share of the window.
pub(crate) const PART: f64 = 1.0 / GRID as f64;

/// Largest `s` with `slope s + m s^2 / 2 <= room` on all of `[0, s]`; `room >= 0`.
pub(crate) fn step_below(room: f64, slope: f64, m: f64) -> f64 {
    if m <= 0.0 && slope <= 0.0 {
        return f64::INFINITY;
    }
    let discriminant = slope * slope + 2.0 * m * room;
    if discriminant < 0.0 {
        return f64::INFINITY; // The parabola is concave and turns back before it reaches the room.
    }
    if room <= 0.0 && slope >= 0.0 {
        return 0.0; // The parabola is at the level and does not fall. The formula below would give 0 / 0.
    }
    let root = discriminant.sqrt();
    if slope >= 0.0 { 2.0 * room / (slope + root) } else { (root - slope) / m }
}

/// If a function falls with `slope < 0` at 0, how long it is certain to stay at least `depth` below its value there,
/// once it has fallen by that much; `None` if it need not fall so far. `m` bounds its second derivative.
pub(crate) fn dip(depth: f64, slope: f64, m: f64) -> Option<f64> {
    let discriminant = slope * slope - 2.0 * m * depth;
    if slope >= 0.0 || discriminant <= 0.0 || discriminant.is_nan() {
        return None;
    }
    let fall = discriminant.sqrt() - slope;
    Some(if m > 0.0 { fall / m } else { f64::INFINITY })
}

/// A guard's Taylor polynomial on one window.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Length of the window, s.
    pub h: f64,
    /// Coefficients of the polynomial in `(time - start) / h`.
    pub q: [f64; TAYLOR],
    /// Rounding of the modes' part of the coefficients.
    pub modal: Noise,
    /// Sum of the roundings of the drift's part of all coefficients.
    pub drift: f64,
}

/// Rounding of the modes' part of a window's coefficients.
///
/// Coefficient `k` is a sum over the modes whose terms have a total size of at most `a_k h^k / k!`, with `a_k = sum |c|
/// |B|^k |z|`. The products and sums cause `operations` roundings; the row and the scale add 4 for each power. Here
/// `|B|` has the absolute values of a block's entries, and its norm is at most `sqrt 2` times that of `B`. Since
/// `a_k^(1/k)` rises with `k` (as power means do), `a_k <= a_0 s^k` with `s^TAYLOR = a_TAYLOR / a_0`. With `y = sqrt(2)
/// s h` the errors of all coefficients sum to at most
///
/// ```text
/// eps a_0 sum_k (operations + 4 k) y^k / k!  <=  eps a_0 (operations + 4 y) exp(y)
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Noise {
    /// `eps a_0`.
    pub amplitude: f64,
    /// Rounding of a sum of products, in units of `eps`.
    pub operations: f64,
    /// The number `y`.
    pub growth: f64,
}

impl Noise {
    fn bound(&self) -> f64 {
        if self.amplitude == 0.0 {
            return 0.0;
        }
        self.amplitude * (self.operations + 4.0 * self.growth) * math::exp(self.growth)
    }

    /// The rounding in the limit of a short window.
    fn least(&self) -> f64 {
        self.amplitude * self.operations
    }
}

impl Window {
    /// Bound on the sum of the roundings of all coefficients, including the roundings of terms that cancel.
    pub fn noise(&self) -> f64 {
        self.drift + self.modal.bound()
    }

    /// Bound on the rounding of a value in the window, by the roundings of the coefficients and of their sum.
    pub fn rounding(&self) -> f64 {
        self.noise() + rounding(&self.q)
    }

    /// Halves the window until its rounding is below `fine`, if possible, and also returns the rounding. Otherwise the
    /// rounding would exceed the guard's resolution for a body that moves by metres in a window. `drift` returns the
    /// rounding of the drift over a window of a given length.
    pub(crate) fn shortened(mut self, fine: f64, drift: impl Fn(f64) -> f64) -> (Self, f64) {
        let allowed = fine.max(2.0 * (drift(0.0) + f64::EPSILON * self.q[0].abs()));
        // If no shorter window would reduce the modes' rounding enough, that rounding is ignored.
        if 2.0 * self.modal.least() >= fine {
            self.modal = Noise::default();
        }
        let mut rounding = self.rounding();
        for _ in 0..MAX_HALVINGS {
            if rounding <= allowed {
                break;
            }
            self.h *= 0.5;
            self.modal.growth *= 0.5;
            self.drift = drift(self.h);
            let mut power = 1.0;
            for c in &mut self.q {
                *c *= power;
                power *= 0.5;
            }
            rounding = self.rounding();
        }
        (self, rounding)
    }
}

/// Bound on the rounding of `sum q_k x^k` on `[0, 1]` by Horner's rule. Each of `2 k + 1` operations rounds the term of
/// power `k` by half an `eps`.
pub(crate) fn rounding(q: &[f64; TAYLOR]) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for c in q {
        weight += f64::EPSILON;
        sum += weight * c.abs();
    }
    sum
}

/// Value and slope of the polynomial at `x`, by Horner's rule.
pub(crate) fn horner(q: &[f64; TAYLOR], x: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for &c in q.iter().rev() {
        slope = slope * x + value;
        value = value * x + c;
    }
    (value, slope)
}

/// The point at which the next window begins. It is `end` or, if the guard is above zero there, the last point of the
/// grid before the zero that it rose through, so that the next window finds this zero.
pub(crate) fn back_up(q: &[f64; TAYLOR], grid: &Grid, end: f64) -> f64 {
    if horner(q, end).0 <= 0.0 {
        return end;
    }
    // The division by a power of two is exact.
    let points = &grid.value[..(end / PART) as usize];
    points.iter().rposition(|&value| value <= 0.0).map_or(end, |i| (i + 1) as f64 * PART)
}

/// A point before `end` at which a guard that starts above zero and falls is below zero, if there is one. (After a
/// transition, rounding may leave the transition's own guard above zero. If the guard falls below zero, its next rise
/// is another crossing.)
pub(crate) fn low_point(q: &[f64; TAYLOR], end: f64) -> Option<f64> {
    let (mut low, mut high) = (0.0, end);
    if horner(q, low).1 >= 0.0 {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let (value, slope) = horner(q, middle);
        if value < 0.0 {
            return Some(middle);
        }
        if slope < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    None
}

/// A zero between `low`, where the polynomial is not above zero, and `high`, where it is. Newton's method starts from
/// `high`; bisection keeps it within the bracket.
pub(crate) fn zero_between(q: &[f64; TAYLOR], mut low: f64, mut high: f64) -> f64 {
    let mut x = high;
    for pass in 0..PASSES {
        let (value, slope) = horner(q, x);
        if value > 0.0 {
            high = x
        } else {
            low = x
        }
        let newton = x - value / slope;
        let next = if admits(pass, [low, high], newton) { newton } else { 0.5 * (low + high) };
        // A window is microseconds long, so the error is below 1e-19 s.
        if (next - x).abs() <= 1e-14 || next <= low || next >= high {
            return next.clamp(low, high);
        }
        x = next;
    }
    x
}

/// Number of evaluations (some milliseconds of work) after which [`maximum`] stops. A flat maximum takes thousands. If
/// bounds overflow, the halving would never end otherwise.
pub(crate) const EVALUATIONS: u64 = 1 << 16;

/// The larger of `best` and the maximum of `sum p_k x^k` on `[0, 1]`, accurate to the rounding of the polynomial's
/// terms.
/// Parts of the interval are halved until an upper bound on each is no larger than the best value.
/// Also returns the number of evaluations. If this is [`EVALUATIONS`], the true maximum may be larger.
pub(crate) fn maximum(p: &[f64; TAYLOR], best: f64) -> (f64, u64) {
    let grid = grid::on_grid(p);
    let best = grid.value.iter().fold(best.max(p[0]), |a, &b| a.max(b));
    let mut search = Maximum { p, fine: rounding(p), best, evaluations: 0 };
    let (mut left, mut left_second) = (p[0], 2.0 * p[2]);
    for i in 0..GRID {
        let (right, right_second) = (grid.value[i], grid.second[i]);
        // Every point of a part is within half its length from one of its ends.
        let drift = 0.5 * PART * grid.third_bound[i];
        let dip = (drift - left_second.min(right_second)).max(0.0);
        let (start, end) = (i as f64 * PART, (i + 1) as f64 * PART);
        search.between([start, left], [end, right], dip);
        (left, left_second) = (right, right_second);
    }
    (search.best, search.evaluations)
}

/// The search for a polynomial's maximum.
struct Maximum<'a> {
    p: &'a [f64; TAYLOR],
    /// By how much the true maximum may exceed the best value found.
    fine: f64,
    best: f64,
    evaluations: u64,
}

impl Maximum<'_> {
    /// Searches between two points `[x, value]`, where the second derivative is at least `-dip`.
    fn between(&mut self, a: [f64; 2], b: [f64; 2], dip: f64) {
        let width = b[0] - a[0];
        // The function lies below the parabola through both ends that has the second derivative `-dip`.
        let (sag, rise) = (0.125 * dip * width * width, (b[1] - a[1]).abs());
        let top = if rise < 4.0 * sag {
            // In this order of operations nothing overflows unless the result does.
            0.5 * (a[1] + b[1]) + sag + rise * (rise / (16.0 * sag))
        } else {
            a[1].max(b[1])
        };
        let middle = 0.5 * (a[0] + b[0]);
        let continues = top > self.best + self.fine && a[0] < middle && middle < b[0];
        if !continues || self.evaluations == EVALUATIONS {
            return;
        }
        self.evaluations += 1;
        let value = self.p.iter().rev().fold(0.0, |sum, c| sum * middle + c);
        self.best = self.best.max(value);
        self.between(a, [middle, value], dip);
        self.between([middle, value], b, dip);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::instant::Double;

    /// `1 - s (x - c)^2` has its maximum 1 at `c`, also near either end.
    #[test]
    fn a_maximum_is_found_wherever_it_lies_in_a_window() {
        for i in 0..=1000 {
            let c = f64::from(i) / 1000.0;
            for s in [1e-3, 1.0, 40.0] {
                let mut p = [0.0; TAYLOR];
                (p[0], p[1], p[2]) = (1.0 - s * c * c, 2.0 * s * c, -s);
                // The search stops within the rounding of the terms.
                let (maximum, evaluations) = maximum(&p, f64::NEG_INFINITY);
                let error = (maximum - 1.0).abs();
                assert!(error <= 2.0 * rounding(&p), "c {c} s {s}: {error:e}");
                assert!(evaluations < 64, "c {c} s {s}: {evaluations}");
            }
        }
        // NaN must not cause an endless loop.
        assert!(!maximum(&[f64::NAN; TAYLOR], 0.0).0.is_nan());
    }

    /// The squares of the first polynomial's values overflow. In the second polynomial the third derivative overflows
    /// too, so that all bounds are infinite.
    #[test]
    fn a_search_for_the_maximum_of_an_enormous_polynomial_ends() {
        let falling = |power: usize, c: f64| {
            std::array::from_fn(|k| [1.0, -c, 0.0][if k == power { 1 } else { 2 * k.min(1) }])
        };
        let (value, evaluations) = maximum(&falling(5, 3e194), 0.0);
        assert!(value == 1.0 && evaluations < EVALUATIONS, "{value} {evaluations}");
        assert_eq!(maximum(&falling(TAYLOR - 1, 1e305), 0.0), (1.0, EVALUATIONS));
    }

    /// All combinations of negative, zero and positive slopes and curvatures.
    fn slopes() -> impl Iterator<Item = (f64, f64)> {
        let values = [-3.0, -0.2, 0.0, 0.2, 3.0];
        values.into_iter().flat_map(move |slope| values.map(|m| (slope, m)))
    }

    /// A parabola reaches `room` at the end of its step and not before. If the step is infinite, it never does. The
    /// tolerance is three roundings of the parabola's terms.
    #[test]
    fn a_step_ends_where_its_parabola_first_reaches_the_room() {
        for ((slope, m), room) in slopes().flat_map(|s| [0.0, 1e-3, 0.7].map(|room| (s, room))) {
            let above = |s: f64| s * (slope + 0.5 * m * s) - room;
            let step = step_below(room, slope, m);
            let last = step.min(100.0);
            assert!((1..200).all(|i| above(f64::from(i) / 200.0 * last) <= 0.0), "{slope} {m}");
            if step < f64::INFINITY {
                let rounding = 3.0 * f64::EPSILON * (step * (slope.abs() + m.abs() * step) + room);
                assert!(above(step).abs() <= rounding, "{slope} {m} {room}: {step}");
            } else {
                assert!(slope <= 0.0 || slope * slope + 2.0 * m * room < 0.0, "{slope} {m} {room}");
            }
        }
    }

    /// At the end of its dip a parabola is `depth` below its start value, and before that it is below zero. If there is
    /// no dip, the parabola never falls so far. A bound on the curvature is never negative.
    #[test]
    fn a_dip_is_where_its_parabola_is_below_the_depth() {
        let cases = slopes().filter(|(_, m)| *m >= 0.0);
        for ((slope, m), depth) in cases.flat_map(|s| [1e-3, 0.7].map(|depth| (s, depth))) {
            let above = |s: f64| s * (slope + 0.5 * m * s) + depth;
            let Some(end) = dip(depth, slope, m) else {
                assert!(slope >= 0.0 || slope * slope <= 2.0 * m * depth, "{slope} {m} {depth}");
                continue;
            };
            assert_eq!(end == f64::INFINITY, m == 0.0);
            let last = end.min(100.0);
            assert!((1..100).all(|i| above(f64::from(i) / 100.0 * last) < depth));
            if end < f64::INFINITY {
                let rounding = 3.0 * f64::EPSILON * (end * (slope.abs() + m * end) + depth);
                assert!(above(end).abs() <= rounding, "{slope} {m} {depth}: {end}");
            }
        }
    }

    /// A cubic whose terms cancel, with zeros at 0.2, 0.55 and 0.9.
    fn cubic(sign: f64) -> [f64; TAYLOR] {
        let mut q = [0.0; TAYLOR];
        q[..4].copy_from_slice(&[-0.099, 0.785, -1.65, 1.0].map(|c| sign * c));
        q
    }

    /// All errors, found by comparison with double-double values, are within the bound; the largest exceeds 1/50 of it.
    #[test]
    fn the_rounding_of_a_value_is_bounded_by_that_of_its_terms() {
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let mut largest = 0.0f64;
        for _ in 0..2000 {
            let q: [f64; TAYLOR] = std::array::from_fn(|_| random());
            let x = random().abs();
            let exact = q
                .iter()
                .rev()
                .fold(Double::default(), |sum, &c| sum * Double::new(x) + Double::new(c));
            let error = (exact - Double::new(horner(&q, x).0)).value().abs();
            largest = largest.max(error / rounding(&q));
        }
        assert!((0.02..=1.0).contains(&largest), "{largest}");
    }

    /// Zeros are found with an error of at most the rounding of a value over the slope.
    #[test]
    fn zeros_and_low_points_of_a_window_are_found() {
        let (rising, falling) = (cubic(1.0), cubic(-1.0));
        for (q, low, high, zero) in
            [(rising, 0.0, 0.3, 0.2), (rising, 0.6, 1.0, 0.9), (falling, 0.3, 0.7, 0.55)]
        {
            let root = zero_between(&q, low, high);
            let bound = 1e-14 + rounding(&q) / horner(&q, zero).1;
            assert!((root - zero).abs() <= bound, "{root} {zero}");
        }
        // This cubic starts above zero and falls below it at 0.2.
        let low = low_point(&falling, 0.4).expect("it falls below zero");
        assert!(horner(&falling, low).0 < 0.0 && low < 0.4);
        assert_eq!(low_point(&rising, 1.0), None);
        let mut shallow = [0.0; TAYLOR];
        shallow[..3].copy_from_slice(&[1e-3, -2e-2, 1.0]);
        assert_eq!(low_point(&shallow, 1.0), None);
    }

    /// If a window ends above zero, the next one begins at the last point of the grid at which the guard is not above
    /// zero.
    #[test]
    fn a_window_is_left_before_a_rise_through_zero() {
        let (rising, falling) = (cubic(1.0), cubic(-1.0));
        let next = |q: &[f64; TAYLOR], end: f64| back_up(q, &grid::on_grid(q), end);
        assert_eq!([next(&rising, 1.0), next(&rising, 0.75)], [0.875, 0.75]);
        assert_eq!([next(&falling, 1.0), next(&falling, 0.75)], [1.0, 0.5]);
        // If the guard is nowhere below zero, the next window begins at the end of this one.
        let mut above = [0.0; TAYLOR];
        above[0] = 1.0;
        assert_eq!(next(&above, 0.5), 0.5);
    }

    /// Drift, modes and values all contribute to the rounding. At first the window is too long for the rounding to be
    /// small enough.
    #[test]
    fn a_window_is_halved_until_its_rounding_is_fine() {
        let drift = |h: f64| 1e-16 + 1e-9 * h;
        let mut q = [0.0; TAYLOR];
        q[..4].copy_from_slice(&[0.3, -9.0, 40.0, 7.0]);
        let modal = |growth| Noise { amplitude: 1e-17, operations: 40.0, growth };
        // The rounding of a window of this length, by its definition.
        let bound = |h: f64, halvings: i32| {
            let y = 3.0 * 0.5f64.powi(halvings);
            let terms: Vec<f64> = (0..4).map(|k| q[k] * 0.5f64.powi(halvings * k as i32)).collect();
            let sum = terms.iter().zip(1..).map(|(c, k)| f64::from(k) * f64::EPSILON * c.abs());
            drift(h) + 1e-17 * (40.0 + 4.0 * y) * y.exp() + sum.sum::<f64>()
        };
        let h = 1e-3;
        for halvings in [0, 1, 3, 7] {
            let fine = 1.0001 * bound(h * 0.5f64.powi(halvings), halvings);
            let window = Window { h, q, modal: modal(3.0), drift: drift(h) };
            let (short, rounding) = window.shortened(fine, drift);
            assert_eq!(short.h, h * 0.5f64.powi(halvings), "{halvings}");
            let ratio = rounding / fine;
            assert!((ratio - 1.0 / 1.0001).abs() < 1e-12, "{halvings}: {rounding} {fine}");
            for x in [0.0, 0.4, 1.0] {
                let whole = horner(&q, x * short.h / h).0;
                assert!((horner(&short.q, x).0 - whole).abs() < 1e-13, "{halvings} {x}");
            }
        }
        // If no window is short enough for the modes' rounding, or for that of the value at the start, the rounding is
        // ignored.
        let loud = Noise { amplitude: 1e-3, ..modal(3.0) };
        let window = Window { h, q, modal: loud, drift: drift(h) };
        let (short, rounding) = window.shortened(0.05, drift);
        assert!(short.h == h && rounding < 1e-10, "{rounding}");
        let window = Window { h, q, modal: modal(3.0), drift: drift(h) };
        let (short, rounding) = window.shortened(1e-30, drift);
        let least = 2.0 * (drift(0.0) + f64::EPSILON * q[0]);
        assert!(short.h < h && rounding <= least && rounding > 0.5 * least, "{rounding} {least}");
    }
}
