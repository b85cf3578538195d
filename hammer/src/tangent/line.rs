//! The derivative of a state by one parameter.

use crate::machine::blows::Blow;
use crate::modal::model::Model;
use crate::numerics::kernel::inner_product;
use serde::{Deserialize, Serialize};

/// Derivative of a milestone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mark {
    pub time: f64,
    pub hole: f64,
}

/// Derivative of the state at a fixed time: displacements from the origin and velocities of
/// the bodies' modes (piston, then bit; scaled as `change` has it), and of what is remembered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Line {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub origin: f64,
    pub unloaded: f64,
    pub gain: f64,
    pub psi: f64,
    /// Of the instant of the last event.
    pub instant: f64,
    pub blow: Blow,
    pub blows: [Option<Mark>; 2],
    pub collision: f64,
    pub strikes: Vec<Strike>,
    /// Of the hole's depth where the way began.
    pub started: f64,
    /// Least change of the parameter that would turn the order of two events, to first order.
    pub reach: f64,
}

impl Line {
    pub(crate) fn zero(modes: usize) -> Self {
        Self {
            q: vec![0.0; modes],
            v: vec![0.0; modes],
            reach: f64::INFINITY,
            ..Default::default()
        }
    }

    pub(crate) fn tip(&self, model: &Model) -> [f64; 2] {
        let p = model.piston.len();
        [&self.q, &self.v].map(|x| inner_product(&model.bit.bottom, &x[p..]))
    }

    pub(crate) fn gap(&self, model: &Model) -> [f64; 2] {
        let p = model.piston.len();
        let bit = [&self.q, &self.v].map(|x| inner_product(&model.bit.top, &x[p..]));
        let piston = [&self.q, &self.v].map(|x| inner_product(&model.piston.bottom, &x[..p]));
        [bit[0] - piston[0], bit[1] - piston[1]]
    }

    /// Means of the piston and of the bit.
    pub(crate) fn means(&self, model: &Model) -> [[f64; 2]; 2] {
        let p = model.piston.len();
        let mean = |i: usize, mass: f64| [self.q[i], self.v[i]].map(|x| x / mass.sqrt());
        [mean(0, model.piston.mass), mean(p, model.bit.mass)]
    }

    pub(crate) fn relative(&self, model: &Model) -> [f64; 2] {
        let [piston, bit] = self.means(model);
        [piston[0] - bit[0], piston[1] - bit[1]]
    }

    /// The origin moves by `shift` more.
    pub(crate) fn shift(&mut self, model: &Model, shift: f64) {
        self.origin += shift;
        self.unloaded -= shift;
        self.q[0] -= shift * model.piston.mass.sqrt();
        self.q[model.piston.len()] -= shift * model.bit.mass.sqrt();
    }

    /// Displacements and velocities of the modes in `range`.
    pub(crate) fn part(&self, range: std::ops::Range<usize>) -> Vec<f64> {
        [&self.q[range.clone()], &self.v[range]].concat()
    }

    pub(crate) fn set_part(&mut self, range: std::ops::Range<usize>, body_state: &[f64]) {
        let n = range.len();
        self.q[range.clone()].copy_from_slice(&body_state[..n]);
        self.v[range].copy_from_slice(&body_state[n..]);
    }
}

/// A blow as one can measure it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strike {
    /// Instant of impact, s.
    pub time: f64,
    /// Relative mean speed at impact, m/s.
    pub speed: f64,
    /// `Mp speed^2 / 2`, J.
    pub energy: f64,
    /// Mean speed, upward, at which the piston leaves the bit for the last time, m/s.
    pub rebound: f64,
}
