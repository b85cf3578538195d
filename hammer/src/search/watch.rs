//! The first crossing of a guard, for certain.
//!
//! # What is proved
//! A guard is `g(t) = poly(t) + sum c . z(t)` over one or two modal tracks; it crosses by
//! rising through zero. With its resolution `r`:
//!
//! * where a guard is *clear* until `t`, a bound proves `g < r` up to `t`;
//! * where a *crossing* is reported at `t`, `g` reaches `7 r / 8` no earlier than `t`, and
//!   `t` is the zero of `g` before that (or the instant from which `g` was watched, if it
//!   lay between 0 and `r` already);
//! * an excursion that comes within `4 r` of zero and turns back is neither missed nor
//!   taken: it is counted as *undecided*.
//!
//! # Why
//! From values at one instant the future of a guard is bounded in three ways, cheapest first.
//! 1. *Amplitude.* `|exp(B t) z|` never grows, so `poly(t) + sum |c| |z|` bounds `g` for
//!    all later `t`; no rotation is needed to know it.
//!    Where the slowest decay outweighs all other amplitudes, it does so until it has fallen to
//!    them: a creeping tip is decided so.
//! 2. *Curvature.* `g(t + s) <= g + g' s + M s^2 / 2` with `M = sum |c| |B|^2 |z|`. The
//!    largest `s` that keeps this below `r` is a stride: Newton's method from below, which
//!    cannot step over the first root.
//! 3. *Taylor window.* Where amplitudes cancel, absolute bounds crawl. Then `g` is expanded
//!    to order [`TAYLOR`], with a remainder below `r / 8` over a window as long as that
//!    allows, and the same march is made on the polynomial.
//!
//! Strides end on dyadic instants relative to the present one, so that a stride is one
//! tabulated rotation.

use crate::modal::system::{System, TAYLOR};
use crate::modal::track::Track;
use crate::numerics::kernel;
use crate::search::signal::{Drift, Probe, Signal};
use crate::search::window::{
    PART, back_up, horner, low_point, rounding, shortened, stride_below, zero_between,
};

/// Work done by a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Evaluations of a guard or its bounds.
    pub evaluations: u64,
    /// Rotations of a track.
    pub samples: u64,
    /// Taylor windows opened.
    pub windows: u64,
}

/// A guard being watched.
#[derive(Clone, Debug)]
pub struct Watch {
    /// The guard.
    pub signal: Signal,
    /// Proved not to cross before this instant, s.
    pub clear: f64,
    /// The crossing, s.
    pub found: Option<f64>,
    /// Times it came near and turned back.
    pub undecided: u64,
    armed: bool,
    near: bool,
    /// True once its amplitude has been looked at.
    known: bool,
    ahead: Ahead,
}

/// What a watch knows ahead of its proof, and how far it may look.
#[derive(Clone, Debug)]
struct Ahead {
    /// The tracks may be moved up to this instant, s.
    limit: f64,
    /// What is seen at `clear`, if that is known already.
    seen: Option<Probe>,
    /// Room for a modal vector.
    spare: Vec<f64>,
}

/// Below this part of a radian, a stride by curvature is worth less than a window.
const SHORT_STRIDE: f64 = 0.12;
/// In radians, what a bound on the curvature hardly gives: a stride on which a decay outweighs
/// all else is taken if it is longer.
const LONG_STRIDE: f64 = 2.0;
/// A guard this many resolutions from zero is near it.
const NEAR: f64 = 4.0;

impl Watch {
    /// Starts to watch at `t`.
    pub fn new(signal: Signal, t: f64) -> Self {
        let ahead = Ahead { limit: f64::INFINITY, seen: None, spare: Vec::new() };
        Self {
            signal,
            clear: t,
            found: None,
            undecided: 0,
            armed: false,
            near: false,
            known: false,
            ahead,
        }
    }

    /// May move the tracks up to `limit` only: others are not known beyond.
    pub(crate) fn limit(&mut self, limit: f64) {
        self.ahead.limit = limit;
    }

    /// Instant until which nothing need be asked of this watch.
    pub fn horizon(&self) -> f64 {
        self.found.unwrap_or(self.clear)
    }

    /// True if amplitudes alone prove that the guard never crosses.
    pub fn never(&self, tracks: &[Track]) -> bool {
        let amplitude = self.signal.amplitude(tracks, 0);
        self.signal.poly.is_constant() && self.signal.poly.0[0] + amplitude < self.signal.resolution
    }

    /// Extends the proof beyond `clear`, or finds the crossing.
    pub fn extend(&mut self, tracks: &mut [Track], work: &mut Work) {
        let t = self.clear;
        let seen = self.ahead.seen.take();
        work.evaluations += u64::from(seen.is_none());
        // Without a drift, what is seen tells as much.
        let ask = !self.known || self.signal.drift != Drift::Still;
        self.known = true;
        if ask && self.signal.drift_at(t)[0] < -2.0 * self.signal.resolution {
            let amplitude = self.signal.amplitude(tracks, 0);
            let free = self.signal.poly_stride(t, amplitude);
            if free == f64::INFINITY || free > 0.0 && self.signal.is_long(tracks, free, amplitude) {
                self.clear = t + free;
                return;
            }
        }
        let Probe { value, slope, amplitude, curvature } = seen.unwrap_or_else(|| {
            let (probe, rotations) = self.signal.look(tracks, t, &mut self.ahead.spare);
            work.samples += rotations;
            probe
        });
        if self.signal.drift == Drift::Still
            && self.signal.poly.0[0] + amplitude < self.signal.resolution
        {
            self.clear = f64::INFINITY;
            return;
        }
        if self.signal.drift == Drift::Still && value < -NEAR * self.signal.resolution {
            let margin = NEAR * self.signal.resolution;
            let free = self.signal.creeping_stride(tracks, amplitude, margin);
            let length = System::level_below(free).map_or(0.0, |(_, length)| length);
            if length * length * curvature > LONG_STRIDE * LONG_STRIDE * amplitude {
                self.level(value);
                self.clear = t + length;
                return;
            }
        }
        let m = curvature + self.signal.poly_curvature(t);
        if let Some(back) = self.way_back(value, slope, m) {
            self.clear = (t + back).max(t.next_up());
            return;
        }
        let Some(level) = self.level(value) else {
            self.found = Some(t);
            return;
        };
        // A stride must not end beyond a zero that the window would locate.
        let level = level.min(value.max(0.0));
        let stride = stride_below(level - value, slope, m).min(self.signal.long());
        if amplitude == 0.0 || stride * stride * curvature > SHORT_STRIDE * SHORT_STRIDE * amplitude
        {
            if let Some((step, length)) = System::level_below(stride) {
                self.clear = t + length;
                if value < -NEAR * self.signal.resolution && self.signal.drift != Drift::High {
                    self.leap(tracks, t, step + 1, [stride, level, m], work);
                }
                return;
            }
        }
        work.windows += 1;
        self.window(tracks, t);
    }

    /// A stride of a tabulated length that is longer than the one proved from its start, `t`: the
    /// bound `m` on the second derivative holds backwards too, and strides below `level` from both
    /// ends may meet.
    fn leap(
        &mut self,
        tracks: &mut [Track],
        t: f64,
        step: usize,
        [stride, level, m]: [f64; 3],
        work: &mut Work,
    ) {
        let ahead = &mut self.ahead;
        let [Some(part), None] = self.signal.parts else { return };
        let Some(length) = System::tabulated(step) else { return };
        let end = t + length;
        if end > ahead.limit || length > self.signal.long() {
            return;
        }
        let track = &mut tracks[part.track];
        (work.evaluations, work.samples) = (work.evaluations + 1, work.samples + 1);
        let seen = self.signal.look_ahead(part, track, step, end, &mut ahead.spare);
        let room = level - seen.value;
        if room >= 0.0 && stride + stride_below(room, -seen.slope, m) >= length {
            std::mem::swap(&mut track.z, &mut ahead.spare);
            track.at = end;
            (self.clear, ahead.seen) = (end, Some(seen));
        }
    }

    /// A transition may leave its own guard, by rounding, on the far side and on the way
    /// back: that is no rise through zero. The time within which it is surely back. What lies
    /// further beyond its level than rounding can leave it has crossed, whichever way it goes.
    fn way_back(&self, value: f64, slope: f64, m: f64) -> Option<f64> {
        let r = self.signal.resolution;
        if self.armed || slope >= 0.0 || !(0.5 * r..=NEAR * r).contains(&value) {
            return None;
        }
        let discriminant = slope * slope - 2.0 * m.max(0.0) * value;
        (discriminant > 0.0).then(|| 2.0 * value / (discriminant.sqrt() - slope))
    }

    /// The level that the march may approach: short of zero while that is far, so that no
    /// near miss goes unseen; then the resolution itself. None if that is reached.
    fn level(&mut self, value: f64) -> Option<f64> {
        let r = self.signal.resolution;
        if value < -NEAR * r {
            if self.near && self.armed {
                self.undecided += 1;
            }
            (self.near, self.armed) = (false, true);
            return Some(-2.0 * r);
        }
        self.near = true;
        (value < 0.875 * r).then_some(r)
    }

    /// Looks for the crossing on the Taylor polynomial at `t`: all over the window at once,
    /// then by marching through the parts where that leaves a doubt.
    #[inline(never)]
    fn window(&mut self, tracks: &[Track], t: f64) {
        let fine = 0.125 * self.signal.resolution;
        let (h, q) = shortened(self.signal.expand(tracks, t), fine);
        let slack = fine + rounding(&q);
        let grid = kernel::on_grid(&q);
        let (mut left, mut left_second) = (q[0], 2.0 * q[2]);
        let mut below = (q[0] <= 0.0).then_some(0.0);
        for i in 0..kernel::GRID {
            let (right, right_second) = (grid.value[i], grid.second[i]);
            let (start, end) = (i as f64 * PART, (i + 1) as f64 * PART);
            // No point is further than half a part from an end.
            let drift = 0.5 * PART * grid.third_bound[i / kernel::SHARED];
            let dip = (drift - left_second.min(right_second)).max(0.0);
            let second = left_second.max(right_second) + drift;
            // Between its ends a function lies below the larger by at most dip width^2 / 8.
            let top = left.max(right) + 0.125 * PART * PART * dip + slack;
            left_second = right_second;
            if top < -NEAR * self.signal.resolution {
                self.level(top);
            } else if let Some(x) = self.march(&q, start, end, second, slack, &mut below) {
                let low = below.or_else(|| low_point(&q, x));
                let root = low.map_or(0.0, |low| zero_between(&q, low, x));
                let sharp = self.signal.polish(tracks, t + root * h);
                // Where a guard only grazes zero its slope is no guide.
                let place = (sharp - t) / h;
                let kept = place >= 0.0 && horner(&q, place).0.abs() <= self.signal.resolution;
                self.found = Some(if kept { sharp } else { t + root * h });
                return;
            }
            if right <= 0.0 {
                below = Some(end);
            }
            left = right;
        }
        let end = System::level_below(h).map_or(1.0, |(_, length)| length / h);
        self.clear = t + h * back_up(&q, &grid, end);
    }

    /// Marches from `x` to `end` under a bound on the second derivative; returns where the
    /// resolution is reached.
    fn march(
        &mut self,
        q: &[f64; TAYLOR],
        mut x: f64,
        end: f64,
        second: f64,
        slack: f64,
        below: &mut Option<f64>,
    ) -> Option<f64> {
        while x < end {
            let (value, slope) = horner(q, x);
            if value <= 0.0 {
                *below = Some(x);
            }
            let Some(level) = self.level(value + slack) else { return Some(x) };
            let stride = stride_below(level - slack - value, slope, second);
            if x + stride <= x {
                return Some(x);
            }
            x += stride;
        }
        None
    }
}
