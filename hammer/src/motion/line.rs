//! A transmission line at the piston: its own answer to the piston's speed, `-Zd x'`.
//!
//! What a host hands over is the line's wave. The answer acts between the piston's mean and that of what the
//! drive pushes off from: a casing, or without one what the piston strikes. It changes the speed on which it
//! hangs, so it is solved in windows of its own: a polynomial that agrees at Gauss's nodes with the speed under
//! it. The error of a window is below what guards resolve.

use super::state::Line;
use super::{Motion, start};
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::{LOW, NODES, through, value};
use crate::scene::graph::{CHANNELS, Channel};

/// Trials of a window, each shorter, and replacements of the force that is guessed.
const TRIALS: usize = 64;
const PASSES: usize = 12;
/// Part of the length that the error would allow, and how a window may grow and shrink.
const SAFETY_FACTOR: f64 = 0.8;
const GROWTH: f64 = 2.0;
const SHRINKAGE: f64 = 0.1;
/// What the highest power of time has of Legendre's polynomial of its degree on the interval from 0 to 1.
const LAST: f64 = 1.0 / 924.0;
/// Part of what guards resolve of a speed by which a window may change it; of a scene that is faster than its
/// lengths let expect, part of the speed.
const ALLOWED: f64 = 0.1;
const ROUNDED: f64 = 1e-12;

impl Motion {
    /// Solves the answer of the window that begins at the epoch, if there is a line; returns the number of
    /// rotations.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub(super) fn renew_line(&mut self) -> Result<u64, Error> {
        let (parameters, mode) = (&self.model.parameters, self.state.mode);
        if !Line::acts(parameters, mode) {
            return Ok(0);
        }
        let others = start::loads(parameters, &self.state.inputs, mode, [Poly::default(); 2]);
        let (mut span, mut work, mut growth) = (self.state.line.ahead, 0, GROWTH);
        // Each trial begins from the motion before it: what one that diverges has put on and taken off again would
        // leave its rounding.
        let (before, [_, [speed, _]]) = (self.clone(), self.in_cylinder(&self.tracks, 0.0));
        for _ in 0..TRIALS {
            let error = self.answer(&before, &others, [span, speed], &mut work);
            let change = SAFETY_FACTOR / math::pow(error, 1.0 / LOW as f64);
            if error <= 1.0 {
                let ahead = span * change.clamp(SAFETY_FACTOR, growth);
                self.state.line = Line { reach: Some(span), ahead };
                return Ok(work);
            }
            // What has just been too long would be so again.
            (span, growth) = (span * change.clamp(SHRINKAGE, SAFETY_FACTOR), 1.0);
        }
        *self = before;
        // A shorter window errs less: only what is no number does not.
        Err(Error::NotFinite { time: self.state.epoch.value() })
    }

    /// Puts the answer of a window of this length, which begins at this speed, on the hammer, beside the other
    /// loads; returns its error over that allowed, infinite if force and speed do not agree.
    fn answer(
        &mut self,
        before: &Self,
        others: &[Poly; CHANNELS],
        [span, speed]: [f64; 2],
        work: &mut u64,
    ) -> f64 {
        let impedance = self.parameters().drive.impedance;
        let bodies = &self.graph().bodies;
        // The change of speed by a unit force over the window, if both bodies are free.
        let moved = span * (1.0 / bodies[0].mass + 1.0 / bodies[self.graph().frame].mass);
        let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        // By powers of the time as a part of the window.
        let mut force = [0.0; LOW];
        force[0] = -impedance * speed;
        for _ in 0..PASSES {
            let answer = Poly::of_part(&force, span);
            let mut loads = *others;
            let mut push = |on: Channel, sign: f64| {
                loads[on as usize] = loads[on as usize].plus(sign, &answer);
            };
            push(Channel::Drive, 1.0);
            if !self.graph().is_framed() {
                push(Channel::Anvil, -1.0);
            }
            self.clone_from(before);
            self.load(loads);
            let mut tracks = self.tracks.clone();
            let speeds = NODES.map(|node| {
                let rotations = tracks.iter_mut().map(|track| track.rotate_to(span * node));
                *work += rotations.sum::<u64>();
                self.point(&tracks, Displacement::Relative, span * node).velocity
            });
            if !speeds.iter().all(|speed| speed.is_finite()) {
                return f64::INFINITY;
            }
            let resolved = self.model.resolutions[1];
            let allowed = (ALLOWED * resolved).max(ROUNDED * most(&speeds));
            let off = std::array::from_fn(|i| -impedance * speeds[i] - value(&force, NODES[i]));
            if moved * most(&off) <= allowed {
                return moved * (LAST * force[LOW - 1]).abs() / (4 * LOW - 2) as f64 / allowed;
            }
            // Of two free bodies: what is added brakes them too.
            let mut step = through(&off);
            (1..LOW).for_each(|k| step[k] -= impedance * moved * step[k - 1] / k as f64);
            force.iter_mut().zip(step).for_each(|(force, step)| *force += step);
        }
        f64::INFINITY
    }
}
