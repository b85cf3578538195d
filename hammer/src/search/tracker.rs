//! The proof that a guard does not cross, or the location of its first crossing.
//!
//! # What is proved
//! A guard is `g(t) = poly(t) + sum c . z(t)` over one or two modal tracks, along the exact flow
//! from the tracks' present state. It crosses by rising through zero. Let `r` be its resolution.
//!
//! 1. *Clear.* If a guard is clear until `t`, then `g < r` up to `t` (except for 4).
//! 2. *Crossing.* If a crossing is reported at `t`, then `t` is a zero of `g`, which afterwards exceeds `3 r / 8`
//!    before it falls back. Otherwise `g` has stayed between zero and `r` for longer than a window, and `t` is an
//!    instant within that time. A guard whose first value exceeds `7 r / 8` has crossed at that instant (except for 4).
//! 3. *Grazing.* A guard that peaks below `3 r / 8` and turns back is not an event.
//! 4. *Start.* The first value may be above zero by at most `r / 2`, by `4 r` if `g` falls, or by the possible rounding
//!    (`Motion::rounding`; much more of it if `g` falls). In these cases `g` was falling back, or rounding hides its
//!    sign. All statements then hold for `g` minus its first value.
//! 5. *Rounding.* All statements include the rounding of every value, also of terms that cancel, as long as it is below
//!    `r / 16`. Therefore `r` is the guard's own resolution or 16 times the rounding of its terms at the start of the
//!    search, whichever is more ([`Signal::rounding`]). The latter is larger if the amplitudes sum to more than about
//!    `1e12` resolutions (for a hundred modes; those of the reference hammer sum to `2e11`). If the rounding of a
//!    growing drift exceeds `r / 16`, all statements hold only to that rounding. [`Window::rounding`] bounds the
//!    rounding of a window.
//!
//! # Proof
//! Values at one instant bound the future of a guard in three ways, the cheapest first.
//! 1. *Amplitude.* `|exp(B t) z|` never grows, so `poly(t) + sum |c| |z|` bounds `g` for all later `t` without any
//!    rotation. If the slowest decay outweighs the sum of all other amplitudes, it continues to do so until it has
//!    fallen to that sum. This decides the case of a creeping tip.
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
//! A step from far below zero ends at `-2 r` at most; a step from near zero ends at `r` at most, and may pass a dip
//! that is certain ([`dip`]).
//!
//! The distances between evaluations are powers of two, so that each evaluation needs one tabulated rotation.

use crate::modal::system::TAYLOR;
use crate::modal::system::generator::Generator;
use crate::modal::track::Track;
use crate::numerics::grid;
use crate::search::ahead::{Ahead, TRUSTED, worthy};
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
    /// The guard is proved not to cross before this instant, s.
    pub clear: f64,
    /// The crossing, s.
    pub root: Option<f64>,
    /// The guard is known not to cross between these instants, s ([`super::envelope`]).
    pub(super) between: [f64; 2],
    /// True once the resolution has been raised to what the guard's terms can resolve.
    known: bool,
    /// True once the guard has been evaluated.
    begun: bool,
    /// Value and rate at the start, if the guard started above zero and counted as crossed.
    pub(crate) beyond: Option<[f64; 2]>,
    ahead: Ahead,
}

/// A step that a single slow decay proves is taken if it is longer than this, in radians. Steps by curvature are rarely
/// as long.
const LONG_STEP: f64 = 2.0;
/// Share of the resolution at which a guard counts as crossed. The rest allows for rounding, and lets the scan arrive
/// in finitely many steps.
pub(super) const CROSSED: f64 = 0.875;
/// A guard more than this many resolutions below zero is far from it.
pub(crate) const NEAR: f64 = 4.0;
/// A step from far below zero ends at least this many resolutions below it.
const APPROACHED: f64 = 2.0;
/// Share of the resolution by which a guard may start above zero without having crossed.
pub(super) const AMBIGUOUS: f64 = 0.5;
/// Share of the resolution allowed for a window's remainder. The same share is allowed for its rounding.
const FINE: f64 = 0.125;
/// Share of the resolution allowed for all other rounding.
pub(super) const ROUNDED: f64 = 1.0 / 16.0;

/// Most steps of one scan, which then returns so that its work is counted.
const LONGEST_SCAN: u64 = 4096;

/// Result of scanning a part of a window. Times are relative to the window's length.
enum Scan {
    /// No crossing.
    Clear,
    /// The guard reaches the resolution here.
    Reached(f64),
    /// No crossing up to this time, after [`LONGEST_SCAN`] steps.
    Slow(f64),
}

impl GuardTracker {
    /// A tracker of a guard that starts at `t`.
    #[inline]
    pub fn new(signal: Signal, t: f64) -> Self {
        let (known, begun, ahead) = (false, false, Ahead::new());
        let between = [0.0; 2];
        Self { signal, clear: t, root: None, between, known, begun, beyond: None, ahead }
    }

    /// Restarts with another guard at `t`; memory is reused.
    #[inline]
    pub(crate) fn restart(&mut self, signal: Signal, t: f64) {
        (self.signal, self.clear, self.root, self.between) = (signal, t, None, [0.0; 2]);
        (self.known, self.begun, self.beyond) = (false, false, None);
        self.ahead.restart();
    }

    /// Tells the tracker that it never needs a proof beyond `end`, and for the moment none beyond `until`.
    #[inline]
    pub(crate) fn limit(&mut self, end: f64, until: f64) {
        (self.ahead.end, self.ahead.until) = (end, until);
    }

    /// The crossing, or the instant up to which there is none.
    #[cfg(feature = "internals")]
    pub fn horizon(&self) -> f64 {
        self.root.unwrap_or(self.clear)
    }

    /// True if amplitudes alone prove that the guard never crosses.
    pub fn never(&self, tracks: &[Track]) -> bool {
        let amplitude = self.signal.amplitude(tracks, 0);
        self.signal.stays_below(self.signal.resolution, amplitude)
    }

    /// The guard's own copy of the track, if it has one.
    pub(crate) fn own(&mut self) -> Option<(usize, &mut Track)> {
        let [Some(part), None] = self.signal.parts else { return None };
        self.ahead.own.as_mut().map(|track| (part.track, track))
    }

    /// Extends the proof beyond `clear`, or finds the crossing.
    #[inline]
    pub fn extend(&mut self, tracks: &mut [Track], work: &mut Work) {
        if (self.between[0]..self.between[1]).contains(&self.clear) {
            self.clear = self.between[1];
            self.ahead.probe = None;
            return;
        }
        if self.ahead.probe.is_some() {
            let levels = [NEAR, APPROACHED].map(|far| -far * self.signal.resolution);
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
            let drift = self.signal.drift.at(t);
            if !self.drift_keeps_away(tracks, (t, drift), Some(probe.amplitude)) {
                self.extend_from(tracks, &probe, t, work);
            }
            return;
        }
        let t = self.clear;
        work.evaluations += 1;
        let drift = self.signal.drift.at(t);
        // A guard that has been evaluated before is likely to be evaluated again, so this is only tried first.
        if !self.begun && self.drift_keeps_away(tracks, (t, drift), None) {
            return;
        }
        let spare = &mut self.ahead.spare;
        let (mut here, rotations) = self.signal.evaluate(tracks, (t, drift), spare);
        work.samples += rotations;
        if !here.is_finite() {
            return self.clear = f64::NAN; // No proof: the search ends in an error.
        }
        self.raise_resolution(tracks, t, here.amplitude);
        if !self.begun {
            self.begin(&mut here);
        } else if self.drift_keeps_away(tracks, (t, drift), Some(here.amplitude)) {
            return;
        }
        self.extend_from(tracks, &here, t, work);
    }

    /// Extends the proof by a long step and returns true if the drift alone, which has the value and rate `drift` at
    /// `t`, prevents a crossing.
    #[inline]
    fn drift_keeps_away(
        &mut self,
        tracks: &[Track],
        (t, drift): (f64, [f64; 2]),
        before: Option<f64>,
    ) -> bool {
        let margin = APPROACHED * self.signal.resolution;
        if self.signal.drift.constant().is_some() || drift[0] >= -margin {
            return false;
        }
        let amplitude = before.unwrap_or_else(|| self.signal.amplitude(tracks, 0));
        self.raise_resolution(tracks, t, amplitude);
        let free = self.signal.drift.step_below(margin + amplitude, (t, drift), self.signal.long());
        let is_long = free > 0.0
            && (self.signal.ends_before(t + free) || self.signal.is_long(tracks, free, amplitude));
        if is_long {
            self.clear = t + free;
        }
        is_long
    }

    /// Extends the proof from `t`, where the guard has the values `probe`.
    fn extend_from(&mut self, tracks: &mut [Track], probe: &Probe, t: f64, work: &mut Work) {
        let age = std::mem::take(&mut self.ahead.age);
        let (level, is_far) = (self.level(probe.value), self.is_far(probe.value));
        if self.amplitude_decides(tracks, t, probe) {
            return;
        }
        let Probe { value, slope, amplitude, curvature } = *probe;
        let m = curvature + self.signal.drift.bends(t, self.signal.long())[0];
        let Some(level) = level else {
            self.root = Some(t);
            return;
        };
        if is_far {
            self.root = steep::crossing(&self.signal, &mut self.ahead, tracks, (probe, t), m, work);
            if self.root.is_some() {
                return;
            }
        }
        // A step must not pass a zero that the window would locate.
        let step = self.step(level.min(value.max(0.0)), value, slope, m);
        let step = step.min(self.signal.long());
        let Some((_, length)) = worthy(step, curvature, amplitude) else {
            if t + step > self.ahead.end && is_far {
                self.clear = t + step;
                return;
            }
            work.windows += 1;
            return self.window(tracks, t, amplitude, work);
        };
        let far = is_far && self.signal.drift.is_bounded();
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
        } // Otherwise no step was possible, and the next evaluation is at `clear`.
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

    /// Tries to prove with amplitudes that a guard without drift never crosses again, or that a long step is clear.
    /// Returns true if it succeeds.
    fn amplitude_decides(&mut self, tracks: &[Track], t: f64, probe: &Probe) -> bool {
        let Some(drift) = self.signal.drift.constant() else { return false };
        let (r, is_far) = (self.signal.resolution, self.is_far(probe.value));
        let most = drift + probe.amplitude;
        if most < if is_far { -APPROACHED * r } else { CROSSED * r } {
            self.clear = f64::INFINITY;
            return true;
        }
        if is_far {
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
        if value <= 0.0 {
            return;
        }
        if value <= if slope < 0.0 { NEAR * r } else { AMBIGUOUS * r } {
            self.signal.drift.lower(value);
            probe.value = 0.0;
        } else if value >= CROSSED * r {
            self.beyond = Some([value, slope]);
        }
    }

    /// Withdraws a crossing at the start that was only rounding, by shifting the level to the start value.
    pub(crate) fn re_arm(&mut self) {
        if let Some([value, _]) = self.beyond.take() {
            self.signal.drift.lower(value);
            self.root = None;
        }
    }

    /// True if a value is far below zero.
    fn is_far(&self, value: f64) -> bool {
        value < -NEAR * self.signal.resolution
    }

    /// The level that a step may approach: some resolutions below zero for a distant guard, otherwise the resolution.
    /// `None` if the guard has reached it.
    fn level(&self, value: f64) -> Option<f64> {
        let r = self.signal.resolution;
        if self.is_far(value) {
            return Some(-APPROACHED * r);
        }
        (value < CROSSED * r).then_some(r)
    }

    /// How long a guard stays below `level`. If it is near zero, the step may pass a dip.
    fn step(&self, level: f64, value: f64, slope: f64, m: f64) -> f64 {
        let deep = value + APPROACHED * self.signal.resolution;
        let through = if self.is_far(value) { None } else { dip(deep, slope, m) };
        through.unwrap_or_else(|| step_below(level - value, slope, m))
    }

    /// Searches the Taylor polynomial at `t` for the crossing. Bounds on a grid exclude most of the window; the other
    /// parts are scanned.
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
        // Whatever comes after this point is left to the next window.
        let leave = back_up(&q, &points, end);
        let far = -NEAR * self.signal.resolution;
        let mut below = (q[0] <= 0.0).then_some(0.0);
        let mut part = 0;
        while part < grid::GRID {
            let start = part as f64 * PART;
            let away = points.top[part..].iter().take_while(|&&top| top + slack < far).count();
            if away > 0 {
                part += away;
                below = Some(part as f64 * PART);
                continue;
            }
            let (second, right, end) = (points.bend[part], points.value[part], start + PART);
            part += 1;
            // One part ends where the next window begins.
            let split = leave.clamp(start, end);
            for piece in [[start, split], [split, end]] {
                let x = match self.scan(&q, piece, [second, slack], (&mut below, work)) {
                    Scan::Clear => continue,
                    Scan::Reached(x) => x,
                    Scan::Slow(x) => {
                        // The next window begins here.
                        self.clear = t + h * x.min(leave);
                        return;
                    }
                };
                let low = below.or_else(|| low_point(&q, x));
                let root = low.map_or(0.0, |low| zero_between(&q, low, x));
                let sharp = self.polish(tracks, t + root * h);
                // A guard that only grazes zero has no slope that gives a reliable step.
                let place = (sharp - t) / h;
                let fits = place >= 0.0 && horner(&q, place).0.abs() <= self.signal.resolution;
                self.root = Some(if fits { sharp } else { t + root * h });
                return;
            }
            if right <= 0.0 {
                below = Some(end);
            }
        }
        self.clear = t + h * leave;
    }

    /// The zero of the guard near a zero of the window's polynomial. The guard's own track, if it has one, is left near
    /// it.
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

    /// Scans a part of a window under a bound on the second derivative.
    fn scan(
        &self,
        q: &[f64; TAYLOR],
        [mut x, end]: [f64; 2],
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
            let Some(level) = self.level(value + slack) else {
                return Scan::Reached(x);
            };
            let step = self.step(level, value + slack, slope, second);
            if x + step <= x {
                return Scan::Reached(x);
            }
            x += step;
        }
        Scan::Clear
    }
}
