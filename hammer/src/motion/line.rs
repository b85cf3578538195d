//! A transmission line at the piston, and its reaction `-Zd vr'` to the piston's velocity.
//!
//! The host supplies the incoming wave.
//! The reaction acts on the piston and, with the opposite sign, on the body that takes the drive's reaction: the casing
//! or, without one, what the piston strikes. `vr'` is the difference of the two mean velocities.
//! The reaction changes the velocity on which it depends. It is therefore solved in windows of time, as a polynomial
//! that agrees with the velocity at the nodes of Gauss's rule.
//! The error of a window is below the resolution of guards.

use super::state::Line;
use super::{Motion, start};
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::{LOW, NODES, through, value};
use crate::scene::graph::{CHANNELS, Channel};

/// Limit of the attempts to solve a window, each shorter than the one before, and of the iterations of each attempt.
const TRIALS: usize = 64;
const PASSES: usize = 12;
/// Work of an iteration in rotations: it copies the motion and solves its loads anew.
const ROTATIONS: u64 = 25;
/// Safety factor of the length of a window, and limits of its growth and shrinkage.
const SAFETY_FACTOR: f64 = 0.8;
const GROWTH: f64 = 2.0;
const SHRINKAGE: f64 = 0.1;
/// Inverse of the leading coefficient of the Legendre polynomial of the highest degree, on the interval from 0 to 1.
const LAST: f64 = 1.0 / 924.0;
/// Allowed error of the velocity in a window, as a share of the resolution of guards. The error may always be the share
/// [`ROUNDED`] of the velocity, which matters if the motion is much faster than the hammer's lengths suggest.
const ALLOWED: f64 = 0.1;
const ROUNDED: f64 = 1e-12;

impl Motion {
    /// Solves the reaction of the line in the window that begins at the epoch, if there is a line. Returns its work in
    /// rotations.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub(crate) fn renew_line(&mut self) -> Result<u64, Error> {
        let (parameters, mode) = (&self.model.parameters, self.state.mode);
        if !Line::acts(parameters, mode) {
            return Ok(0);
        }
        let others = start::loads(parameters, &self.state.inputs, mode, [Poly::default(); 2]);
        let (mut span, mut work, mut growth) = (self.state.line.ahead, 0, GROWTH);
        // Each attempt starts from the original motion, since adding and removing loads would leave rounding errors.
        let (before, [_, [speed, _]]) = (self.clone(), self.in_cylinder(&self.tracks, 0.0));
        for _ in 0..TRIALS {
            let error = self.solve_line(&before, &others, [span, speed], &mut work);
            let change = SAFETY_FACTOR / math::pow(error, 1.0 / LOW as f64);
            if error <= 1.0 {
                let ahead = span * change.clamp(SAFETY_FACTOR, growth);
                self.state.line = Line { reach: Some(span), ahead };
                return Ok(work);
            }
            // The window must not grow back to a length that has just failed.
            (span, growth) = (span * change.clamp(SHRINKAGE, SAFETY_FACTOR), 1.0);
        }
        *self = before;
        // Errors shrink with the window, so all attempts fail only if a number is not finite.
        Err(Error::NotFinite { time: self.state.epoch.value() })
    }

    /// Solves the reaction over a window of length `span`, at whose start the velocity is `speed`, and adds it to the
    /// loads. Returns the error over the allowed error; it is infinite if the iteration does not converge.
    fn solve_line(
        &mut self,
        before: &Self,
        others: &[Poly; CHANNELS],
        [span, speed]: [f64; 2],
        work: &mut u64,
    ) -> f64 {
        let impedance = self.parameters().drive.impedance;
        let bodies = &self.graph().bodies;
        // The change of velocity that a unit force over the window would cause between two free bodies.
        let mobility = span * (1.0 / bodies[0].mass + 1.0 / bodies[self.graph().frame].mass);
        let largest = |values: &[f64]| values.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
        // Coefficients of the reaction in powers of time over the window's length.
        let mut force = [0.0; LOW];
        force[0] = -impedance * speed;
        for _ in 0..PASSES {
            *work += ROTATIONS;
            let reaction = Poly::of_part(&force, span);
            let mut loads = *others;
            let mut add = |channel: Channel, sign: f64| {
                loads[channel as usize] = loads[channel as usize].plus(sign, &reaction);
            };
            add(Channel::Drive, 1.0);
            if !self.graph().is_framed() {
                add(Channel::Anvil, -1.0);
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
            let resolution = self.model.resolutions[1];
            let allowed = (ALLOWED * resolution).max(ROUNDED * largest(&speeds));
            let residuals =
                std::array::from_fn(|i| -impedance * speeds[i] - value(&force, NODES[i]));
            if mobility * largest(&residuals) <= allowed {
                return mobility * (LAST * force[LOW - 1]).abs() / (4 * LOW - 2) as f64 / allowed;
            }
            // This is Newton's step for two free bodies. A change of the force also brakes them.
            let mut step = through(&residuals);
            (1..LOW).for_each(|k| step[k] -= impedance * mobility * step[k - 1] / k as f64);
            force.iter_mut().zip(step).for_each(|(force, step)| *force += step);
        }
        f64::INFINITY
    }
}
