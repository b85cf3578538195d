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
//! 2. *Curvature.* `g(t + s) <= g + g' s + M s^2 / 2` with `M = sum |c| |B|^2 |z|`. The
//!    largest `s` that keeps this below `r` is a stride: Newton's method from below, which
//!    cannot step over the first root.
//! 3. *Taylor window.* Where amplitudes cancel, absolute bounds crawl. Then `g` is expanded
//!    to order [`TAYLOR`], with a remainder below `r / 8` over a window as long as that
//!    allows, and the same march is made on the polynomial.
//!
//! Strides end on dyadic instants relative to the present one, so that a stride is one
//! tabulated rotation.

use crate::modal::system::{Functional, System, TAYLOR};
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::{Poly, TERMS};
use crate::search::window::{
    PART, back_up, horner, low_point, rounding, shortened, stride_below, zero_between,
};
use std::sync::Arc;

/// A modal vector in motion: `z(t) = exp(B (t - at)) z`.
#[derive(Clone, Debug)]
pub struct Track {
    /// Its system.
    pub system: Arc<System>,
    /// Modal vector at `at`, without static and translating parts.
    pub z: Vec<f64>,
    /// Instant of `z`, s.
    pub at: f64,
}

impl Track {
    /// Rotates forward to `t`; returns the number of rotations.
    pub fn rotate_to(&mut self, t: f64) -> u64 {
        let span = t - self.at;
        self.at = t;
        if span > 0.0 { self.system.rotate(span, &mut self.z) } else { 0 }
    }
}

/// One track's share of a guard.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Which track.
    pub track: usize,
    /// Which functional of its system.
    pub functional: usize,
    /// Factor.
    pub factor: f64,
}

/// How a guard's polynomial part varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Drift {
    /// Not at all.
    Still,
    /// As a parabola at most.
    Parabola,
    /// To a higher degree: an input has derivatives.
    High,
}

/// `poly(t) + sum factor (c B^order) . z(t)`, crossing where it rises through zero.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    /// Static and translating part, in the time of the tracks.
    pub poly: Poly,
    drift: Drift,
    /// Modal parts.
    pub parts: [Option<Part>; 2],
    /// 0: a displacement, 1: a velocity.
    pub order: usize,
    /// What counts as crossed.
    pub resolution: f64,
}

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
    pub guard: Guard,
    /// Proved not to cross before this instant, s.
    pub clear: f64,
    /// The crossing, s.
    pub found: Option<f64>,
    /// Times it came near and turned back.
    pub undecided: u64,
    armed: bool,
    near: bool,
}

/// Longest stride when the polynomial part is of high degree, s.
const LONG: f64 = 1e-3;
/// Below this part of a radian, a stride by curvature is worth less than a window.
const SHORT_STRIDE: f64 = 0.12;

impl Watch {
    /// Starts to watch at `t`.
    pub fn new(guard: Guard, t: f64) -> Self {
        Self { guard, clear: t, found: None, undecided: 0, armed: false, near: false }
    }

    /// Instant until which nothing need be asked of this watch.
    pub fn horizon(&self) -> f64 {
        self.found.unwrap_or(self.clear)
    }

    /// True if amplitudes alone prove that the guard never crosses.
    pub fn never(&self, tracks: &[Track]) -> bool {
        let amplitude = self.guard.amplitude(tracks, 0);
        self.guard.poly.is_constant() && self.guard.poly.0[0] + amplitude < self.guard.resolution
    }

    /// Extends the proof beyond `clear`, or finds the crossing.
    pub fn extend(&mut self, tracks: &mut [Track], work: &mut Work) {
        let t = self.clear;
        work.evaluations += 1;
        if self.guard.drift_at(t)[0] < -2.0 * self.guard.resolution {
            let amplitude = self.guard.amplitude(tracks, 0);
            let free = self.guard.poly_stride(t, amplitude);
            if free == f64::INFINITY || free > 0.0 && self.guard.is_long(tracks, free, amplitude) {
                self.clear = t + free;
                return;
            }
        }
        work.samples += self.guard.rotate_to(tracks, t);
        let [value, slope, amplitude, curvature] = self.guard.probe(tracks, t);
        if self.guard.drift == Drift::Still
            && self.guard.poly.0[0] + amplitude < self.guard.resolution
        {
            self.clear = f64::INFINITY;
            return;
        }
        let m = curvature + self.guard.poly_curvature(t);
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
        let stride = stride_below(level - value, slope, m).min(LONG);
        if amplitude == 0.0 || stride * stride * curvature > SHORT_STRIDE * SHORT_STRIDE * amplitude
        {
            let end = System::level_below(stride).map_or(0.0, |(_, length)| length);
            if end > 0.0 {
                self.clear = t + end;
                return;
            }
        }
        work.windows += 1;
        self.window(tracks, t);
    }

    /// A transition may leave its own guard, by rounding, on the far side and on the way
    /// back: that is no rise through zero. The time within which it is surely back.
    fn way_back(&self, value: f64, slope: f64, m: f64) -> Option<f64> {
        if self.armed || slope >= 0.0 || value < 0.5 * self.guard.resolution {
            return None;
        }
        let discriminant = slope * slope - 2.0 * m.max(0.0) * value;
        (discriminant > 0.0).then(|| 2.0 * value / (discriminant.sqrt() - slope))
    }

    /// The level that the march may approach: short of zero while that is far, so that no
    /// near miss goes unseen; then the resolution itself. None if that is reached.
    fn level(&mut self, value: f64) -> Option<f64> {
        let r = self.guard.resolution;
        if value < -4.0 * r {
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
    fn window(&mut self, tracks: &[Track], t: f64) {
        let fine = 0.125 * self.guard.resolution;
        let (h, q) = shortened(self.guard.expand(tracks, t), fine);
        let slack = fine + rounding(&q);
        let fan = kernel::fan(&q);
        let (mut left, mut left_bend) = (q[0], 2.0 * q[2]);
        let mut below = (q[0] <= 0.0).then_some(0.0);
        for i in 0..kernel::FAN {
            let (right, right_bend) = (fan.value[i], fan.bend[i]);
            let (start, end) = (i as f64 * PART, (i + 1) as f64 * PART);
            // No point is further than half a part from an end.
            let drift = 0.5 * PART * fan.twist[i];
            let dip = (drift - left_bend.min(right_bend)).max(0.0);
            let bend = left_bend.max(right_bend) + drift;
            // Between its ends a function lies below the larger by at most dip width^2 / 8.
            let top = left.max(right) + 0.125 * PART * PART * dip + slack;
            left_bend = right_bend;
            if top < -4.0 * self.guard.resolution {
                self.level(top);
            } else if let Some(x) = self.march(&q, start, end, bend, slack, &mut below) {
                let low = below.or_else(|| low_point(&q, x));
                let root = low.map_or(0.0, |low| zero_between(&q, low, x));
                let sharp = self.guard.polish(tracks, t + root * h);
                // Where a guard only grazes zero its slope is no guide.
                let place = (sharp - t) / h;
                let kept = place >= 0.0 && horner(&q, place).0.abs() <= self.guard.resolution;
                self.found = Some(if kept { sharp } else { t + root * h });
                return;
            }
            if right <= 0.0 {
                below = Some(end);
            }
            left = right;
        }
        let end = System::level_below(h).map_or(1.0, |(_, length)| length / h);
        self.clear = t + h * back_up(&q, &fan, end);
    }

    /// Marches from `x` to `end` under a bound on the second derivative; returns where the
    /// resolution is reached.
    fn march(
        &mut self,
        q: &[f64; TAYLOR],
        mut x: f64,
        end: f64,
        bend: f64,
        slack: f64,
        below: &mut Option<f64>,
    ) -> Option<f64> {
        while x < end {
            let (value, slope) = horner(q, x);
            if value <= 0.0 {
                *below = Some(x);
            }
            let Some(level) = self.level(value + slack) else { return Some(x) };
            let stride = stride_below(level - slack - value, slope, bend);
            if x + stride <= x {
                return Some(x);
            }
            x += stride;
        }
        None
    }
}

impl Guard {
    /// A guard over `parts`; see the fields.
    pub fn new(poly: Poly, parts: [Option<Part>; 2], order: usize, resolution: f64) -> Self {
        let drift = if poly.is_constant() {
            Drift::Still
        } else if poly.0[3..].iter().all(|&c| c == 0.0) {
            Drift::Parabola
        } else {
            Drift::High
        };
        Self { poly, drift, parts, order, resolution }
    }

    /// Polynomial part and its rate at `t`.
    fn drift_at(&self, t: f64) -> [f64; 2] {
        let c = &self.poly.0;
        match self.drift {
            Drift::Still => [c[0], 0.0],
            Drift::Parabola => [c[0] + t * (c[1] + t * c[2]), c[1] + 2.0 * t * c[2]],
            Drift::High => [self.poly.at(t), self.poly.derivative().at(t)],
        }
    }

    /// Functional and track of each part.
    fn each<'a>(
        &'a self,
        tracks: &'a [Track],
    ) -> impl Iterator<Item = (f64, &'a Functional, &'a Track)> {
        self.parts.iter().flatten().map(|part| {
            let track = &tracks[part.track];
            (part.factor, &track.system.functionals[part.functional], track)
        })
    }

    /// Bound on the modal part of derivative `k`, from the tracks' instants on.
    fn amplitude(&self, tracks: &[Track], k: usize) -> f64 {
        self.each(tracks)
            .map(|(factor, f, track)| {
                factor.abs() * kernel::bound(&f.weights[self.order + k], &track.z)
            })
            .sum()
    }

    /// True if a stride is at least about a radian of the motion.
    fn is_long(&self, tracks: &[Track], stride: f64, amplitude: f64) -> bool {
        stride * stride * self.amplitude(tracks, 2) > amplitude
    }

    /// Value, slope, amplitude and curvature bound at `t`, in one pass a track.
    fn probe(&self, tracks: &[Track], t: f64) -> [f64; 4] {
        let [value, rate] = self.drift_at(t);
        let mut sums = [value, rate, 0.0, 0.0];
        for (factor, f, track) in self.each(tracks) {
            let o = self.order;
            let rows = [&f.rows[o][..], &f.rows[o + 1]];
            let weights = [&f.weights[o][..], &f.weights[o + 2]];
            let [v, s, a, m] = kernel::probe(rows, weights, &track.z);
            let size = factor.abs();
            for (sum, part) in sums.iter_mut().zip([factor * v, factor * s, size * a, size * m]) {
                *sum += part;
            }
        }
        sums
    }

    /// A zero of the window's polynomial, moved to the zero of the guard itself: one Newton
    /// step, since the two differ by less than the resolution.
    fn polish(&self, tracks: &[Track], root: f64) -> f64 {
        let [mut value, mut slope] = self.drift_at(root);
        for (factor, f, track) in self.each(tracks) {
            let mut track = track.clone();
            track.rotate_to(root);
            value += factor * kernel::dot(&f.rows[self.order], &track.z);
            slope += factor * kernel::dot(&f.rows[self.order + 1], &track.z);
        }
        let close = slope > 0.0 && value.abs() <= self.resolution;
        if close { root - value / slope } else { root }
    }

    fn rotate_to(&self, tracks: &mut [Track], t: f64) -> u64 {
        self.parts.iter().flatten().map(|part| tracks[part.track].rotate_to(t)).sum()
    }

    /// How long the polynomial part stays clear by a margin, from `t`.
    fn poly_stride(&self, t: f64, margin: f64) -> f64 {
        let [value, rate] = self.drift_at(t);
        let room = -2.0 * self.resolution - margin - value;
        if room <= 0.0 {
            return 0.0;
        }
        match self.drift {
            Drift::Still => f64::INFINITY,
            Drift::Parabola => stride_below(room, rate, 2.0 * self.poly.0[2]),
            Drift::High => {
                let bend = curvature_over(&self.poly.shifted(t), LONG);
                stride_below(room, rate, bend).min(LONG)
            }
        }
    }

    /// Bound from above on the polynomial part's second derivative over the next [`LONG`].
    fn poly_curvature(&self, t: f64) -> f64 {
        match self.drift {
            Drift::Still => 0.0,
            Drift::Parabola => (2.0 * self.poly.0[2]).max(0.0),
            Drift::High => curvature_over(&self.poly.shifted(t), LONG),
        }
    }

    /// Window length and Taylor coefficients in `(time - t) / length`.
    pub fn expand(&self, tracks: &[Track], t: f64) -> (f64, [f64; TAYLOR]) {
        let mut h: f64 = 10.0 * LONG;
        for (factor, f, track) in self.each(tracks) {
            let tail = factor.abs() * kernel::bound(&f.taylor[self.order], &track.z);
            if tail > 0.0 {
                let reach =
                    math::pow(FACTORIAL * self.resolution / (16.0 * tail), 1.0 / TAYLOR as f64);
                h = h.min(reach / track.system.rate_max);
            }
        }
        let mut q = [0.0; TAYLOR];
        let mut power = 1.0;
        for (c, p) in q.iter_mut().zip(&self.poly.shifted(t).0) {
            *c = p * power;
            power *= h;
        }
        for (factor, f, track) in self.each(tracks) {
            let mut w = track.z.clone();
            kernel::taylor(
                track.system.generators(),
                &f.rows[self.order],
                &mut w,
                h,
                factor,
                &mut q,
            );
        }
        (h, q)
    }
}

/// `TAYLOR!`.
const FACTORIAL: f64 = {
    let (mut product, mut k) = (1.0, 1);
    while k <= TAYLOR {
        product *= k as f64;
        k += 1;
    }
    product
};
const _: () = assert!(TERMS <= TAYLOR);

/// Bound on `|p''|` over `[0, span]`.
fn curvature_over(p: &Poly, span: f64) -> f64 {
    (2..TERMS).map(|k| (k * (k - 1)) as f64 * p.0[k].abs() * math::powi(span, k - 2)).sum()
}
