//! The engine itself, seen as one more solver.

use crate::trajectory::{Peer, Shown, Task, Trajectory};
use hammer::{InputValues, Kinematics, Machine, Parameters};
use verify::{reference, scene};

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

impl Peer for Engine {
    fn run(&mut self, task: &Task) -> Result<Trajectory, String> {
        let mut machine = machine(&self.parameters);
        machine.keep_journal(true);
        let mut done = Trajectory::default();
        for stop in task.stops() {
            machine.advance(stop).map_err(|e| e.to_string())?;
            if done.shown.len() < task.instants.len() {
                done.shown.push(shown(machine.kinematics()));
                done.states.push(reference::nodal(&machine));
            }
        }
        done.events = machine.take_journal().iter().map(|r| (r.time, scene::event(r))).collect();
        Ok(done)
    }
}
