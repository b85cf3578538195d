//! The engine itself, seen as one more solver.

use crate::trajectory::{Peer, Shown, Task, Trajectory};
use hammer::{InputValues, Kinematics, Machine, Parameters, Record, Relay, RockEvent};
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
    State { u, v, psi: machine.viscous_work_of_cycle() }
}

fn event(record: &Record) -> Event {
    match record.event {
        hammer::Event::Contact if record.mode.closed => Event::Close,
        hammer::Event::Contact => Event::Open,
        hammer::Event::Relay(Relay::Return) => Event::Q9,
        hammer::Event::Relay(Relay::Drive) => Event::Q10,
        hammer::Event::Rock(event) => match event {
            RockEvent::Touch => Event::Q1,
            RockEvent::DissipativeTurn => Event::Q2,
            RockEvent::Barrier => Event::Q3,
            RockEvent::Turn => Event::Q4,
            RockEvent::LiftOff => Event::Q5,
            RockEvent::Return => Event::Q6,
            RockEvent::Restart => Event::Q7,
            RockEvent::Retreat => Event::Q8,
            RockEvent::StandstillLiftOff => Event::LiftOff,
        },
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
