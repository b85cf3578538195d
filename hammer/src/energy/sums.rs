//! Sums over time of works, losses and impulses.

use crate::scene::graph::CHANNELS;
use serde::{Deserialize, Serialize};

/// Sums over time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// Work of the loads, per channel, J.
    pub work: [f64; CHANNELS],
    /// Work dissipated in the bars, J.
    pub damping: f64,
    /// Work of the dashpot at the tip, J.
    pub viscous: f64,
    /// Work dissipated in the rock on loading, J.
    pub rock: f64,
    /// Energy put in by changing a parameter, J.
    pub retuned: f64,
    /// Impulse of `F_C`, N s.
    pub contact_impulse: f64,
    /// Impulse of `F_R`, N s.
    pub rock_impulse: f64,
}

impl Sums {
    /// Adds the sums of another interval.
    pub fn add(&mut self, other: &Self) {
        for (a, b) in self.work.iter_mut().zip(other.work) {
            *a += b;
        }
        self.damping += other.damping;
        self.viscous += other.viscous;
        self.rock += other.rock;
        self.retuned += other.retuned;
        self.contact_impulse += other.contact_impulse;
        self.rock_impulse += other.rock_impulse;
    }
}
