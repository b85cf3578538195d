//! The engine itself, seen as one more solver.

use crate::trajectory::{Peer, Shown, Task, Trajectory};
use hammer::{InputValues, Kinematics, Machine, Parameters, Record};
use oracles::law::{Event, State};

/// The engine; it has no tolerance to choose.
pub struct Engine {
    /// The scene.
    pub parameters: Parameters,
}

/// A machine at rest.
///
/// # Panics
/// The engine refuses the parameters.
pub fn machine(parameters: &Parameters) -> Machine {
    Machine::new(parameters, &InputValues::default(), 0.0).expect("a valid scene")
}

/// What the engine shows now.
pub fn shown(k: &Kinematics) -> Shown {
    Shown {
        displacements: [k.piston_position, k.bit_position, k.bit_tip_position, k.contact_gap],
        velocities: [k.piston_velocity, k.bit_velocity, k.bit_tip_velocity],
    }
}

/// Nodes of both bodies, top to bottom.
fn nodal(machine: &mut Machine) -> State<f64> {
    let profile = machine.profile();
    let (u, v) = profile.piston.iter().chain(&profile.bit).map(|[u, v]| (*u, *v)).unzip();
    State { u, v, psi: machine.state().psi }
}

fn event(record: &Record) -> Event {
    match record.event {
        "Q11" if record.mode.closed => Event::Close,
        "Q11" => Event::Open,
        "Q1" => Event::Q1,
        "Q2" => Event::Q2,
        "Q3" => Event::Q3,
        "Q4" => Event::Q4,
        "Q5" => Event::Q5,
        "Q6" => Event::Q6,
        "Q7" => Event::Q7,
        "Q8" => Event::Q8,
        "Q9" => Event::Q9,
        "Q10" => Event::Q10,
        _ => Event::LiftOff,
    }
}

impl Peer for Engine {
    fn run(&mut self, task: &Task) -> Result<Trajectory, String> {
        let mut machine = machine(&self.parameters);
        machine.keep_journal(true);
        let mut done = Trajectory::default();
        for stop in task.stops() {
            machine.advance(stop).map_err(|e| e.to_string())?;
            if done.shown.len() < task.instants.len() {
                done.shown.push(shown(machine.kinematics()));
                done.states.push(nodal(&mut machine));
            }
        }
        done.events = machine.take_journal().iter().map(|r| (r.time, event(r))).collect();
        Ok(done)
    }
}
