//! A state on the section, as a vector and as a state.

use crate::air::{Air, Content, pressures, volumes};
use crate::error::Error;
use crate::laws::mode::Mode;
use crate::laws::rock::Memory;
use crate::machine::Machine;
use crate::modal::model::Model;
use crate::quantities::parameters::{Parameters, Reloading};

/// A state without its time and the depth of its hole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point {
    mode: Mode,
    air: Option<Box<Air>>,
    modes: usize,
    /// `[q | q' | uu | dp | force at the last turn | psi]`: displacements from the origin, velocities, memory; then
    /// the content of the chambers.
    pub x: Vec<f64>,
}

impl Point {
    /// Of a machine whose epoch is now.
    pub fn of(machine: &Machine) -> Self {
        let state = machine.motion().state();
        let mut x = machine.motion().whole_state();
        let modes = x.len() / 2;
        // Outside DFC the work of the last drilling cycle is of no consequence.
        let viscous = state.mode.rock.is_viscous();
        let reloads = machine.parameters().rock.reloading == Reloading::Unloading;
        let Memory { unloaded, gain, turned } = state.memory;
        let psi = if viscous { state.psi } else { 0.0 };
        x.extend([unloaded, gain, if reloads { turned } else { 0.0 }, psi]);
        let air = state.air.clone();
        x.extend(air.iter().flat_map(|air| air.content));
        Self { mode: state.mode, air, modes, x }
    }

    /// Puts a machine there; its energies count from here.
    pub fn place(&self, machine: &mut Machine) -> Result<(), Error> {
        let (body_state, rest) = self.x.split_at(2 * self.modes);
        let (memory, chambers) = rest.split_at(4);
        let content = Content::try_from(chambers).ok();
        let air = self.air.clone().zip(content);
        let air = air.map(|(air, content)| Box::new(Air { content, ..*air }));
        if body_state.len() != machine.motion().whole_state().len() {
            return Err(Error::Foreign);
        }
        let [unloaded, gain, turned, psi] = [memory[0], memory[1], memory[2], memory[3]];
        machine.place(self.mode, Memory { unloaded, gain, turned }, psi, air, body_state)
    }

    /// True if both are in the same discrete state: points between them mean something.
    pub fn shares_mode(&self, other: &Self) -> bool {
        let openings = |point: &Self| point.air.as_ref().map(|air| (air.openings, air.regimes));
        self.mode == other.mode && openings(self) == openings(other)
    }

    /// The vector with each part times its weight.
    pub fn weighted(&self, weights: &[f64]) -> Vec<f64> {
        self.x.iter().zip(weights).map(|(x, w)| x * w).collect()
    }

    /// The point whose weighted vector this is, in the same discrete state.
    pub fn with(&self, weighted: &[f64], weights: &[f64]) -> Self {
        let x = weighted.iter().zip(weights).map(|(y, w)| y / w).collect();
        Self { x, ..self.clone() }
    }
}

/// What makes the parts of a vector comparable: the square root of the energy in each, for motions
/// that take as long as `period` or less.
pub(crate) fn weights(model: &Model, point: &Point, period: f64) -> Vec<f64> {
    let parameters: &Parameters = &model.parameters;
    let rock = &parameters.rock;
    let slowest = 2.0 * std::f64::consts::PI / period;
    let mut w: Vec<f64> =
        model.graph.omega2(model.graph.all()).map(|w2| w2.sqrt().max(slowest)).collect();
    w.extend(vec![1.0; point.modes]);
    let line = (rock.unloading_ratio * rock.stiffness).sqrt();
    let barrier = rock.energy_barrier.sqrt();
    w.extend([line, line, 1.0 / line, if barrier > 0.0 { 1.0 / barrier } else { 1.0 }]);
    // The momentum that a pressure gives the piston over a period.
    let drive = &parameters.drive;
    if let Some(air) = &point.air {
        let volumes = volumes(parameters, [-0.5 * parameters.air.cylinder; 2]);
        let pressures = pressures(&air.content, volumes);
        w.extend(air.content.iter().enumerate().map(|(k, content)| {
            let area = [drive.area_drive, drive.area_return][k / 2];
            pressures[k / 2] * area * period / (content * model.graph.bodies[0].mass.sqrt())
        }));
    }
    w
}
