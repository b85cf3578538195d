//! The proof that a guard does not cross, or the location of its first crossing.
//!
//! # What is proved
//! A guard is `g(t) = poly(t) + sum c . z(t)` over one or two modal tracks, along the exact flow
//! from the tracks' present state. It crosses by rising through zero. Let `r` be its resolution.
//!
//! 1. *Clear.* If a guard is clear until `t`, then `g < r` up to `t` (except for 4).
//! 2. *Crossing.* If a crossing is reported at `t`, then `t` is a zero of `g`, which afterwards
//!    exceeds `3 r / 8` before it falls back. Or `g` has stayed between zero and `r` for longer
//!    than a window; then `t` is an instant at which it does. A guard whose first value exceeds
//!    `7 r / 8` has crossed at that instant (except for 4).
//! 3. *Near miss.* An excursion begins and ends at least `16 r` below zero, except that one may be
//!    under way when the search begins. An excursion that comes within `2 r` of zero and turns back
//!    without crossing is not an event; it is counted once as a near miss. One that stays more than
//!    `9 r / 2` below zero is not counted; one that peaks in between may be, and one that dwells
//!    there may be counted more than once. An excursion under way is counted when another event
//!    ends the search, and when `g` is known to stay below `r` for ever; what it does later is part
//!    of it. A guard that has come to rest within `4 r` of zero for ever does not turn back and is
//!    not counted.
//! 4. *Start.* The first value may be above zero by at most `r / 2`, by `4 r` if `g` falls, or by
//!    the possible rounding (`Motion::rounding`; much more of it if `g` falls). Then `g` was on its
//!    way back, or rounding hides its sign: all statements hold for `g` less its first value.
//! 5. *Rounding.* All statements include the rounding of every value, also of terms that cancel, as
//!    long as it is below `r / 16`. Therefore `r` is the guard's own resolution or 16 times the
//!    rounding of its terms at the start of the search, whichever is more ([`Signal::rounding`]).
//!    The second applies if the amplitudes sum to more than about `1e12` resolutions (for a hundred
//!    modes; those of the reference sum to `2e11`). If the rounding of a growing drift exceeds
//!    `r / 16`, all statements hold only to that rounding. [`Window::rounding`] bounds the rounding
//!    of a window.
//!
//! # Proof
//! Values at one instant bound the future of a guard in three ways, the cheapest first.
//! 1. *Amplitude.* `|exp(B t) z|` never grows, so `poly(t) + sum |c| |z|` bounds `g` for all later
//!    `t` without any rotation. If the slowest decay outweighs all other amplitudes, it does so
//!    until it has fallen to their sum; this decides a creeping tip.
//! 2. *Curvature.* `g(t + s) <= g + g' s + M s^2 / 2` with `M = sum |c| |B|^2 |z|`. The largest `s`
//!    that keeps this below `r` is a step: Newton's method from below, which cannot pass the first
//!    root. `M` holds backwards too, so a step whose two halves are proved from its two ends is
//!    twice as long ([`ahead`](super::ahead)).
//! 3. *Taylor window.* Where amplitudes cancel, absolute bounds are too coarse. Then `g` is
//!    expanded to order [`TAYLOR`] over the longest window with a remainder below `r / 8`, and the
//!    polynomial is scanned in the same way. Its rounding is at most another `r / 8`: where the
//!    polynomial reaches `7 r / 8`, `g` is above `3 r / 8`.
//!
//! A guard that rises steeply relative to its curvature needs no window ([`steep`]).
//!
//! A step `s` that starts near zero bounds `g` from above only. It cannot hide an excursion: a
//! bound `m` on the curvature brings `g` back from a dip by at most `m s^2 / 2`, which is below
//! `12 r` unless `g` is certain to fall below `-2 r` (where `g'^2 > 2 m (g + 2 r)`). If it is, it
//! falls without turning and stays there for the rest of the step ([`dip`]), so if `m s^2 / 2`
//! exceeds `12 r`, the near miss is over.
//!
//! Guards are evaluated at dyadic distances, one tabulated rotation apart.

use crate::modal::system::TAYLOR;
use crate::modal::system::generator::Generator;
use crate::modal::track::Track;
use crate::numerics::grid;
use crate::search::TIME_RESOLUTION;
use crate::search::ahead::{Ahead, TRUSTED, worthy};
use crate::search::near_misses::{NEAR, NOTICED, NearMisses};
use crate::search::signal::{Probe, Signal};
use crate::search::steep;
use crate::search::window::{
    PART, Window, back_up, dip, horner, low_point, step_below, zero_between,
};
pub use crate::search::work::Work;

/// The proof that one guard does not cross, as far as it extends, or the crossing.
#[derive(Clone, Debug)]
pub struct GuardTracker {
    /// The guard.
    pub signal: Signal,
    /// It is proved not to cross before this instant, s.
    pub clear: f64,
    /// The crossing, s.
    pub root: Option<f64>,
    near_misses: NearMisses,
    /// True once the resolution has been raised to what the guard's terms can resolve.
    known: bool,
    /// True once the guard has been evaluated.
    begun: bool,
    /// Start value and rate, if the guard started above zero and was taken to have crossed.
    pub(crate) beyond: Option<[f64; 2]>,
    ahead: Ahead,
}

/// A step proved by one slow decay is taken if it is longer than this, in radians; steps by
/// curvature rarely are.
const LONG_STEP: f64 = 2.0;
/// Part of the resolution at which a guard counts as crossed: the margin allows for rounding, and
/// the scan reaches it in finitely many steps.
const CROSSED: f64 = 0.875;
/// A step `s` under a curvature bound `m` can hide an excursion only if `m s^2 / 2` exceeds this
/// many resolutions.
const HIDDEN: f64 = 12.0;
/// Part of the resolution by which a guard may start above zero without having crossed.
const AMBIGUOUS: f64 = 0.5;
/// Part of the resolution that a window's remainder may reach, and that its rounding may.
const FINE: f64 = 0.125;
/// Part of the resolution that all other rounding may reach.
const ROUNDED: f64 = 1.0 / 16.0;

/// Most steps of one scan, which then returns so that its work is counted.
const LONGEST_SCAN: u64 = 4096;

/// How the scan of a part of a window ends; instants are in parts of the window.
enum Scan {
    /// No crossing.
    Clear,
    /// The guard reaches the resolution here.
    Reached(f64),
    /// No crossing up to here, after [`LONGEST_SCAN`] steps.
    Slow(f64),
}

impl GuardTracker {
    /// Starts at `t`.
    #[inline]
    pub fn new(signal: Signal, t: f64) -> Self {
        let (ahead, near_misses) = (Ahead::new(), NearMisses::default());
        let (known, begun) = (false, false);
        Self { signal, clear: t, root: None, near_misses, known, begun, beyond: None, ahead }
    }

    /// Restarts with another guard at `t`; memory is reused.
    #[inline]
    pub(crate) fn restart(&mut self, signal: Signal, t: f64) {
        (self.signal, self.clear, self.root) = (signal, t, None);
        (self.known, self.begun, self.beyond) = (false, false, None);
        self.near_misses = NearMisses::default();
        self.ahead.restart();
    }

    /// Needs no proof after `end`, and none yet after `until`.
    #[inline]
    pub(crate) fn limit(&mut self, end: f64, until: f64) {
        (self.ahead.end, self.ahead.until) = (end, until);
    }

    /// The crossing, or the instant up to which there is none.
    #[cfg(feature = "internals")]
    pub fn horizon(&self) -> f64 {
        self.root.unwrap_or(self.clear)
    }

    /// Near misses completed by `now`.
    pub fn near_misses(&self, now: f64) -> u64 {
        self.near_misses.turned(now)
    }

    /// Near misses begun by `now`, where the search ends.
    pub fn near_misses_begun(&self, now: f64) -> u64 {
        if self.root.is_some_and(|at| at <= now + TIME_RESOLUTION) {
            return self.near_misses(now);
        }
        self.near_misses.begun(now)
    }

    /// True if amplitudes alone prove that the guard never crosses.
    pub fn never(&self, tracks: &[Track]) -> bool {
        let amplitude = self.signal.amplitude(tracks, 0);
        self.signal.stays_below(self.signal.resolution, amplitude)
    }

    /// The track of its own, if it has one.
    pub(crate) fn own(&mut self) -> Option<(usize, &mut Track)> {
        let [Some(part), None] = self.signal.parts else { return None };
        self.ahead.own.as_mut().map(|track| (part.track, track))
    }

    /// Extends the proof beyond `clear`, or finds the crossing.
    #[inline]
    pub fn extend(&mut self, tracks: &mut [Track], work: &mut Work) {
        if self.ahead.probe.is_some() {
            let levels = [NEAR, NOTICED].map(|far| -far * self.signal.resolution);
            if self.ahead.step_on(&self.signal, levels, &mut self.clear, work) {
                return;
            }
        }
        let [Some(part), None] = self.signal.parts else {
            return self.extend_on(tracks, work);
        };
        self.ahead.exchange(&mut tracks[part.track]);
        self.extend_on(tracks, work);
        self.ahead.exchange(&mut tracks[part.track]);
    }

    fn extend_on(&mut self, tracks: &mut [Track], work: &mut Work) {
        if let (Some(probe), Some(part)) = (self.ahead.probe.take(), self.signal.parts[0]) {
            let t = tracks[part.track].at;
            if !self.drift_keeps_away(tracks, t, Some(probe.amplitude)) {
                self.extend_from(tracks, &probe, t, work);
            }
            return;
        }
        let t = self.clear;
        work.evaluations += 1;
        // A guard that was evaluated once is likely to be evaluated again.
        if !self.begun && self.drift_keeps_away(tracks, t, None) {
            return;
        }
        let (mut here, rotations) = self.signal.evaluate(tracks, t, &mut self.ahead.spare);
        work.samples += rotations;
        if !here.is_finite() {
            return self.clear = f64::NAN; // No proof: the search ends in an error.
        }
        self.raise_resolution(tracks, t, here.amplitude);
        if !self.begun {
            self.begin(&mut here);
        } else if self.drift_keeps_away(tracks, t, Some(here.amplitude)) {
            return;
        }
        self.extend_from(tracks, &here, t, work);
    }

    /// Extends the proof by a long step if drift alone keeps the guard from zero; else returns false.
    #[inline]
    fn drift_keeps_away(&mut self, tracks: &[Track], t: f64, before: Option<f64>) -> bool {
        let margin = NOTICED * self.signal.resolution;
        if self.signal.drift.constant().is_some() || self.signal.drift.at(t)[0] >= -margin {
            return false;
        }
        let amplitude = before.unwrap_or_else(|| self.signal.amplitude(tracks, 0));
        self.raise_resolution(tracks, t, amplitude);
        let free = self.signal.drift.step_below(margin + amplitude, t, self.signal.long());
        let is_long = free > 0.0
            && (self.signal.ends_before(t + free) || self.signal.is_long(tracks, free, amplitude));
        if is_long {
            self.away_until(t, t + free);
        }
        is_long
    }

    /// Extends the proof from `t`, where the guard has the values `probe`.
    fn extend_from(&mut self, tracks: &mut [Track], probe: &Probe, t: f64, work: &mut Work) {
        let age = std::mem::take(&mut self.ahead.age);
        let level = self.level(probe.value, t);
        if self.amplitude_decides(tracks, t, probe) {
            return;
        }
        let Probe { value, slope, amplitude, curvature } = *probe;
        let m = curvature + self.signal.drift.bends(t, self.signal.long())[0];
        let Some(level) = level else {
            self.root = Some(t);
            return;
        };
        if !self.near_misses.is_near() {
            self.root = steep::crossing(&self.signal, &mut self.ahead, tracks, (probe, t), m, work);
            if self.root.is_some() {
                return;
            }
        }
        // A step must not pass a zero that the window would locate.
        let (step, down) = self.step(level.min(value.max(0.0)), value, slope, m);
        let step = step.min(self.signal.long());
        let Some((_, length)) = worthy(step, curvature, amplitude) else {
            if t + step > self.ahead.end && !self.near_misses.is_near() {
                self.clear = t + step;
                return;
            }
            work.windows += 1;
            return self.window(tracks, t, amplitude, work);
        };
        if down < length && self.may_hide(length, m) {
            self.near_misses.leave(t);
        }
        let far = value < -NEAR * self.signal.resolution && !self.signal.drift.is_high();
        let [Some(part), None] = self.signal.parts else {
            self.clear = t + length;
            return;
        };
        if !far {
            self.clear = t + length;
        } else if self.clear < t + step || age >= TRUSTED {
            self.clear = t + step;
            self.ahead.part_from(&tracks[part.track]);
            self.ahead.probe = Some(*probe);
        } // Else stepping on failed here before: the next evaluation is where the guard is clear until.
    }

    /// Raises the resolution once to what the guard's terms can resolve (statement 5).
    fn raise_resolution(&mut self, tracks: &[Track], t: f64, amplitude: f64) {
        if !self.known {
            self.known = true;
            let least = self.signal.rounding(tracks, t, amplitude) / ROUNDED;
            if least.is_finite() {
                self.signal.resolution = self.signal.resolution.max(least);
            }
        }
    }

    /// Notes that the guard stays [`NOTICED`] resolutions below zero from `t` to `end`.
    fn away_until(&mut self, t: f64, end: f64) {
        if self.near_misses.is_near() {
            self.near_misses.leave(t);
        }
        self.clear = end;
    }

    /// True if the amplitudes prove that a guard without drift never crosses again, or not for a
    /// long step, by which they extend the proof.
    fn amplitude_decides(&mut self, tracks: &[Track], t: f64, probe: &Probe) -> bool {
        let Some(drift) = self.signal.drift.constant() else { return false };
        let (r, near) = (self.signal.resolution, self.near_misses.is_near());
        let [least, most] = [-1.0, 1.0].map(|sign| drift + sign * probe.amplitude);
        if most < -NOTICED * r || near && most < CROSSED * r {
            if least > -NEAR * r {
                self.near_misses.rest();
            }
            self.away_until(t, f64::INFINITY);
            return true;
        }
        if !near {
            let free = self.signal.creeping_step(tracks, probe.amplitude, NEAR * r);
            let length = Generator::level_below(free).map_or(0.0, |(_, length)| length);
            if length * length * probe.curvature > LONG_STEP * LONG_STEP * probe.amplitude {
                self.clear = t + length;
                return true;
            }
        }
        false
    }

    /// If the guard starts slightly above zero (falling, or within rounding), shifts the level to
    /// its start value (statement 4).
    fn begin(&mut self, probe: &mut Probe) {
        self.begun = true;
        let (r, Probe { value, slope, .. }) = (self.signal.resolution, *probe);
        if self.near_misses.was_away() || value <= 0.0 {
            return;
        }
        if value <= if slope < 0.0 { NEAR * r } else { AMBIGUOUS * r } {
            self.signal.drift.lower(value);
            probe.value = 0.0;
        } else if value >= CROSSED * r {
            self.beyond = Some([value, slope]);
        }
    }

    /// Withdraws a crossing at the start, which was rounding: shifts the level to the start value.
    pub(crate) fn re_arm(&mut self) {
        if let Some([value, _]) = self.beyond.take() {
            self.signal.drift.lower(value);
            self.root = None;
        }
    }

    /// The level that a step may approach: below zero while the guard is far from it, so that no
    /// near miss is overlooked; then the resolution. None if that is reached.
    fn level(&mut self, value: f64, t: f64) -> Option<f64> {
        let r = self.signal.resolution;
        self.near_misses.observe(value / r, t);
        if !self.near_misses.is_near() {
            return Some(-NOTICED * r);
        }
        (value < CROSSED * r).then_some(r)
    }

    /// How long a guard stays below `level`, or falls on its way far below; and when it is there.
    fn step(&self, level: f64, value: f64, slope: f64, m: f64) -> (f64, f64) {
        if self.near_misses.is_near() {
            let deep = value + NOTICED * self.signal.resolution;
            if let Some([down, up]) = dip(deep, slope, m) {
                return (up, down);
            }
        }
        (step_below(level - value, slope, m), f64::INFINITY)
    }

    /// True if a guard could fall far and come back near zero within a step.
    fn may_hide(&self, step: f64, m: f64) -> bool {
        m * step * step > 2.0 * HIDDEN * self.signal.resolution
    }

    /// Searches the Taylor polynomial at `t` for the crossing: first by bounds on a grid over the
    /// whole window, then by a scan of each part that these leave open.
    #[inline(never)]
    fn window(&mut self, tracks: &mut [Track], t: f64, amplitude: f64, work: &mut Work) {
        let fine = FINE * self.signal.resolution;
        let signal = &self.signal;
        let window = signal.expand(tracks, t, amplitude);
        let (window, rounding) = window.shortened(fine, |h| signal.drift.rounding(t + h));
        let slack = fine + rounding.min(fine);
        let Window { h, q, .. } = window;
        let points = grid::on_grid(&q);
        let end = Generator::level_below(h).map_or(1.0, |(_, length)| length / h);
        // The next window covers what follows.
        let leave = back_up(&q, &points, end);
        let mut before = self.near_misses.now();
        let far = -NEAR * self.signal.resolution;
        let mut below = (q[0] <= 0.0).then_some(0.0);
        let mut part = 0;
        while part < grid::GRID {
            let start = part as f64 * PART;
            let away = points.top[part..].iter().take_while(|&&top| top + slack < far).count();
            if away > 0 {
                self.near_misses.leave(t + start * h);
                if start <= leave {
                    before = self.near_misses.now();
                }
                part += away;
                below = Some(part as f64 * PART);
                continue;
            }
            let (second, right, end) = (points.bend[part], points.value[part], start + PART);
            part += 1;
            let split = leave.clamp(start, end);
            for piece in [[start, split], [split, end]] {
                if piece[0] == leave {
                    before = self.near_misses.now();
                }
                let clock = [t, h];
                let end = self.scan(&q, piece, clock, [second, slack], (&mut below, work));
                let x = match end {
                    Scan::Clear => continue,
                    Scan::Reached(x) => x,
                    Scan::Slow(x) => {
                        // The next window begins here.
                        self.clear = t + h * x.min(leave);
                        if x > leave {
                            self.near_misses.return_to(before);
                        }
                        return;
                    }
                };
                let low = below.or_else(|| low_point(&q, x));
                let root = low.map_or(0.0, |low| zero_between(&q, low, x));
                let sharp = self.polish(tracks, t + root * h);
                // Where a guard only grazes zero, its slope gives no reliable step.
                let place = (sharp - t) / h;
                let fits = place >= 0.0 && horner(&q, place).0.abs() <= self.signal.resolution;
                self.root = Some(if fits { sharp } else { t + root * h });
                return;
            }
            if right <= 0.0 {
                below = Some(end);
            }
        }
        if leave < 1.0 {
            self.near_misses.return_to(before);
        }
        self.clear = t + h * leave;
    }

    /// The zero of the guard itself beside a zero of the window's polynomial. A track of its own is
    /// left near it.
    fn polish(&mut self, tracks: &mut [Track], root: f64) -> f64 {
        let [Some(part), None] = self.signal.parts else {
            let parts = self.signal.parts.into_iter().flatten();
            let before: Vec<_> = parts.map(|p| (p.track, tracks[p.track].clone())).collect();
            before.iter().for_each(|(index, _)| _ = tracks[*index].rotate_to(root));
            let sharp = self.signal.polish(tracks, root);
            before.into_iter().for_each(|(index, track)| tracks[index] = track);
            return sharp;
        };
        let track = &mut tracks[part.track];
        self.ahead.part_from(track);
        track.rotate_to(root);
        let sharp = self.signal.polish(tracks, root);
        tracks[part.track].step_back_to(sharp);
        sharp
    }

    /// Scans a part of a window under a bound on the second derivative. `clock` is the window's
    /// start and length, s.
    fn scan(
        &mut self,
        q: &[f64; TAYLOR],
        [mut x, end]: [f64; 2],
        [t, h]: [f64; 2],
        [second, slack]: [f64; 2],
        (below, work): (&mut Option<f64>, &mut Work),
    ) -> Scan {
        let limit = work.scans + LONGEST_SCAN;
        while x < end {
            if work.scans == limit {
                return Scan::Slow(x);
            }
            work.scans += 1;
            let (value, slope) = horner(q, x);
            if value <= 0.0 {
                *below = Some(x);
            }
            let Some(level) = self.level(value + slack, t + x * h) else {
                return Scan::Reached(x);
            };
            let (step, down) = self.step(level, value + slack, slope, second);
            if x + step <= x {
                return Scan::Reached(x);
            }
            let length = step.min(end - x);
            if down < length && self.may_hide(length, second) {
                self.near_misses.leave(t + x * h);
            }
            x += step;
        }
        Scan::Clear
    }
}
