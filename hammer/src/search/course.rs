//! Guards of a rigid hammer in a window of the air: polynomials, whose first crossing is found at once.
//!
//! A guard `g` rises through zero. With its resolution `r`, all that [`super::tracker`] states holds here too, and for
//! these reasons:
//!
//! * Where `g - 7 r / 8` has no zero in the window, by the signs of Bernstein's coefficients, `g` does not cross.
//! * Otherwise the crossing is the last zero of `g` before the first one of `g - 7 r / 8`.
//! * A guard that starts above zero by no more than it may is lowered by its first value.
//! * The resolution is at least 16 times the rounding of the polynomial's terms.

use crate::laws::event::{Displacement, Guard};
use crate::motion::{Bounds, CURVES, Course, Motion};
use crate::numerics::bernstein::{Terms, first_rise, of_motion, rise_between};
use crate::numerics::series::{HIGH, HighPowers, value, value_and_slope};
use crate::search::tracker::{AMBIGUOUS, CROSSED, NEAR, ROUNDED};
use std::array::from_fn;
use std::cell::OnceCell;

/// First step back from where a guard has crossed to where it was below zero, over the window's length.
const LEAST_STEP: f64 = 1e-12;

/// What the guards of a rigid hammer watch: the relative position of the piston, the displacement of the tip, and its
/// velocity, in the time over the window's length.
#[derive(Debug)]
pub(super) struct Curves<'a> {
    course: &'a Course,
    bounds: Bounds,
    /// Bernstein's coefficients of each, once they are needed.
    bernstein: [OnceCell<Terms>; CURVES],
    resolutions: [f64; 2],
    /// Until when the window is valid, as a share of its length.
    end: f64,
}

impl<'a> Curves<'a> {
    /// The curves of the window that begins at the epoch; `None` if the bodies are not expanded with the air.
    pub fn new(motion: &'a Motion) -> Option<Self> {
        let course = motion.course()?;
        Some(Self {
            course,
            bounds: course.bounds(),
            bernstein: Default::default(),
            resolutions: motion.model.resolutions,
            end: motion.reach() / course.length,
        })
    }

    /// Coefficients of a curve.
    fn powers(&self, place: usize) -> HighPowers {
        let rows = &self.course.rows;
        match place {
            0 => rows.map(|[p, q, ..]| p - q),
            1 => rows.map(|[_, q, ..]| q),
            _ => from_fn(|k| match rows.get(k + 1) {
                Some([_, q, ..]) => (k + 1) as f64 * q / self.course.length,
                None => 0.0,
            }),
        }
    }

    /// The instant at which a guard first crosses in the window, s.
    pub fn crossing(&self, guard: &Guard) -> Option<f64> {
        let Guard { displacement, order, direction, level, .. } = *guard;
        let (place, way, level) = match displacement {
            Displacement::Tip => (1 + order, direction, level),
            // The gap is the piston's position in the other direction.
            Displacement::Tie(_) => (0, direction.reverse(), -level),
            _ => (0, direction, level),
        };
        let rounding = HIGH as f64 * f64::EPSILON * self.bounds.size(place);
        let resolution = self.resolutions[order].max(rounding / ROUNDED);
        let sign = way.sign();
        let most = if sign > 0.0 { self.bounds.most[place] } else { -self.bounds.least[place] };
        if most - sign * level < CROSSED * resolution {
            return None;
        }
        let b = self.bernstein[place].get_or_init(|| of_motion(&self.powers(place)));
        let rising = Rising { curves: self, place, sign, level: sign * level, resolution };
        let root = rising.crossing(b, self.course.rounding[order])?;
        (root <= self.end).then_some(root * self.course.length)
    }
}

/// A guard: `sign` times a curve, minus `level`.
struct Rising<'a> {
    curves: &'a Curves<'a>,
    place: usize,
    sign: f64,
    level: f64,
    resolution: f64,
}

impl Rising<'_> {
    /// The first crossing on `[0, 1]`. `b` are Bernstein's coefficients of the curve; `rounding` bounds the rounding of
    /// its start.
    fn crossing(mut self, b: &Terms, rounding: f64) -> Option<f64> {
        let Self { sign, resolution, .. } = self;
        let start = sign * b[0] - self.level;
        if start > 0.0 {
            let falls = sign * (b[1] - b[0]) < 0.0;
            let near = if falls { NEAR * resolution } else { AMBIGUOUS * resolution };
            let unknown = if falls { super::FALLING * rounding } else { rounding };
            if start > near.max(unknown) {
                return Some(0.0);
            }
            self.level += start;
        }
        let crossed = self.level + CROSSED * resolution;
        let signs: [f64; HIGH + 1] = from_fn(|i| sign * b[i]);
        let beyond = signs.iter().position(|b| *b >= crossed)?;
        let (below, above) = signs.split_at(beyond);
        let (above, after) = above.split_at(above.iter().take_while(|b| **b >= crossed).count());
        let mut q = self.curves.powers(self.place).map(|c| sign * c);
        // A guard may start at its level, if it falls at first.
        if let Some(last) = below.last().filter(|last| **last < self.level)
            && below[0] <= self.level
            && below[1..].iter().chain(after).all(|b| *b < self.level)
        {
            q[0] = signs[0] - self.level;
            // The guard has one zero, or two, with this point between them.
            let top =
                if after.is_empty() { 1.0 } else { (beyond + highest(above)) as f64 / HIGH as f64 };
            if after.is_empty() || value(&q, top) >= CROSSED * resolution {
                // The line through two coefficients is where the search for it begins.
                let part = (self.level - last) / (above[0] - last);
                let guess = ((beyond - 1) as f64 + part) / HIGH as f64;
                return Some(rise_between(&q, [0.0, top], guess));
            }
        }
        q[0] = signs[0] - crossed;
        let until = first_rise(&q, 0.0)?;
        q[0] = signs[0] - self.level;
        Some(last_zero(&q, until))
    }
}

/// The place of the largest of some numbers.
fn highest(all: &[f64]) -> usize {
    let larger = |best: usize, place: usize| if all[place] > all[best] { place } else { best };
    (1..all.len()).fold(0, larger)
}

/// The last zero before `until` of a guard that is above zero there. It is nearby, unless the guard rises very slowly.
fn last_zero(q: &HighPowers, until: f64) -> f64 {
    let (mut step, mut low) = (LEAST_STEP, until);
    loop {
        let [value, slope] = value_and_slope(q, low);
        if value < 0.0 {
            return rise_between(q, [low, until], until);
        }
        if low == 0.0 {
            return 0.0;
        }
        step = (2.0 * value / slope).max(2.0 * step);
        low = (until - step).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RESOLUTION: f64 = 1e-9;

    /// The first crossing of `lead (t - roots[0]) (t - roots[1]) ...`, as a guard that rises through zero.
    fn crossing(roots: &[f64], lead: f64) -> Option<f64> {
        let mut powers = [0.0; HIGH + 1];
        powers[0] = lead;
        for (count, root) in roots.iter().enumerate() {
            for k in (0..=count + 1).rev() {
                let before = if k > 0 { powers[k - 1] } else { 0.0 };
                powers[k] = before - root * powers[k];
            }
        }
        let course = Course::of_tip(&powers);
        let curves = Curves {
            course: &course,
            bounds: course.bounds(),
            bernstein: Default::default(),
            resolutions: [RESOLUTION; 2],
            end: 1.0,
        };
        let b = of_motion(&powers);
        let rising =
            Rising { curves: &curves, place: 1, sign: 1.0, level: 0.0, resolution: RESOLUTION };
        let found = rising.crossing(&b, 0.0);
        // A crossing is a zero of the guard, or of the guard less its start above zero.
        let off = |t: f64| value(&powers, t) - powers[0].max(0.0);
        assert!(found.is_none_or(|t| t == 0.0 || off(t).abs() < 1e-13), "{found:?}");
        found
    }

    /// The first rise through zero is found: one of several, after a start above zero that falls, or at a double root
    /// that is split by more than the resolution. A guard that grazes zero by less does not cross.
    #[test]
    fn the_first_crossing_is_that_of_the_known_roots() {
        let close = |found: Option<f64>, root: f64| {
            assert!(found.is_some_and(|found| (found - root).abs() < 1e-12), "{found:?} {root}");
        };
        close(crossing(&[0.3, 0.6, 0.9], 1.0), 0.3);
        close(crossing(&[0.4, 1.7], -1.0), 0.4);
        close(crossing(&[0.5, 0.501], -1.0), 0.5);
        close(crossing(&[0.2, 0.4, 0.5, 0.8, 0.95], 3.0), 0.2);
        assert_eq!(crossing(&[1.2, 2.0], -1.0), None);
        // The guard exceeds zero by 2.5e-11 between these roots.
        assert_eq!(crossing(&[0.5, 0.50001], -1.0), None);
        // It starts at zero and falls, then rises at 0.7; or it has crossed from the first.
        close(crossing(&[0.0, 0.7], 1.0), 0.7);
        assert_eq!(crossing(&[-0.5, 0.7], -1.0), Some(0.0));
        assert_eq!(crossing(&[0.0, 0.7], -1.0), Some(0.0));
    }

    /// A guard that starts above zero by less than its resolution and falls is lowered by that, and crosses where it
    /// comes back to its start.
    #[test]
    fn a_start_slightly_above_zero_is_no_crossing() {
        let start = 2e-9;
        // `start - 1e-3 t + 2e-3 t^2` comes back at 0.5.
        let roots = [start / 1e-3, 0.5 - start / 1e-3];
        let found = crossing(&roots, 2e-3).expect("it comes back");
        assert!((found - 0.5).abs() < 1e-5, "{found}");
    }
}
