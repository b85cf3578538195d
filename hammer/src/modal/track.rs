//! Tracks: modal vectors in motion.

use crate::modal::system::System;
use crate::modal::system::generator::Generator;
use crate::numerics::kernel;
use std::sync::Arc;

/// Rounding by which an instant of the host may lie before the last event, s.
pub(crate) const ROUNDED: f64 = 1e-12;

/// A modal vector in motion: `z(t) = exp(B (t - at)) z`.
#[derive(Clone, Debug)]
pub struct Track {
    /// The system to which the modal vector belongs.
    pub system: Arc<System>,
    /// Modal vector at the time `at`, without its polynomial part (static deflection and translation).
    pub z: Vec<f64>,
    /// Time of `z` after the epoch, s.
    pub at: f64,
}

impl Track {
    /// Rotates the track forward to `t`. Returns the number of rotations.
    pub fn rotate_to(&mut self, t: f64) -> u64 {
        let span = t - self.at;
        debug_assert!(span >= -ROUNDED, "a track stands beyond where it is to go");
        self.at = t;
        // A system that has only translations does not rotate.
        if span > 0.0 && self.system.rate_max > 0.0 {
            self.system.rotate(span, &mut self.z)
        } else {
            0
        }
    }

    /// Rotates the track back to `t` if the span is short enough for the series.
    pub(crate) fn step_back_to(&mut self, t: f64) {
        let span = t - self.at;
        if span < 0.0 && self.system.generator.rotate_slightly(span, &mut self.z) {
            self.at = t;
        }
    }

    /// Evaluates derivative `order` (0 or 1) of functional `index`: its value, its rate, and bounds on the value and on
    /// its second derivative for all later times.
    pub(crate) fn evaluate(&self, index: usize, order: usize) -> [f64; 4] {
        kernel::evaluate(self.system.functionals[index].evaluation_rows(order), &self.z)
    }

    /// Rotates the track to `t` and evaluates it there, as [`Self::evaluate`] does. Also returns the number of
    /// rotations. `spare` is storage for a modal vector.
    pub(crate) fn evaluate_at(
        &mut self,
        t: f64,
        index: usize,
        order: usize,
        spare: &mut Vec<f64>,
    ) -> ([f64; 4], u64) {
        if let Some((level, length)) = Generator::level_below(t - self.at)
            && length == t - self.at
            && length * self.system.rate_max > kernel::SHORT
        {
            let rows = self.system.functionals[index].evaluation_rows(order);
            let value = self.system.generator.evaluate_ahead(level, rows, &self.z, spare);
            std::mem::swap(&mut self.z, spare);
            self.at = t;
            return (value, 1);
        }
        let count = self.rotate_to(t);
        (self.evaluate(index, order), count)
    }
}
