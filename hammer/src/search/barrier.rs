//! The search for Q3, the instant at which the viscous work of a drilling cycle reaches the energy barrier.
//!
//! `psi(t) = psi_0 + CR int p'^2` never falls, so a single value below the barrier at `t` proves that the barrier was
//! not reached before `t`. Steps may therefore be guesses, and a single value at the end of the searched time may
//! replace all of them. For this reason the guards are searched first. If an event comes soon, only the work up to that
//! event is needed, and the ledger needs it anyway. The integral is exact (see [`crate::modal::stretch`]). Under
//! constant loads the viscous form of the state bounds the remaining `int p'^2`. If this bound is too low to reach the
//! barrier, nothing is evaluated.

use crate::laws::event::Displacement;
use crate::modal::stretch::{LITTLE, Stretch};
use crate::modal::system::generator::Generator;
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::numerics::bernstein::rise_between;
use crate::numerics::bracket::{PASSES, admits};
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::numerics::series::value;
use crate::search::tracker::Work;
use std::cell::OnceCell;

/// Safety factor for the rounding of a form, which is at most 1e-12 of the form.
const SURELY: f64 = 1.0 - 1e-9;
/// Where the closed form would cancel, a sum of series replaces it, but only over this many radians of the fastest
/// mode, because a creeping tip may never reach the barrier.
const LONGEST: f64 = 4096.0;
/// First step, in radians of the fastest mode, and the largest factor from one step to the next. A step that is too
/// long is harmless: it only widens the bracket of the root.
const FIRST_STEP: f64 = 8.0;
const GROWTH: f64 = 4.0;
/// A step is this many times as long as the time in which the present power would reach the barrier. Any value is
/// correct. Steps are rounded down to powers of two, which at most halves them. With a value of 2 a step therefore
/// reaches the barrier unless the power falls; the excess over 2 allows for a small fall.
const BEYOND: f64 = 2.1;
/// Allowed error of a root, relative to its first bracket.
const SHARP: f64 = 1e-12;
/// Up to this many radians of the fastest mode, the error of a series of four derivatives is below [`SHARP`].
const SHORT_STEP: f64 = 1e-3;
/// Number of Newton steps to the zero of a nearly straight cubic.
const NEWTONS: usize = 5;
/// Number of bisections before Newton's method.
const HALVINGS: usize = 20;

/// The value of a form costs one evaluation for this many coordinates.
const FORM: u64 = 16;

/// The search for the barrier along one track.
#[derive(Clone, Debug, Default)]
pub struct Barrier {
    /// Viscous work still allowed at the track's anchor, J.
    pub room: f64,
    /// `CR`, N s/m.
    pub viscosity: f64,
    /// The barrier is not reached before this instant, s.
    pub clear: f64,
    /// The instant at which the barrier is reached, s, if it is known.
    pub root: Option<f64>,
    /// The track where the next step begins. At first this is the anchor, which is copied only when it is needed.
    cursor: OnceCell<Track>,
    step: f64,
    /// Functional of the tip's displacement.
    tip: usize,
    /// Rate of the polynomial part of the tip's displacement.
    drift: Poly,
    /// Value of the viscous form at the anchor.
    pub form: f64,
    /// Viscous work up to the cursor's instant, J.
    done: f64,
    /// True if differences of forms would cancel because the work still allowed is small compared with them, or if they
    /// might cancel under varying loads.
    cancels: bool,
    /// True if no load that acts on the tip's group varies.
    is_calm: bool,
    /// Up to this instant the search waits for the guards' proofs, because a single value at their end may replace many
    /// steps. The instant is 0 if the search has waited already, or if a form costs next to nothing. It is infinite
    /// under varying loads, where a value is expensive.
    pub waits: f64,
    /// The instant of the event that ends the mode, and the viscous work up to it (J), if the proof has computed it.
    pub ended: Option<[f64; 2]>,
}

impl Barrier {
    /// The search from the epoch on; `None` if nothing in the motion is at the rock.
    pub fn start(motion: &Motion) -> Option<Self> {
        let rock = &motion.parameters().rock;
        let room = rock.energy_barrier - motion.state.psi;
        if let Some(course) = motion.course() {
            let mut overrun = course.bit_square().map(|c| rock.viscosity * c);
            overrun[0] = -room;
            return Some(Self::rising(&overrun, course.length, motion.reach()));
        }
        let tip = motion.share(0, Displacement::Tip)?;
        Some(Self::new(motion, tip, room, rock.viscosity))
    }

    /// The search in a rigid hammer's window, up to `reach`. The work beyond the barrier is a polynomial of the time over
    /// the window's length, and never falls.
    fn rising(overrun: &[f64], length: f64, reach: f64) -> Self {
        let (mut barrier, end) = (Self { room: -overrun[0], ..Self::default() }, reach / length);
        if overrun[0] >= 0.0 {
            barrier.root = Some(0.0);
        } else if value(overrun, end) < 0.0 {
            barrier.clear = f64::INFINITY;
        } else {
            barrier.root = Some(rise_between(overrun, [0.0, end], end) * length);
        }
        barrier
    }

    /// A search that starts at the anchor of the tip's track, at the instant 0.
    pub fn new(motion: &Motion, tip: usize, room: f64, viscosity: f64) -> Self {
        let (track, is_calm) = (&motion.tracks[0], motion.is_calm(0));
        let step = FIRST_STEP / track.system.rate_max;
        let mut barrier = Self { room, viscosity, step, tip, is_calm, ..Self::default() };
        if room <= 0.0 {
            barrier.root = Some(0.0);
        } else if viscosity == 0.0 {
            barrier.clear = f64::INFINITY;
        } else {
            barrier.drift = motion.poly(0, tip).derivative();
            barrier.form = track.system.viscous_form().of(&track.z);
            let is_expensive = track.z.len() as u64 > FORM;
            let soon = if is_expensive { GROWTH * barrier.step } else { 0.0 };
            barrier.waits = if is_calm { soon } else { f64::INFINITY };
            barrier.cancels = !is_calm || room < LITTLE * viscosity * barrier.form;
            if is_calm && viscosity * barrier.form < SURELY * room {
                (barrier.clear, barrier.waits) = (f64::INFINITY, 0.0);
            }
        }
        barrier
    }

    /// True if the work up to the track's instant is summed from series. Under varying loads this is done only near the
    /// start, where the closed form would cancel.
    pub(crate) fn sums(&self, track: &Track) -> bool {
        self.cancels && track.at * track.system.rate_max <= LONGEST
    }

    fn cursor(&self, motion: &Motion) -> &Track {
        self.cursor.get_or_init(|| motion.at_anchor(0))
    }

    /// The viscous work up to the track's instant, J.
    fn done(&self, motion: &Motion, track: &Track, work: &mut Work) -> f64 {
        let stretch = motion.stretch(0, track, track.at);
        work.barrier += track.z.len() as u64 / FORM;
        let closed = || stretch.tip_square_uncancelled(self.tip, &self.drift, self.form);
        if self.sums(track) {
            if let Some(closed) = (!self.is_calm).then(closed).flatten() {
                return self.viscosity * closed;
            }
            let Track { at, z, system } = self.cursor(motion);
            work.count_panels(Stretch::panels(system, track.at - at));
            let increase = stretch.tip_square_by_series(self.tip, &self.drift, *at, z);
            return self.done + self.viscosity * increase;
        }
        self.viscosity * stretch.tip_square(self.tip, &self.drift, self.form)
    }

    /// The power of the dashpot at the tip, and its first two rates.
    fn powers(&self, track: &Track) -> [f64; 3] {
        let rows = &track.system.functionals[self.tip].rows;
        let drift: [f64; 3] = self.drift.derivatives_at(track.at);
        let [v, a, jerk] = std::array::from_fn(|k| drift[k] + kernel::dot(&rows[k + 1], &track.z));
        [v * v, 2.0 * v * a, 2.0 * (a * a + v * jerk)].map(|rate| self.viscosity * rate)
    }

    /// Extends the proof by one step, or locates the instant. If all guards are proved up to `end`, a single value
    /// there may be enough. It is computed on the tip's track if that is already at `end`. A step always begins where
    /// the previous step ended, never at such an `end`, so that the result does not depend on the values of `end`.
    pub(crate) fn extend(&mut self, motion: &Motion, end: Option<f64>, work: &mut Work) {
        let waited = std::mem::take(&mut self.waits) > 0.0;
        if let Some(end) = end.filter(|_| waited)
            && self.is_clear_until(end, motion, work)
        {
            self.clear = end.next_up();
            return;
        }
        let remaining = self.room - self.done;
        let cursor = self.cursor(motion);
        let guess = BEYOND * remaining / self.powers(cursor)[0];
        let span = guess.min(self.step).max(0.0);
        let (_, length) = Generator::level_below(span).unwrap_or((0, Generator::length(0)));
        let mut ahead = cursor.clone();
        work.samples += ahead.rotate_to(cursor.at + length);
        work.evaluations += 1;
        let done = self.done(motion, &ahead, work);
        if done < self.room {
            (self.clear, self.done) = (self.clear.max(ahead.at), done);
            self.cursor = ahead.into();
            self.step = GROWTH * length;
            return;
        }
        let end = [done, self.powers(&ahead)[0]];
        self.root = Some(self.root(motion, length, end, work));
    }

    /// True if a single value at `end` shows that the barrier was not reached before `end`.
    fn is_clear_until(&mut self, end: f64, motion: &Motion, work: &mut Work) -> bool {
        let tip = &motion.tracks[0];
        if tip.at == end {
            if self.is_below(motion, tip) {
                return true;
            }
            let done = self.done(motion, tip, work);
            self.ended = Some([end, done]).filter(|_| !self.sums(tip));
            return done < SURELY * self.room;
        }
        let mut ahead = self.cursor(motion).clone();
        if end <= ahead.at + self.step {
            return false;
        }
        work.samples += ahead.rotate_to(end);
        work.evaluations += 1;
        self.is_below(motion, &ahead) || self.done(motion, &ahead, work) < SURELY * self.room
    }

    /// True if the closed form of the work up to the track's instant is below the barrier with all of its rounding: then
    /// no series is needed where it cancels.
    fn is_below(&self, motion: &Motion, track: &Track) -> bool {
        if self.is_calm || !self.sums(track) {
            return false;
        }
        let stretch = motion.stretch(0, track, track.at);
        let [square, size] = stretch.tip_square_and_size(self.tip, &self.drift, self.form);
        self.viscosity * (square + (1.0 - SURELY) * size) < SURELY * self.room
    }

    /// The instant at which the rising `psi` reaches the barrier, by Newton's method within a bracket that bisection
    /// narrows. The method uses three derivatives, which cost little compared with `psi` itself. `end` is the work and
    /// the power at the end of the bracket.
    fn root(&self, motion: &Motion, span: f64, end: [f64; 2], work: &mut Work) -> f64 {
        let cursor = self.cursor(motion);
        let start = [self.done, self.powers(cursor)[0]];
        let x = span * reached([start, end].map(|[done, power]| [done - self.room, span * power]));
        let overrun = |x: f64| {
            let mut track = cursor.clone();
            work.samples += track.rotate_to(cursor.at + x);
            work.evaluations += 1;
            (self.done(motion, &track, work) - self.room, self.powers(&track))
        };
        cursor.at + zero(overrun, x, [span, cursor.system.rate_max])
    }
}

/// The zero between 0 and `span` of a rising function that returns its value and three derivatives. `rate` bounds its
/// radians per unit. The iteration ends where a bracket of the resolution [`SHARP`] contains the zero, or at the end of a
/// step whose series has no error of that size.
fn zero(
    mut function: impl FnMut(f64) -> (f64, [f64; 3]),
    mut x: f64,
    [span, rate]: [f64; 2],
) -> f64 {
    let (mut low, mut high, tolerance) = (0.0, span, SHARP * span);
    for pass in 0..PASSES {
        let (value, derivatives) = function(x);
        if value > 0.0 {
            high = x
        } else {
            low = x
        }
        let steps = steps(value, derivatives);
        let ends = steps.map(|step| x + step);
        let inside = ends.into_iter().rfind(|&end| admits(pass, [low, high], end));
        let next = inside.unwrap_or(0.5 * (low + high));
        let length = (next - x).abs();
        // If the third derivative changes nothing and the step is short, the fourth changes nothing either. (Just after
        // the tip starts to move, the power may change by a large share of itself.)
        let is_short = length * rate <= SHORT_STEP;
        let is_sure = (steps[2] - steps[1]).abs() <= tolerance && inside == Some(ends[2]);
        // A halved bracket proves its zero. Newton's step alone proves none where the cubic has none nearby.
        let is_proved = inside.is_none() || steps[2].abs() <= tolerance;
        if is_short && is_sure || length <= tolerance && is_proved {
            return next;
        }
        x = next;
    }
    x
}

/// Steps to the zero of a function, computed with one, two and three of its derivatives: the methods of Newton, Halley
/// and Householder. A step is NaN if its parabola or cubic has no zero nearby, as between two pushes of a tip that almost
/// stands: the iteration for it then rests beside no zero, with all of the value left. Where there is a zero, only rounding
/// is left, so that any share between the two tells them apart.
fn steps(value: f64, [first, second, third]: [f64; 3]) -> [f64; 3] {
    let newton = -value / first;
    let refined = |third: f64| {
        let rest = |s: f64| value + s * (first + s * (0.5 * second + s * third / 6.0));
        let slope = |s: f64| first + s * (second + 0.5 * s * third);
        let step = (0..NEWTONS).fold(newton, |s, _| s - rest(s) / slope(s));
        if rest(step).abs() <= 0.5 * value.abs() { step } else { f64::NAN }
    };
    [newton, refined(0.0), refined(third)]
}

/// The zero on `[0, 1]` of the cubic with these values and slopes at 0 and 1. It is negative at 0, and not at 1.
fn reached([[a, p], [b, q]]: [[f64; 2]; 2]) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // This is only the starting value for Newton's method, which converges quadratically.
    for _ in 0..HALVINGS {
        let x = 0.5 * (low + high);
        let y = 1.0 - x;
        let value = y * y * (a * (1.0 + 2.0 * x) + p * x) + x * x * (b * (1.0 + 2.0 * y) - q * y);
        if value < 0.0 { low = x } else { high = x }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps from 0 to the zero `r` of `(x - r) (1 + b x + c x^2)`. Each further derivative raises the order of the
    /// error in `r` by one.
    #[test]
    fn each_derivative_brings_the_step_nearer_to_the_zero() {
        let (b, c) = (0.4, 0.3);
        for r in [1e-2, -1e-2, 1e-3] {
            let derivatives = [1.0 - b * r, 2.0 * (b - c * r), 6.0 * c];
            let errors = steps(-r, derivatives).map(|step| (step - r).abs());
            let sizes = [b * r * r, c * r * r * r].map(f64::abs);
            assert!((errors[0] / sizes[0] - 1.0).abs() < 0.05, "{r}: {errors:?}");
            assert!((errors[1] / sizes[1] - 1.0).abs() < 0.05, "{r}: {errors:?}");
            assert!(errors[2] <= 4.0 * f64::EPSILON * r.abs(), "{r}: {errors:?}");
        }
    }

    /// The value and derivatives at which a search once rested, 62 mJ beyond the barrier: their cubic has no zero nearby.
    #[test]
    fn a_cubic_without_a_zero_nearby_gives_no_step() {
        let steps = steps(0.062, [2185.0, 1.0e6, -8.0e12]);
        assert!(steps[0] < 0.0 && steps[2].is_nan(), "{steps:?}");
    }

    /// The functions are `(x - r)^n`, the work of a tip that all but stands for long: each step then takes only a share of
    /// the way, with `n = 21` one of 0.08, so that a hundred steps leave `3e-4` of it. The zero is found to the resolution
    /// even so, and a simple one within a few steps.
    #[test]
    fn a_zero_that_no_step_reaches_is_found_by_halving() {
        for (n, r) in [(1, 0.3), (3, 0.3), (5, 0.77), (7, 0.62), (21, 0.3), (21, 0.999)] {
            let (span, order, mut passes) = (2.0, f64::from(n), 0);
            let function = |x: f64| {
                passes += 1;
                let e = x - span * r;
                let power = |k: i32| if k < 0 { 0.0 } else { e.powi(k) };
                let (second, third) =
                    (order * (order - 1.0), order * (order - 1.0) * (order - 2.0));
                (power(n), [order * power(n - 1), second * power(n - 2), third * power(n - 3)])
            };
            let found = zero(function, 0.9 * span, [span, 1.0]);
            assert!((found - span * r).abs() <= 2.0 * SHARP * span, "{n}: {found} after {passes}");
            assert!(passes < if n == 1 { 5 } else { PASSES }, "{n}: {passes}");
        }
    }

    /// The cubic is `(x - r) (x^2 + b)`, given by its values and slopes at 0 and 1.
    #[test]
    fn the_cubic_of_two_values_and_slopes_is_followed_to_its_zero() {
        for (r, b) in [(0.1, 0.5), (0.5, 2.0), (0.93, 0.2)] {
            let ends = [[-r * b, b], [(1.0 - r) * (1.0 + b), 1.0 + b + 2.0 * (1.0 - r)]];
            let zero = reached(ends);
            assert!((zero - r).abs() <= 0.5f64.powi(HALVINGS as i32), "{zero} {r}");
        }
    }
}
