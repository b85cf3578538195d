//! A modal vector in motion.

use crate::modal::system::System;
use crate::numerics::kernel;
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

    /// Rotates forward to `t` and looks at derivative `order` (0 or 1) of functional `index`:
    /// value, rate, bounds on it and on its second derivative from here on; and the number of
    /// rotations.
    pub(crate) fn look(&mut self, t: f64, index: usize, order: usize) -> ([f64; 4], u64) {
        let span = t - self.at;
        self.at = t;
        if span > 0.0 {
            self.system.rotate_and_look(span, index, order, &mut self.z)
        } else {
            (kernel::look(self.system.functionals[index].look(order), &self.z), 0)
        }
    }
}
