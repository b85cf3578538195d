//! A transmission line at the piston: its own answer to the piston's speed, `-Zd x'`.
//!
//! What a host hands over is the line's wave. The answer acts between the piston's mean and that of what the
//! drive pushes off from: a casing, or without one what the piston strikes. It changes the speed on which it
//! hangs, so it is solved as air is ([`air`](super::air)), in windows of its own: a polynomial that agrees at
//! Gauss's nodes with the speed under it. The error of a window is below what guards resolve.

use super::air::{GROWTH, PASSES, SAFETY_FACTOR, SHRINKAGE, TRIALS};
use super::state::{Anchor, Line};
use super::{Motion, start};
use crate::air::newton::Triangles;
use crate::air::solve::polynomial;
use crate::error::Error;
use crate::modal::track::Track;
use crate::numerics::collocation::{Nodal, Rule, STAGES};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::scene::graph::{CHANNELS, Channel};

/// Part of what guards resolve of a speed by which a window may change it; of a scene that is faster than its
/// lengths let expect, part of the speed.
const ALLOWED: f64 = 0.1;
const ROUNDED: f64 = 1e-12;

/// Tracks, anchors, loads, and whether the motion is steady.
type Unloaded = (Vec<Track>, Vec<Anchor>, [Poly; CHANNELS], bool);

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
        let (before, [_, [speed, _]]) = (self.unloaded(), self.in_cylinder(&self.tracks, 0.0));
        for _ in 0..TRIALS {
            let error = self.answer(&before, &others, [span, speed], &mut work);
            let change = SAFETY_FACTOR / math::pow(error, 1.0 / STAGES as f64);
            if error <= 1.0 {
                let ahead = span * change.clamp(SAFETY_FACTOR, growth);
                self.state.line = Line { reach: Some(span), ahead };
                return Ok(work);
            }
            // What has just been too long would be so again.
            (span, growth) = (span * change.clamp(SHRINKAGE, SAFETY_FACTOR), 1.0);
        }
        self.unload(&before);
        // A shorter window errs less: only what is no number does not.
        Err(Error::NotFinite { time: self.state.epoch.value() })
    }

    /// The motion before a trial. Each begins from it: what a trial that diverges has put on and taken off again
    /// would leave its rounding.
    fn unloaded(&self) -> Unloaded {
        (self.tracks.clone(), self.state.anchors.clone(), self.state.loads, self.steady)
    }

    fn unload(&mut self, (tracks, anchors, loads, steady): &Unloaded) {
        self.tracks.clone_from(tracks);
        self.state.anchors.clone_from(anchors);
        (self.state.loads, self.steady) = (*loads, *steady);
    }

    /// Puts the answer of a window of this length, which begins at this speed, on the hammer, beside the other
    /// loads; returns its error over that allowed, infinite if force and speed do not agree.
    fn answer(
        &mut self,
        before: &Unloaded,
        others: &[Poly; CHANNELS],
        [span, speed]: [f64; 2],
        work: &mut u64,
    ) -> f64 {
        let (rule, impedance) = (Rule::get(), self.parameters().drive.impedance);
        let bodies = &self.graph().bodies;
        // The change of speed by a unit force over the window, if both bodies are free.
        let moved = span * (1.0 / bodies[0].mass + 1.0 / bodies[self.graph().frame].mass);
        let Some(matrix) = Triangles::new(-impedance * moved) else { return f64::INFINITY };
        let mut force: Nodal = [-impedance * speed; STAGES];
        for _ in 0..PASSES {
            let answer = polynomial(&force, span);
            let mut loads = *others;
            let mut push = |on: Channel, sign: f64| {
                loads[on as usize] = loads[on as usize].plus(sign, &answer);
            };
            push(Channel::Drive, 1.0);
            if !self.graph().is_framed() {
                push(Channel::Anvil, -1.0);
            }
            self.unload(before);
            self.load(loads);
            let speeds = self.steel(span, work).speed[0];
            if !speeds.iter().all(|speed| speed.is_finite()) {
                return f64::INFINITY;
            }
            let most = |values: &Nodal| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let resolved = self.model.resolutions[1];
            let allowed = (ALLOWED * resolved).max(ROUNDED * most(&speeds));
            let off: Nodal = std::array::from_fn(|i| -impedance * speeds[i] - force[i]);
            if moved * most(&off) <= allowed {
                return moved * rule.last(&force).abs() / (4 * STAGES - 2) as f64 / allowed;
            }
            let step = matrix.solve(&off);
            force.iter_mut().zip(step).for_each(|(force, step)| *force += step);
        }
        f64::INFINITY
    }
}
