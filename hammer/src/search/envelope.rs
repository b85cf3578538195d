//! Bounds on a displacement within one window of the air.
//!
//! The polynomial part of the displacement is valid until the window ends, and amplitudes bound the oscillating rest.
//! So one polynomial shows when each guard on the displacement could cross. Most guards cannot cross within the window.
//! The search for the others begins shortly before they cross.

use super::signal::{Part, Signal};
use super::tracker::NEAR;
use crate::laws::event::{Displacement, Guard};
use crate::motion::Motion;
use crate::numerics::bernstein::{first_rise, rise_between};
use crate::numerics::kernel;
use crate::numerics::poly::{Poly, TERMS};
use crate::numerics::series::value_and_slope;

/// Number of roundings that the bounds allow for, far more than actually occur.
const ROUNDINGS: f64 = 4096.0;

/// A displacement or its rate, until the motion's polynomials end.
#[derive(Debug)]
pub(super) struct Envelope {
    /// The displacement, and the order of its derivative.
    guarded: (Displacement, usize),
    /// Its oscillating parts.
    parts: [Option<Part>; 2],
    /// The polynomial part, and the constant offset of the displacement.
    poly: Poly,
    ahead: f64,
    /// Coefficients of `poly` in time over the window, and their number.
    scaled: [f64; TERMS],
    count: usize,
    /// Bound on the oscillating parts, and on the rounding of all terms.
    amplitude: f64,
    rounding: f64,
    /// Least and largest value of the polynomial part.
    range: [f64; 2],
}

impl Envelope {
    /// `None` if nothing in the displacement varies. It is also `None` outside the windows of air, since loads that a
    /// host sets often remain valid much longer than they are used.
    pub fn new(motion: &Motion, guard: &Guard, reach: f64, others: &[Self]) -> Option<Self> {
        let Guard { displacement, order, .. } = *guard;
        if motion.air().is_none() || !reach.is_finite() {
            return None;
        }
        let mut parts = [None; 2];
        for (part, (track, functional)) in parts.iter_mut().zip(motion.shares(displacement)) {
            *part = Some(Part { track, functional, factor: 1.0 });
        }
        let same = others.iter().find(|other| other.guarded == (displacement, 0));
        let (mut poly, mut amplitude) = (same.map_or(Poly::default(), |same| same.poly), 0.0);
        for Part { track, functional, .. } in parts.into_iter().flatten() {
            if same.is_none() {
                match motion.noted(track, functional) {
                    Some(part) => poly.add(1.0, part),
                    None => poly.add(1.0, &motion.poly(track, functional)),
                }
            }
            let track = &motion.tracks[track];
            let functional = &track.system.functionals[functional];
            if !functional.still {
                amplitude += kernel::bound(&functional.weights[order], &track.z);
            }
        }
        let moves = |part: &Part| {
            let system = &motion.tracks[part.track].system;
            !system.functionals[part.functional].still
        };
        let [one, other] = parts.map(|part| part.filter(moves));
        let parts = [one.or(other), one.and(other)];
        let ahead = if order == 0 { motion.ahead(displacement) } else { 0.0 };
        let mut each = parts.iter().flatten();
        if same.is_none() && poly.degree() <= 2 && each.all(|part| motion.is_calm(part.track)) {
            return None;
        }
        let poly = if order == 1 { poly.derivative() } else { poly };
        Some(Self::over((displacement, order), (poly, parts), [ahead, amplitude], reach))
    }

    fn over(
        guarded: (Displacement, usize),
        (poly, parts): (Poly, [Option<Part>; 2]),
        [ahead, amplitude]: [f64; 2],
        reach: f64,
    ) -> Self {
        let (count, mut scaled) = (poly.degree() + 1, poly.0);
        let (mut range, mut size, mut power) = ([scaled[0]; 2], scaled[0].abs(), 1.0);
        for c in &mut scaled[1..count] {
            power *= reach;
            *c *= power;
            range = [range[0] + c.min(0.0), range[1] + c.max(0.0)];
            size += c.abs();
        }
        let rounding = ROUNDINGS * f64::EPSILON * (size + amplitude);
        Self { guarded, parts, poly, ahead, scaled, count, amplitude, rounding, range }
    }

    /// True if this envelope bounds the displacement, or the velocity, that the guard watches.
    pub fn is_of(&self, guard: &Guard) -> bool {
        self.guarded == (guard.displacement, guard.order)
    }

    /// The interval in which a guard cannot cross. To cross means to exceed its level by `resolution`. The interval has
    /// no end if the guard cannot cross before `reach`.
    pub fn clear(&self, guard: &Guard, resolution: f64, reach: f64) -> [f64; 2] {
        let (sign, level) = (guard.direction.sign(), guard.level - self.ahead);
        let margin = self.amplitude + self.rounding + NEAR * resolution;
        let most = if sign > 0.0 { self.range[1] } else { -self.range[0] };
        if most - sign * level + margin < 0.0 {
            return [0.0, f64::INFINITY];
        }
        let mut q = self.scaled.map(|c| sign * c);
        q[0] += margin - sign * level;
        let q = &mut q[..self.count];
        let mut from = 0.0;
        if q[0] >= 0.0 {
            q.iter_mut().for_each(|c| *c = -*c);
            let Some(fallen) = first_rise(q, 0.0) else { return [0.0; 2] };
            q.iter_mut().for_each(|c| *c = -*c);
            from = fallen + (1.0 - fallen) * f64::EPSILON.sqrt();
        }
        let to = first_rise(q, from).map_or(f64::INFINITY, |root| root * reach);
        [from * reach, to]
    }

    /// The guard as a function of time.
    pub fn signal(&self, guard: &Guard, resolution: f64) -> Signal {
        let factor = guard.direction.sign();
        let mut poly = self.poly;
        poly.0.iter_mut().for_each(|c| *c *= factor);
        poly.0[0] -= factor * (guard.level - self.ahead);
        let parts = self.parts.map(|part| part.map(|part| Part { factor, ..part }));
        Signal::new(poly, parts, self.guarded.1, resolution)
    }

    /// The time at which a guard without oscillating parts crosses. The guard cannot cross before `clear`, and rises
    /// beyond the resolution afterwards.
    pub fn crossing(
        &self,
        guard: &Guard,
        resolution: f64,
        [clear, reach]: [f64; 2],
    ) -> Option<f64> {
        if self.amplitude != 0.0 || clear >= reach {
            return None;
        }
        let sign = guard.direction.sign();
        let mut q = self.scaled.map(|c| sign * c);
        q[0] -= sign * (guard.level - self.ahead);
        let q = &q[..self.count];
        let start = clear / reach;
        let [value, slope] = value_and_slope(q, start);
        // At twice the distance that the present slope predicts, the guard is far above its level.
        let beyond = start - 2.0 * value / slope;
        let rises = value < 0.0 && slope > 0.0 && beyond <= 1.0;
        let above = || value_and_slope(q, beyond)[0] > NEAR * resolution;
        (rises && above()).then(|| rise_between(q, [start, beyond], start - value / slope) * reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::event::{Direction, Event};

    const REACH: f64 = 2e-4;
    const RESOLUTION: f64 = 1e-12;

    /// `(t - 0.2) (t - 0.5) (t - 0.9)` mm, with `t` over the window's length.
    fn envelope(amplitude: f64) -> Envelope {
        let powers = [-0.09e-3, 0.73e-3, -1.6e-3, 1e-3];
        let guarded = (Displacement::Relative, 0);
        Envelope::over(guarded, (Poly::of_part(&powers, REACH), [None; 2]), [0.0, amplitude], REACH)
    }

    fn guard(direction: Direction, level: f64) -> Guard {
        let (displacement, order, event) = (Displacement::Relative, 0, Event::OPENING);
        Guard { displacement, order, direction, level, event }
    }

    /// Within the interval the guard plus its amplitude stays below the level. At both ends it is above the level or
    /// close to it, so the interval is not shorter than necessary.
    #[test]
    fn a_guard_is_below_its_level_between_the_times_and_not_beyond() {
        for amplitude in [0.0, 5e-6, 3e-5] {
            let envelope = envelope(amplitude);
            for direction in [Direction::Rising, Direction::Falling] {
                for step in -12..=12 {
                    let level = f64::from(step) * 1e-5;
                    let guard = guard(direction, level);
                    let [from, to] = envelope.clear(&guard, RESOLUTION, REACH);
                    let most =
                        |t: f64| direction.sign() * (envelope.poly.at(t) - level) + amplitude;
                    let samples = (0..=2000).map(|i| f64::from(i) * REACH / 2000.0);
                    for t in samples.filter(|t| (from..to).contains(t)) {
                        assert!(most(t) < 0.0, "{amplitude} {direction:?} {level} {t}");
                    }
                    // A margin of four resolutions and the rounding, over a slope of at least 1e-4 of the scale.
                    let near = 1e-4 * 1e-3;
                    assert!(to == 0.0 || to == f64::INFINITY || most(to) > -near);
                    assert!(from == 0.0 || most(from) > -near, "{from}");
                    assert!(to > 0.0 || most(0.0) > -near && most(REACH) > -near);
                }
            }
        }
    }

    /// The crossings of a guard in which nothing oscillates are the polynomial's roots.
    #[test]
    fn a_crossing_is_the_polynomial_s_root() {
        let envelope = envelope(0.0);
        for (direction, root) in [(Direction::Rising, 0.2), (Direction::Falling, 0.5)] {
            let guard = guard(direction, 0.0);
            let [_, clear] = envelope.clear(&guard, RESOLUTION, REACH);
            let found = envelope.crossing(&guard, RESOLUTION, [clear, REACH]).expect("a root");
            assert!((found / REACH - root).abs() < 1e-12, "{found}");
        }
        let oscillates = self::envelope(1e-6);
        assert_eq!(
            oscillates.crossing(&guard(Direction::Rising, 0.0), RESOLUTION, [0.0, REACH]),
            None
        );
    }
}
