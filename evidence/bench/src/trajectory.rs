//! What a solver produced, and how far it is from the reference.

use oracles::law::{Event, State};
use oracles::model::Model;
use oracles::reference::{Record, distance};
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

/// What every solver shows, the FMU too: displacements of piston mean, bit mean,
/// tip and gap, m; velocities of the first three, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shown {
    /// Displacements, m.
    pub displacements: [f64; 4],
    /// Velocities, m/s.
    pub velocities: [f64; 3],
}

impl Shown {
    /// Reads it off nodal values.
    pub fn of(model: &Model<f64>, u: &[f64], v: &[f64]) -> Self {
        let mean = |x: &[f64], nodes: std::ops::Range<usize>| -> f64 {
            // The row holds weights of opposite sign for the two bodies.
            nodes.map(|i| model.relative[i].abs() * x[i]).sum()
        };
        let (bit, n) = (model.bit, model.nodes());
        let row = |x: &[f64]| [mean(x, 0..bit), mean(x, bit..n), x[n - 1]];
        let ([piston, bit, tip], gap) = (row(u), model.gap(u));
        let gap = gap + model.scene.gap;
        Self { displacements: [piston, bit, tip, gap], velocities: row(v) }
    }

    /// Worst difference, displacements over 1 mm, velocities over 1 m/s.
    pub fn distance(&self, other: &Self) -> f64 {
        let worst = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()))
        };
        let displacement = worst(&self.displacements, &other.displacements) / 1e-3;
        displacement.max(worst(&self.velocities, &other.velocities))
    }
}

/// A computed solution.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// States at the instants, of solvers that give them.
    pub states: Vec<State<f64>>,
    /// What is shown at the instants, of those that do not.
    pub shown: Vec<Shown>,
    /// Transitions, s.
    pub events: Vec<(f64, Event)>,
}

/// A solution judged.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Verdict {
    /// Worst error of every nodal displacement over 1 mm and velocity over 1 m/s;
    /// of the FMU, whose outputs are not of nodes, the same as `shown`.
    pub error: f64,
    /// Worst error of what is [`Shown`], over the same.
    pub shown: f64,
    /// Events of the reference that were found.
    pub found: usize,
    /// Events of the reference that were not.
    pub missed: usize,
    /// Events that the reference does not have.
    pub spurious: usize,
}

/// A NaN must not pass for a small error; JSON has no infinity.
fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |max, e| if e.is_finite() { max.max(e) } else { f64::MAX })
}

impl Trajectory {
    /// Compares with the reference over the task.
    pub fn judge(&self, model: &Model<f64>, record: &Record, task: &Task) -> Verdict {
        let known: Vec<_> =
            record.states.iter().filter(|s| task.instants.contains(&s.time)).collect();
        let own: Vec<Shown> = if self.states.is_empty() {
            self.shown.clone()
        } else {
            self.states.iter().map(|s| Shown::of(model, &s.u, &s.v)).collect()
        };
        let mut shown =
            worst(known.iter().zip(&own).map(|(k, s)| Shown::of(model, &k.u, &k.v).distance(s)));
        let mut error = worst(
            known
                .iter()
                .zip(&self.states)
                .map(|(k, s)| distance(&State { u: k.u.clone(), v: k.v.clone(), psi: k.psi }, s)),
        );
        if self.states.is_empty() {
            error = shown;
        }
        if own.len() != task.instants.len() {
            (error, shown) = (f64::MAX, f64::MAX);
        }
        let (found, missed, spurious) = self.compare_events(record, task);
        Verdict { error, shown, found, missed, spurious }
    }

    fn compare_events(&self, record: &Record, task: &Task) -> (usize, usize, usize) {
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
        (found, missed, own.len())
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
