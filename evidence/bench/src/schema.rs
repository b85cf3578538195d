//! The task, the hammer and the answer, in one form for all solvers.
//!
//! Solvers in Rust take a [`Task`] and the model; the others read a [`Case`] as JSON. All give an [`Answer`], which
//! is compared with the reference in extended precision.

use oracles::dd::Dd;
use oracles::law::{Event, Mode, Rock, State};
use oracles::linear::Real;
use oracles::model::Model;
use oracles::reference::Solution;
use oracles::scene::{AirLaw, Drive, Input};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Two events are the same if their times differ by less than this, s.
const SAME: f64 = 2e-7;

/// How much nearer to zero than the engine's own resolution a peer's guards of velocities are passed: at 1e-9 m/s an
/// event is late by 2 ns, which alone is an error of 6e-9.
const NEARER: f64 = 1e-3;

/// What every solver must compute, from rest.
#[derive(Clone, Debug, Serialize)]
pub struct Task {
    /// Instants at which the state is wanted, s, ascending.
    pub instants: Vec<f64>,
    /// End of the integration, s.
    pub end: f64,
    /// Time after which a solver gives up, s.
    pub patience: f64,
}

impl Task {
    /// The instants, then the end, s.
    pub fn stops(&self) -> impl Iterator<Item = f64> {
        self.instants.iter().copied().filter(|&t| t < self.end).chain([self.end])
    }
}

/// The assembled hammer and the task, for a solver that is not written in Rust. SI units.
#[derive(Debug, Serialize)]
pub struct Case {
    nodes: usize,
    bit: usize,
    gap: f64,
    contact: f64,
    loading: f64,
    unloading: f64,
    viscosity: f64,
    gamma: f64,
    barrier: f64,
    speed: f64,
    penetration: f64,
    amplitude: f64,
    stroke: f64,
    position_resolution: f64,
    velocity_resolution: f64,
    dead: Vec<f64>,
    drive: Vec<f64>,
    relative: Vec<f64>,
    start: Vec<f64>,
    /// Factors `L` and `1/D` of the mass matrix.
    lower: Vec<f64>,
    inverse: Vec<f64>,
    /// Numbers of the air's law, for air that drives a rigid hammer without a casing.
    air: Vec<f64>,
    #[serde(flatten)]
    task: Task,
    /// `k0 k0_off c0 c0_off ...`: tridiagonal stiffness and damping by [`Mode::system_index`].
    #[serde(flatten)]
    systems: BTreeMap<String, Vec<f64>>,
}

impl Case {
    /// The case of a hammer driven by a relay, or of a rigid one driven by air.
    pub fn new(model: &Model<f64>, task: &Task) -> Self {
        let (scene, rock) = (&model.scene, &model.scene.rock);
        let [amplitude, stroke] = scene.drive.relay();
        let [position_resolution, velocity_resolution] = scene.resolutions;
        let tip = |rock| {
            let system = model.system(Mode::bare(false, rock));
            system.stiffness.diagonal[model.nodes() - 1]
        };
        let mut dead = model.weight.clone();
        dead[model.bit] += scene.inputs[Input::Feed as usize];
        let mut systems = BTreeMap::new();
        for (i, system) in model.systems.iter().enumerate() {
            for (name, matrix) in [("k", &system.stiffness), ("c", &system.damping)] {
                systems.insert(format!("{name}{i}"), matrix.diagonal.clone());
                systems.insert(format!("{name}{i}_off"), matrix.off.clone());
            }
        }
        Self {
            nodes: model.nodes(),
            bit: model.bit,
            gap: scene.gap,
            contact: model.contact_stiffness,
            loading: tip(Rock::FC) - tip(Rock::FF),
            unloading: tip(Rock::BC) - tip(Rock::FF),
            viscosity: rock.viscosity,
            gamma: rock.ratio,
            barrier: rock.barrier,
            speed: rock.standstill_speed,
            penetration: rock.standstill_penetration,
            amplitude,
            stroke,
            position_resolution,
            velocity_resolution: NEARER * velocity_resolution,
            dead,
            drive: model.drive.clone(),
            relative: model.relative.clone(),
            start: model.start().0.u,
            lower: model.mass_factor.lower.clone(),
            inverse: model.mass_factor.inverse.clone(),
            air: if let Drive::Air(law) = &scene.drive { numbers(law) } else { Vec::new() },
            task: task.clone(),
            systems,
        }
    }
}

/// Areas, dead volumes, length of the cylinder, edges and height of the ports, port areas, discharge, leakage, drag,
/// temperature, pressures outside.
fn numbers(law: &AirLaw) -> Vec<f64> {
    let [drive, back] = law.edges;
    let parts: [&[f64]; 7] = [
        &law.areas,
        &law.dead_volumes,
        &[law.cylinder],
        &[drive[0], drive[1], back[0], back[1], law.height],
        &law.ports,
        &[law.discharge, law.leakage, law.drag, law.temperature],
        &law.outside,
    ];
    parts.concat()
}

/// A computed solution.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Answer {
    /// CPU time of a solver that measures its own, s.
    #[serde(default)]
    pub cpu: Option<f64>,
    /// Its set-up, s, if that is a part of the run.
    #[serde(default)]
    pub setup: Option<f64>,
    /// Nodal displacements (m), then velocities (m/s), at each instant.
    #[serde(default)]
    pub states: Vec<Vec<f64>>,
    /// Transitions: time (s) and kind.
    #[serde(default)]
    pub events: Vec<(f64, Event)>,
    /// Reason of a failure.
    #[serde(default)]
    pub failure: Option<String>,
}

/// An answer compared with the reference.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Verdict {
    /// Largest error over all nodal displacements in 1 mm and velocities in 1 m/s.
    pub error: f64,
    /// Events of the reference that were found.
    pub found: usize,
    /// Events of the reference that were missed.
    pub missed: usize,
    /// Events that the reference does not have.
    pub spurious: usize,
}

impl Answer {
    /// Keeps a state, if the task needs another one.
    pub fn keep(&mut self, task: &Task, state: &State<f64>) {
        if self.states.len() < task.instants.len() {
            self.states.push([&state.u[..], &state.v].concat());
        }
    }

    /// Compares with the reference over the task. A value that is not finite is an error of `f64::MAX`.
    pub fn judge(&self, exact: &Solution, task: &Task) -> Verdict {
        let known = exact.states.iter().filter(|s| task.instants.contains(&s.time));
        let mut error: f64 = if self.states.len() == task.instants.len() { 0.0 } else { f64::MAX };
        for (known, own) in known.zip(&self.states) {
            let apart = |(a, b): (&Dd, &f64)| (a.to_f64() - b).abs();
            let (u, v) = own.split_at(own.len() / 2);
            let displacements = known.state.u.iter().zip(u).map(|pair| apart(pair) / 1e-3);
            let velocities = known.state.v.iter().zip(v).map(apart);
            let all = displacements.chain(velocities);
            error = all.fold(error, |max, e| if e.is_finite() { max.max(e) } else { f64::MAX });
        }
        let mut own: Vec<_> = self.events.iter().filter(|e| e.0 <= task.end).collect();
        let (mut found, mut missed) = (0, 0);
        for event in exact.events.iter().filter(|e| e.time.to_f64() <= task.end) {
            let same =
                |o: &&(f64, Event)| o.1 == event.event && (o.0 - event.time.to_f64()).abs() < SAME;
            match own.iter().position(same) {
                Some(i) => {
                    own.remove(i);
                    found += 1;
                }
                None => missed += 1,
            }
        }
        Verdict { error, found, missed, spurious: own.len() }
    }
}

/// A solver with a chosen accuracy.
pub trait Peer {
    /// Solves the task from rest.
    ///
    /// # Errors
    /// The solver's own failure, in words.
    fn run(&mut self, task: &Task) -> Result<Answer, String>;
}
