//! What a solver produced, and how far it is from the reference.

use crate::law::{Event, State};
use crate::reference::{Record, distance};
use serde::{Deserialize, Serialize};

/// Two events are the same if their times differ by less than this, s.
const SAME: f64 = 2e-7;

/// What every solver is asked for.
#[derive(Clone, Debug)]
pub struct Task {
    /// Instants at which the state is wanted, s, ascending.
    pub instants: Vec<f64>,
    /// End of the integration, s.
    pub end: f64,
    /// Wall-clock seconds after which to give up.
    pub patience: f64,
}

impl Task {
    /// One pressure cycle from rest, with the six instants of the first 20 ms.
    pub fn cycle(record: &Record) -> Self {
        let instants = record.states.iter().map(|s| s.time).filter(|&t| t <= 20e-3).collect();
        Self { instants, end: 45.389e-3, patience: 60.0 }
    }

    /// The interesting times: instants, then the end.
    pub fn stops(&self) -> impl Iterator<Item = f64> {
        self.instants.iter().copied().filter(|&t| t < self.end).chain([self.end])
    }
}

/// A computed solution.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// States at the instants.
    pub states: Vec<State<f64>>,
    /// Transitions, s.
    pub events: Vec<(f64, Event)>,
}

/// A solution judged.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Verdict {
    /// Worst state error: displacements over 1 mm, velocities over 1 m/s.
    pub error: f64,
    /// Events of the reference that were found.
    pub found: usize,
    /// Events of the reference that were not.
    pub missed: usize,
    /// Events that the reference does not have.
    pub spurious: usize,
}

impl Trajectory {
    /// Compares with the reference over the task.
    pub fn judge(&self, record: &Record, task: &Task) -> Verdict {
        let known = record.states.iter().filter(|s| task.instants.contains(&s.time));
        let error = known.zip(&self.states).fold(0.0f64, |max, (reference, state)| {
            let psi = reference.psi;
            let reference = State { u: reference.u.clone(), v: reference.v.clone(), psi };
            // A NaN must not pass for a small error.
            let d = distance(&reference, state);
            if d.is_finite() { max.max(d) } else { f64::INFINITY }
        });
        let complete = self.states.len() == task.instants.len();
        let mut own: Vec<_> = self.events.iter().filter(|e| e.0 <= task.end).collect();
        let (mut found, mut missed) = (0, 0);
        for event in record.events.iter().filter(|e| e.time <= task.end) {
            let same = |o: &&(f64, Event)| o.1 == event.event && (o.0 - event.time).abs() < SAME;
            match own.iter().position(same) {
                Some(i) => {
                    own.remove(i);
                    found += 1;
                }
                None => missed += 1,
            }
        }
        let error = if complete { error } else { f64::INFINITY };
        Verdict { error, found, missed, spurious: own.len() }
    }
}

/// A solver of the hammer with its accuracy chosen.
pub trait Peer {
    /// Solves the task from rest.
    ///
    /// # Errors
    /// The solver's own failure, in words.
    fn run(&mut self, task: &Task) -> Result<Trajectory, String>;
}
