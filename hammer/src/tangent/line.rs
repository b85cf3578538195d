//! The derivative of a state by one parameter.

use crate::machine::blows::Blow;
use crate::modal::model::Model;
use crate::modal::system::CHANNELS;
use crate::numerics::kernel::inner_product;
use crate::tangent::leg::Place;
use serde::{Deserialize, Serialize};

/// Derivative of a milestone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mark {
    pub time: f64,
    pub hole: f64,
}

/// Derivatives of what is summed over time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spent {
    /// Work of the loads, a channel each.
    pub work: [f64; CHANNELS],
    /// Lost in the rock on loading.
    pub rock: f64,
    /// Of the dashpot, in the drilling cycles that are over.
    pub viscous: f64,
    pub retuned: f64,
    /// Impulses of loads and weight on piston and bit.
    pub push: [f64; 2],
    /// Energy stored and the bodies' momenta where the sums begin.
    pub stored: f64,
    pub momenta: [f64; 2],
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
    /// Carried if somebody asks for it.
    pub spent: Spent,
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

    /// Of where points of the bodies are.
    pub(crate) fn place(&self, model: &Model) -> Place {
        let [piston, bit] = self.means(model);
        let top = inner_product(&model.bit.top, &self.q[model.piston.len()..]);
        Place { piston: piston[0], bit: bit[0], top, tip: self.tip(model)[0] }
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
