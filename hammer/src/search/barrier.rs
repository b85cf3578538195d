//! Q3: the instant at which the viscous work of a cycle reaches the energy barrier.
//!
//! `psi(t) = psi_0 + CR int p'^2` never falls, so one value below the barrier at `t` proves
//! that it has not been reached before `t`: strides may be guesses, and nothing is missed.
//! The integral is exact (see [`crate::modal::stretch`]). Under constant loads the viscous form of
//! the state is all of `int p'^2` that can ever follow: where that is too little for the
//! barrier, nothing is evaluated.

use crate::modal::system::System;
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::numerics::kernel;
use crate::search::watch::Work;

/// A form errs by rounding: 1e-12 of itself at the most.
const SURELY: f64 = 1.0 - 1e-9;
/// Below this part of what the form may come to, a barrier would keep fewer than thirteen of the
/// form's digits.
const LITTLE: f64 = 1e-3;
/// Up to how many radians of the fastest mode the work is then summed from series: a creeping tip
/// may take for ever.
const LONGEST: f64 = 4096.0;
/// First stride, radians of the fastest mode, and by how much the next may be longer. Too
/// long a stride is no error, but a longer bracket for the root.
const FIRST_STRIDE: f64 = 8.0;
const GROWTH: f64 = 4.0;
/// How far a stride aims beyond where the present power reaches the barrier. Any value is right, for
/// the work is looked at where a stride ends; strides are rounded down to powers of two, by a half at
/// the most, so that from 2 on one reaches the barrier unless the power falls, and one that ends short
/// of it would be followed by many that do. The rest is for a power that falls a little.
const BEYOND: f64 = 2.1;
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
    pub found: Option<f64>,
    cursor: Track,
    stride: f64,
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
            found: None,
            cursor: track.clone(),
            stride: FIRST_STRIDE / track.system.rate_max,
            tip,
            form: 0.0,
            done: 0.0,
            fine: false,
        };
        if room <= 0.0 {
            barrier.found = Some(0.0);
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

    fn power(&self, motion: &Motion, track: &Track) -> f64 {
        let row = &track.system.functionals[self.tip].rows[1];
        let [_, drift, _] = motion.poly(0, self.tip).rates_at(track.at);
        let v = kernel::dot(row, &track.z) + drift;
        self.viscosity * v * v
    }

    /// Extends the proof by one stride, or finds the instant.
    pub(crate) fn extend(&mut self, motion: &Motion, work: &mut Work) {
        let left = self.room - self.done;
        let guess = BEYOND * left / self.power(motion, &self.cursor);
        let span = guess.min(self.stride).max(0.0);
        let (_, length) = System::level_below(span).unwrap_or((0, System::shortest()));
        let mut ahead = self.cursor.clone();
        work.samples += ahead.rotate_to(self.cursor.at + length);
        work.evaluations += 1;
        let done = self.done(motion, &ahead);
        if done < self.room {
            (self.clear, self.done) = (ahead.at, done);
            self.cursor = ahead;
            self.stride = GROWTH * length;
            return;
        }
        let end = [done, self.power(motion, &ahead)];
        self.found = Some(self.root(motion, length, end, work));
    }

    /// Newton on the rising `psi`, kept in its bracket by bisection; `end` is work and power
    /// where the bracket ends.
    fn root(&self, motion: &Motion, span: f64, end: [f64; 2], work: &mut Work) -> f64 {
        let (mut low, mut high) = (0.0, span);
        let start = [self.done, self.power(motion, &self.cursor)];
        let mut x =
            span * reached([start, end].map(|[done, power]| [done - self.room, span * power]));
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
            let newton = x - excess / self.power(motion, &at);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            // Newton squares the error, times how fast the power changes over itself: where the tip
            // has just begun to move that is much, so the last step is to be short indeed.
            if (next - x).abs() <= 1e-12 * span {
                return self.cursor.at + next;
            }
            x = next;
        }
        self.cursor.at + x
    }
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
