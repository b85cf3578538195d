//! Q3: the instant at which the viscous work of a cycle reaches the energy barrier.
//!
//! `psi(t) = psi_0 + CR int p'^2` never falls, so one value below the barrier at `t` proves
//! that it has not been reached before `t`: strides may be guesses, and nothing is missed.
//! The integral is exact (see [`Stretch`]).

use crate::modal::stretch::Stretch;
use crate::modal::system::{CHANNELS, System};
use crate::modal::track::Track;
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::search::watch::Work;

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
    form: f64,
    /// Work done where the cursor stands, J.
    done: f64,
}

impl Barrier {
    /// Starts at the anchor of `track`, instant 0.
    pub fn new(track: &Track, tip: usize, room: f64, viscosity: f64) -> Self {
        let mut barrier = Self {
            room,
            viscosity,
            clear: 0.0,
            found: None,
            cursor: track.clone(),
            stride: 4.0 / track.system.rate_max,
            tip,
            form: 0.0,
            done: 0.0,
        };
        if room <= 0.0 {
            barrier.found = Some(0.0);
        } else if viscosity == 0.0 {
            barrier.clear = f64::INFINITY;
        } else {
            barrier.form = track.system.viscous_form().of(&track.z);
        }
        barrier
    }

    fn done(&self, anchor: &[f64], track: &Track, loads: &[Poly; CHANNELS]) -> f64 {
        let still = Poly::default();
        let stretch = Stretch::new(track, anchor, track.at, loads, &still);
        self.viscosity * stretch.tip_square(self.tip, self.form)
    }

    fn power(&self, track: &Track, loads: &[Poly; CHANNELS]) -> f64 {
        let tip = &track.system.functionals[self.tip];
        let drift = tip.poly(loads, &Poly::default()).derivative().at(track.at);
        let v = kernel::dot(&tip.rows[1], &track.z) + drift;
        self.viscosity * v * v
    }

    /// Extends the proof by one stride, or finds the instant.
    pub fn extend(&mut self, anchor: &[f64], loads: &[Poly; CHANNELS], work: &mut Work) {
        let left = self.room - self.done;
        let guess = 1.05 * left / self.power(&self.cursor, loads);
        let span = guess.min(self.stride).max(0.0);
        let (_, length) = System::level_below(span).unwrap_or((0, System::shortest()));
        let mut ahead = self.cursor.clone();
        work.samples += ahead.rotate_to(self.cursor.at + length);
        work.evaluations += 1;
        let done = self.done(anchor, &ahead, loads);
        if done < self.room {
            (self.clear, self.done) = (ahead.at, done);
            self.cursor = ahead;
            self.stride = 2.0 * length;
            return;
        }
        self.found = Some(self.root(anchor, loads, length, work));
    }

    /// Newton on the rising `psi`, kept in its bracket by bisection.
    fn root(&self, anchor: &[f64], loads: &[Poly; CHANNELS], span: f64, work: &mut Work) -> f64 {
        let (mut low, mut high) = (0.0, span);
        let left = self.room - self.done;
        let mut x = (left / self.power(&self.cursor, loads)).clamp(low, high);
        for _ in 0..100 {
            let mut at = self.cursor.clone();
            work.samples += at.rotate_to(self.cursor.at + x);
            work.evaluations += 1;
            let excess = self.done(anchor, &at, loads) - self.room;
            if excess > 0.0 {
                high = x
            } else {
                low = x
            }
            let newton = x - excess / self.power(&at, loads);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            // Newton squares the error: after a step this short nothing is left to gain.
            if (next - x).abs() <= 1e-9 * span {
                return self.cursor.at + next;
            }
            x = next;
        }
        self.cursor.at + x
    }
}
