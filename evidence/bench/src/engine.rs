//! The engine as one of the solvers. It has no tolerance to choose.

use crate::schema::{Answer, Peer, Task};
use hammer::{InputValues, Machine, Parameters};
use oracles::law::State;
use verify::scene;

/// The engine and its scene.
pub struct Engine(pub Parameters);

/// A machine at rest.
///
/// # Panics
/// The engine refuses the parameters.
pub fn machine(parameters: &Parameters) -> Machine {
    Machine::new(parameters, &InputValues::default(), 0.0).expect("a valid scene")
}

impl Peer for Engine {
    fn run(&mut self, task: &Task) -> Result<Answer, String> {
        let mut machine = machine(&self.0);
        machine.keep_journal(true);
        let mut done = Answer::default();
        for stop in task.stops() {
            machine.advance(stop).map_err(|e| e.to_string())?;
            let profile = machine.profile();
            let (u, v) = profile.piston.iter().chain(&profile.bit).map(|[u, v]| (*u, *v)).unzip();
            done.keep(task, &State { u, v, psi: machine.viscous_work_of_cycle() });
        }
        done.events =
            machine.take_journal().iter().map(|r| (r.time, scene::event(r, false))).collect();
        Ok(done)
    }
}
