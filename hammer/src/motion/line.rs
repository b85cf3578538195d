//! A transmission line at the piston: its reaction to the piston's speed, `-Zd x'`.
//!
//! The host supplies the incoming wave. The reaction acts between the piston's mean and that of the body that
//! the drive pushes against: the casing or, without one, what the piston strikes. The reaction changes the
//! speed on which it depends. It is therefore solved in windows of its own, as a polynomial that agrees with
//! the speed at Gauss's nodes. The error of a window is below what guards resolve.

use super::state::Line;
use super::{Motion, start};
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::{LOW, NODES, through, value};
use crate::scene::graph::{CHANNELS, Channel};

/// Attempts to solve a window, each shorter, and iterations of each.
const TRIALS: usize = 64;
const PASSES: usize = 12;
/// Safety factor of the window's length, and its largest growth and shrinkage.
const SAFETY_FACTOR: f64 = 0.8;
const GROWTH: f64 = 2.0;
const SHRINKAGE: f64 = 0.1;
/// Coefficient of the Legendre polynomial of the highest degree in the highest power, on the interval from 0 to
/// 1, inverted.
const LAST: f64 = 1.0 / 924.0;
/// Allowed error of a window's speed, over what guards resolve; and its least share of the speed, for motions
/// much faster than the hammer's lengths suggest.
const ALLOWED: f64 = 0.1;
const ROUNDED: f64 = 1e-12;

impl Motion {
    /// Solves the reaction of the line in the window that begins at the epoch, if there is a line. Returns the
    /// number of rotations.
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
        // Each attempt starts from the original motion, since loads that are added and removed leave rounding
        // errors.
        let (before, [_, [speed, _]]) = (self.clone(), self.in_cylinder(&self.tracks, 0.0));
        for _ in 0..TRIALS {
            let error = self.answer(&before, &others, [span, speed], &mut work);
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
        // Errors shrink with the window, so only a number that is not finite leads here.
        Err(Error::NotFinite { time: self.state.epoch.value() })
    }

    /// Solves the reaction over a window of length `span` that begins at `speed`, and adds it to the loads.
    /// Returns the error over that allowed; infinite if the iteration does not converge.
    fn answer(
        &mut self,
        before: &Self,
        others: &[Poly; CHANNELS],
        [span, speed]: [f64; 2],
        work: &mut u64,
    ) -> f64 {
        let impedance = self.parameters().drive.impedance;
        let bodies = &self.graph().bodies;
        // Change of speed by a unit force over the window, of two free bodies.
        let moved = span * (1.0 / bodies[0].mass + 1.0 / bodies[self.graph().frame].mass);
        let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        // In powers of time over the window's length.
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
            self.load(loads, |_, _| false);
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
            // Newton's step for two free bodies: a change of the force brakes them, too.
            let mut step = through(&off);
            (1..LOW).for_each(|k| step[k] -= impedance * moved * step[k - 1] / k as f64);
            force.iter_mut().zip(step).for_each(|(force, step)| *force += step);
        }
        f64::INFINITY
    }
}
