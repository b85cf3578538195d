//! A state on the section, as a vector and as a state.

use crate::laws::mode::Mode;
use crate::laws::mode::RockMode;
use crate::laws::rock::Memory;
use crate::machine::Machine;
use crate::modal::model::{Channel, Model};
use crate::motion::Motion;
use crate::numerics::kernel::inner_product;
use crate::numerics::poly::Poly;
use crate::tangent::line::Line;

/// A state without its time and the depth of its hole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point {
    pub mode: Mode,
    /// `[q | q' | uu | dp | psi]`: displacements from the origin, velocities, memory.
    pub x: Vec<f64>,
}

impl Point {
    /// Of a machine whose epoch is now.
    pub fn of(motion: &Motion) -> Self {
        let state = motion.state();
        let mut x = motion.whole_state();
        // Outside DFC the work of the last drilling cycle is of no consequence.
        let viscous = state.mode.rock == RockMode::DissipativeForward;
        x.extend([state.memory.unloaded, state.memory.gain, if viscous { state.psi } else { 0.0 }]);
        Self { mode: state.mode, x }
    }

    fn modes(&self) -> usize {
        (self.x.len() - 3) / 2
    }

    pub fn memory(&self) -> Memory {
        let at = 2 * self.modes();
        Memory { unloaded: self.x[at], gain: self.x[at + 1], ..Memory::default() }
    }

    pub fn psi(&self) -> f64 {
        self.x[2 * self.modes() + 2]
    }

    pub fn body_state(&self) -> &[f64] {
        &self.x[..2 * self.modes()]
    }

    /// The rate of change of the vector, the loads being as at the start of `machine`'s stretch.
    pub fn rate(&self, machine: &Machine) -> Vec<f64> {
        let motion = machine.motion();
        let (model, loads) = (motion.model(), &motion.state().loads);
        let modes = self.modes();
        let (q, v) = self.body_state().split_at(modes);
        let mut out = v.to_vec();
        out.extend(accelerations(model, motion, q, v, loads));
        let tip = inner_product(&model.bit.bottom, &v[model.piston.len()..]);
        let viscous = self.mode.rock == RockMode::DissipativeForward;
        let power = model.parameters.rock.viscosity * tip * tip;
        out.extend([0.0, 0.0, if viscous { power } else { 0.0 }]);
        out
    }
}

/// Modal accelerations.
fn accelerations(model: &Model, motion: &Motion, q: &[f64], v: &[f64], loads: &[Poly]) -> Vec<f64> {
    let (piston, bit) = (&model.piston, &model.bit);
    let p = piston.len();
    let beta = model.parameters.material.damping_time;
    let gap = inner_product(&bit.top, &q[p..]) - inner_product(&piston.bottom, &q[..p]);
    let contact = motion.contact().force(gap);
    let rock = motion
        .tip_line()
        .force(inner_product(&bit.bottom, &q[p..]), inner_product(&bit.bottom, &v[p..]));
    let load = |channel: Channel| loads[channel as usize].0[0];
    let own = |w2: f64, i: usize| -w2 * (q[i] + beta * v[i]);
    let mut a: Vec<f64> = piston
        .omega2
        .iter()
        .enumerate()
        .map(|(i, w2)| own(*w2, i) - piston.bottom[i] * contact)
        .collect();
    a[0] += load(Channel::Drive) / piston.mass.sqrt();
    a[0] += load(Channel::Gravity) * piston.mass.sqrt();
    let feed = load(Channel::Feed);
    a.extend(
        bit.omega2
            .iter()
            .enumerate()
            .map(|(i, w2)| own(*w2, p + i) + bit.top[i] * (feed + contact) - bit.bottom[i] * rock),
    );
    a[p] += load(Channel::Gravity) * bit.mass.sqrt();
    a
}

/// The vector of a line at a point of the section: its derivative there, at whatever time
/// the section is met.
pub(crate) fn vector_of(line: &Line, mode: Mode, rate: &[f64], moving: bool) -> Vec<f64> {
    let mut x = [&line.q[..], &line.v].concat();
    let viscous = mode.rock == RockMode::DissipativeForward;
    x.extend([line.unloaded, line.gain, if viscous { line.psi } else { 0.0 }]);
    if moving {
        x.iter_mut().zip(rate).for_each(|(x, r)| *x += r * line.instant);
    }
    x
}

/// The line of a vector.
pub(crate) fn line_of(x: &[f64]) -> Line {
    let modes = (x.len() - 3) / 2;
    let mut line = Line::zero(modes);
    line.q.copy_from_slice(&x[..modes]);
    line.v.copy_from_slice(&x[modes..2 * modes]);
    (line.unloaded, line.gain, line.psi) = (x[2 * modes], x[2 * modes + 1], x[2 * modes + 2]);
    line
}

/// What makes the parts of a vector comparable: the square root of the energy in each, for
/// motions of the rate `slowest` or faster.
pub(crate) fn weights(model: &Model, slowest: f64) -> Vec<f64> {
    let rock = &model.parameters.rock;
    let squares = model.piston.omega2.iter().chain(&model.bit.omega2);
    let mut w: Vec<f64> = squares.map(|w2| w2.sqrt().max(slowest)).collect();
    let modes = w.len();
    w.extend(vec![1.0; modes]);
    let line = (rock.unloading_ratio * rock.stiffness).sqrt();
    let barrier = rock.energy_barrier.sqrt();
    w.extend([line, line, if barrier > 0.0 { 1.0 / barrier } else { 1.0 }]);
    w
}
