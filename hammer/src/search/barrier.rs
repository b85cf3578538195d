//! Q3: the instant at which the viscous work of a cycle reaches the energy barrier.
//!
//! `psi(t) = psi_0 + CR int p'^2` never falls, so one value below the barrier at `t` proves
//! that it has not been reached before `t`: steps may be guesses, and nothing is missed.
//! The integral is exact (see [`crate::modal::stretch`]). Under constant loads the viscous form of
//! the state is all of `int p'^2` that can ever follow: where that is too little for the
//! barrier, nothing is evaluated.

use crate::modal::system::System;
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::numerics::kernel;
use crate::search::tracker::Work;

/// A form errs by rounding: 1e-12 of itself at the most.
const SURELY: f64 = 1.0 - 1e-9;
/// Below this part of what the form may come to, a barrier would keep fewer than thirteen of the
/// form's digits.
const LITTLE: f64 = 1e-3;
/// Up to how many radians of the fastest mode the work is then summed from series: a creeping tip
/// may take for ever.
const LONGEST: f64 = 4096.0;
/// First step, radians of the fastest mode, and by how much the next may be longer. Too
/// long a step is no error, but a longer bracket for the root.
const FIRST_STEP: f64 = 8.0;
const GROWTH: f64 = 4.0;
/// How far a step aims beyond where the present power reaches the barrier. Any value is right, for
/// the work is looked at where a step ends; steps are rounded down to powers of two, by a half at
/// the most, so that from 2 on one reaches the barrier unless the power falls, and one that ends short
/// of it would be followed by many that do. The rest is for a power that falls a little.
const BEYOND: f64 = 2.1;
/// A root is as sharp as this part of its first bracket.
const SHARP: f64 = 1e-12;
/// Radians of the fastest mode, below which what four derivatives leave out is below [`SHARP`].
const SHORT_STEP: f64 = 1e-3;
/// Steps to the zero of a cubic that is nearly straight.
const NEWTONS: usize = 5;
/// Halvings of a first guess at a root.
const HALVINGS: usize = 20;

/// The search for the barrier along one track.
#[derive(Clone, Debug)]
pub struct Barrier {
    /// Viscous work still allowed at the track's anchor, J.
    pub room: f64,
    /// `CR`, N s/m.
    pub viscosity: f64,
    /// Not reached before this instant, s.
    pub clear: f64,
    /// Where it is reached, s.
    pub root: Option<f64>,
    cursor: Track,
    step: f64,
    /// The tip's displacement among the system's functionals.
    tip: usize,
    /// Viscous form at the anchor.
    pub form: f64,
    /// Work done where the cursor stands, J.
    done: f64,
    /// True if the work still allowed is so little beside the form, or loads that vary, that
    /// these would cancel.
    fine: bool,
}

impl Barrier {
    /// Starts at the anchor of `track`, instant 0; `steady` if the loads do not vary.
    pub fn new(track: &Track, tip: usize, room: f64, viscosity: f64, steady: bool) -> Self {
        let mut barrier = Self {
            room,
            viscosity,
            clear: 0.0,
            root: None,
            cursor: track.clone(),
            step: FIRST_STEP / track.system.rate_max,
            tip,
            form: 0.0,
            done: 0.0,
            fine: false,
        };
        if room <= 0.0 {
            barrier.root = Some(0.0);
        } else if viscosity == 0.0 {
            barrier.clear = f64::INFINITY;
        } else {
            barrier.form = track.system.viscous_form().of(&track.z);
            barrier.fine = !steady || room < LITTLE * viscosity * barrier.form;
            if steady && viscosity * barrier.form < SURELY * room {
                barrier.clear = f64::INFINITY;
            }
        }
        barrier
    }

    /// True if the work up to where a track stands is summed from series.
    pub(crate) fn sums(&self, track: &Track) -> bool {
        self.fine && track.at * track.system.rate_max <= LONGEST
    }

    fn done(&self, motion: &Motion, track: &Track) -> f64 {
        let stretch = motion.stretch(0, track, track.at);
        if self.sums(track) {
            let Track { at, z, .. } = &self.cursor;
            return self.done + self.viscosity * stretch.tip_square_by_series(self.tip, *at, z);
        }
        self.viscosity * stretch.tip_square(self.tip, self.form)
    }

    /// The power at the dashpot, and its first two rates.
    fn powers(&self, motion: &Motion, track: &Track) -> [f64; 3] {
        let rows = &track.system.functionals[self.tip].rows;
        let drift = motion.poly(0, self.tip).derivative().rates_at(track.at);
        let [v, a, jerk] = std::array::from_fn(|k| drift[k] + kernel::dot(&rows[k + 1], &track.z));
        [v * v, 2.0 * v * a, 2.0 * (a * a + v * jerk)].map(|rate| self.viscosity * rate)
    }

    /// Extends the proof by one step, or finds the instant.
    pub(crate) fn extend(&mut self, motion: &Motion, work: &mut Work) {
        let left = self.room - self.done;
        let guess = BEYOND * left / self.powers(motion, &self.cursor)[0];
        let span = guess.min(self.step).max(0.0);
        let (_, length) = System::level_below(span).unwrap_or((0, System::shortest()));
        let mut ahead = self.cursor.clone();
        work.samples += ahead.rotate_to(self.cursor.at + length);
        work.evaluations += 1;
        let done = self.done(motion, &ahead);
        if done < self.room {
            (self.clear, self.done) = (ahead.at, done);
            self.cursor = ahead;
            self.step = GROWTH * length;
            return;
        }
        let end = [done, self.powers(motion, &ahead)[0]];
        self.root = Some(self.root(motion, length, end, work));
    }

    /// The root of the rising `psi`: from where the last guess is by the first three derivatives
    /// there, which cost little beside `psi` itself; kept in its bracket by bisection. `end` is
    /// work and power where the bracket ends.
    fn root(&self, motion: &Motion, span: f64, end: [f64; 2], work: &mut Work) -> f64 {
        let (mut low, mut high) = (0.0, span);
        let start = [self.done, self.powers(motion, &self.cursor)[0]];
        let mut x =
            span * reached([start, end].map(|[done, power]| [done - self.room, span * power]));
        let sharp = SHARP * span;
        for _ in 0..100 {
            let mut at = self.cursor.clone();
            work.samples += at.rotate_to(self.cursor.at + x);
            work.evaluations += 1;
            let excess = self.done(motion, &at) - self.room;
            if excess > 0.0 {
                high = x
            } else {
                low = x
            }
            let steps = steps(excess, self.powers(motion, &at));
            let inside = steps.map(|step| x + step).into_iter().rfind(|&x| low < x && x < high);
            let next = inside.unwrap_or(0.5 * (low + high));
            // Where the third derivative no longer tells, neither does the fourth, if the step is
            // short: where the tip has just begun to move the power changes much over itself.
            let is_short = (next - x).abs() * at.system.rate_max <= SHORT_STEP;
            let is_sure = (steps[2] - steps[1]).abs() <= sharp && inside == Some(x + steps[2]);
            if is_short && is_sure || (next - x).abs() <= sharp {
                return self.cursor.at + next;
            }
            x = next;
        }
        self.cursor.at + x
    }
}

/// Where a function of this value and these first three derivatives is zero: by one of them, by two
/// and by all three.
fn steps(value: f64, [first, second, third]: [f64; 3]) -> [f64; 3] {
    let newton = -value / first;
    let refined = |third: f64| {
        (0..NEWTONS).fold(newton, |s, _| {
            let rest = value + s * (first + s * (0.5 * second + s * third / 6.0));
            s - rest / (first + s * (second + 0.5 * s * third))
        })
    };
    [newton, refined(0.0), refined(third)]
}

/// Where on `[0, 1]` the cubic of these values and slopes at its ends, below zero at 0 and not at
/// 1, crosses zero.
fn reached([[a, p], [b, q]]: [[f64; 2]; 2]) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // Newton's method takes over from here: it squares the error.
    for _ in 0..HALVINGS {
        let x = 0.5 * (low + high);
        let y = 1.0 - x;
        let value = y * y * (a * (1.0 + 2.0 * x) + p * x) + x * x * (b * (1.0 + 2.0 * y) - q * y);
        if value < 0.0 { low = x } else { high = x }
    }
    0.5 * (low + high)
}
