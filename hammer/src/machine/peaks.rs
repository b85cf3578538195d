//! Largest forces over the last communication step.
//!
//! They are looked for only when asked: the stretches of the step are kept, and each is
//! crossed in Taylor windows (see [`crate::search::guard`]) on which a force is a polynomial.

use crate::machine::Machine;
use crate::machine::observe::Peaks;
use crate::modal::model;
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::physics::rock::Spring;
use crate::search::guard::{Guard, Part, Track};

/// A force's error in a peak corresponds to this displacement, m.
const RESOLUTION: f64 = 1e-13;
/// Stretches kept before they are worked off.
const MAX_PENDING: usize = 256;
/// Points at which a window's polynomial is looked at first.
const POINTS: usize = 24;

/// A stretch of one step, with forces `k u + c u'`.
#[derive(Clone, Debug)]
pub struct Pending {
    track: Track,
    end: f64,
    rock: Option<Force>,
    contact: Option<Force>,
}

#[derive(Clone, Copy, Debug)]
struct Force {
    functional: usize,
    poly: Poly,
    stiffness: f64,
    viscosity: f64,
}

impl Machine {
    /// Peaks of the last step.
    pub fn peaks(&mut self) -> Peaks {
        if let Some(peaks) = self.views.peaks {
            return peaks;
        }
        self.fold_peaks();
        let mut peaks = self.state.peaks;
        self.stretch(self.state.now).fold(&mut peaks);
        *self.views.peaks.insert(peaks)
    }

    /// The present stretch as far as it lies in the step.
    fn stretch(&self, end: f64) -> Pending {
        let (anchor, track) = (&self.state.anchors[0], &self.tracks[0]);
        let mut track = Track { system: track.system.clone(), z: anchor.z.clone(), at: anchor.at };
        track.rotate_to(self.state.step_start);
        let (k, c) = Spring::of(self.state.mode.rock).coefficients(&self.model.parameters.rock);
        let force = |functional, stiffness, viscosity| Force {
            functional,
            poly: self.poly(0, &track.system, functional),
            stiffness,
            viscosity,
        };
        let rock = (k > 0.0).then(|| force(model::TIP, k, c));
        let contact = self.state.mode.closed.then(|| force(model::GAP, -self.model.contact, 0.0));
        Pending { track, end, rock, contact }
    }

    /// Keeps the stretch that ends at `at`.
    pub(crate) fn keep_stretch(&mut self, at: f64) {
        let stretch = self.stretch(at);
        if stretch.rock.is_some() || stretch.contact.is_some() {
            self.pending.push(stretch);
        }
        if self.pending.len() > MAX_PENDING {
            self.fold_peaks();
        }
    }

    /// Works off the stretches kept.
    pub(crate) fn fold_peaks(&mut self) {
        for stretch in std::mem::take(&mut self.pending) {
            stretch.fold(&mut self.state.peaks);
        }
    }
}

impl Pending {
    fn fold(self, peaks: &mut Peaks) {
        if let Some(force) = self.rock {
            peaks.rock_force = force.peak(self.track.clone(), self.end, peaks.rock_force);
        }
        if let Some(force) = self.contact {
            peaks.contact_force = force.peak(self.track, self.end, peaks.contact_force);
        }
    }
}

impl Force {
    /// The larger of `best` and the force's maximum from the track's instant to `end`.
    fn peak(&self, mut track: Track, end: f64, mut best: f64) -> f64 {
        let part = Part { track: 0, functional: self.functional, factor: 1.0 };
        let guard = Guard::new(self.poly, [Some(part), None], 0, RESOLUTION);
        loop {
            let t = track.at;
            if self.ceiling(&track, t, end) <= best {
                return best;
            }
            let (h, q) = guard.expand(std::slice::from_ref(&track), t);
            let last = ((end - t) / h).clamp(0.0, 1.0);
            best = best.max(self.window_peak(&q, h, last));
            if t + h >= end {
                return best;
            }
            track.rotate_to(t + h);
        }
    }

    /// Bound on the force from `t` to `end`.
    fn ceiling(&self, track: &Track, t: f64, end: f64) -> f64 {
        let f = &track.system.functionals[self.functional];
        let (rate, span) = (self.poly.derivative(), end - t);
        let drift = if rate == Poly::default() {
            0.0
        } else {
            rate.shifted(t)
                .0
                .iter()
                .enumerate()
                .map(|(k, c)| c.abs() * math::powi(span, k))
                .sum::<f64>()
        };
        let wave = |k: usize| kernel::bound(&f.weights[k], &track.z);
        self.stiffness * self.poly.at(t)
            + self.stiffness.abs() * (drift * span + wave(0))
            + self.viscosity * (drift + wave(1))
    }

    /// Maximum of the force on `[0, last]` of a window.
    fn window_peak(&self, q: &[f64], h: f64, last: f64) -> f64 {
        let force = |x: f64| {
            let (mut value, mut slope) = (0.0, 0.0);
            for &c in q.iter().rev() {
                slope = slope * x + value;
                value = value * x + c;
            }
            self.stiffness * value + self.viscosity * slope / h
        };
        let step = last / POINTS as f64;
        let points: Vec<f64> = (0..=POINTS).map(|i| force(step * i as f64)).collect();
        let top = (0..=POINTS).max_by(|&a, &b| points[a].total_cmp(&points[b])).unwrap_or(0);
        if top == 0 || top == POINTS {
            return points[top];
        }
        // Golden section: a smooth maximum is known to 1e-10 long before its place is.
        let (mut a, mut b) = (step * (top - 1) as f64, step * (top + 1) as f64);
        const GOLDEN: f64 = 0.618_033_988_749_895;
        for _ in 0..32 {
            let (x, y) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
            if force(x) > force(y) { b = y } else { a = x }
        }
        force(0.5 * (a + b)).max(points[top])
    }
}
