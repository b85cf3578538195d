//! Stored reference solutions: of two runs of [`crate::run`] with different accuracy, the better one and the
//! difference.

use crate::dd::Dd;
use crate::law::{Event, Memory, Mode, Quantity, State};
use crate::linear::Real;
use crate::record::Sampled;
use crate::run::Run;
use crate::scene::Scene;
use crate::taylor::Accuracy;
use serde::{Deserialize, Serialize};

/// The committed form of an event.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EventRecord {
    /// Time, s: nearest `f64`.
    pub time: f64,
    /// Rest of the time beyond the `f64`, s.
    pub time_rest: f64,
    /// Which.
    pub event: Event,
    /// The mode after it.
    pub mode: Mode,
}

/// The committed form of a state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StateRecord {
    /// Time, s.
    pub time: f64,
    /// The mode then.
    pub mode: Mode,
    /// `ul`, `uu`, `dp`, m.
    pub memory: Memory<f64>,
    /// Viscous work of the cycle, J.
    pub psi: f64,
    /// Nodal displacements, piston then bit, m.
    pub u: Vec<f64>,
    /// Nodal velocities, m/s.
    pub v: Vec<f64>,
    /// Piston's mean minus bit's mean minus `g0`, m.
    pub relative: f64,
    /// `F_C`, N.
    pub contact_force: f64,
    /// `F_R`, N.
    pub rock_force: f64,
}

/// A committed reference solution.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// The scene.
    pub scene: Scene,
    /// Order of the series.
    pub order: usize,
    /// Size of the last term kept, over the largest.
    pub tolerance: f64,
    /// Largest difference from a second run of other order and tolerance, at any
    /// instant: displacements over 1 mm, velocities over 1 m/s.
    pub state_uncertainty: f64,
    /// Largest difference of an event's time from that run's, s.
    pub event_uncertainty: f64,
    /// Every transition, in order.
    pub events: Vec<EventRecord>,
    /// States at the instants asked for.
    pub states: Vec<StateRecord>,
}

/// Largest difference, in 1 mm and 1 m/s; `f64::MAX` if any is not finite.
pub fn distance<T: Real>(a: &State<T>, b: &State<T>) -> f64 {
    let worst = |x: &[T], y: &[T], scale: f64| {
        x.iter().zip(y).fold(0.0f64, |max, (&x, &y)| {
            let d = (x - y).to_f64().abs() / scale;
            if d.is_finite() { max.max(d) } else { f64::MAX }
        })
    };
    worst(&a.u, &b.u, 1e-3).max(worst(&a.v, &b.v, 1.0))
}

fn state_record(run: &Run<Dd>, sample: &Sampled<Dd>) -> StateRecord {
    let f64s = |row: &[Dd]| row.iter().map(|x| x.to_f64()).collect();
    let (state, memory) = (&sample.state, &sample.memory);
    let [contact, rock] = sample.forces;
    StateRecord {
        time: sample.time,
        mode: sample.mode,
        memory: Memory {
            ul: memory.ul.to_f64(),
            uu: memory.uu.to_f64(),
            gain: memory.gain.to_f64(),
            turned: memory.turned.to_f64(),
        },
        psi: state.psi.to_f64(),
        u: f64s(&state.u),
        v: f64s(&state.v),
        relative: run.model.quantity(Quantity::Relative, state).to_f64(),
        contact_force: contact.to_f64(),
        rock_force: rock.to_f64(),
    }
}

/// Runs twice, and keeps the better run with the difference.
///
/// # Errors
/// A run was given up, or the two have different sequences of events.
pub fn record(
    scene: &Scene,
    instants: &[f64],
    [best, check]: [Accuracy; 2],
) -> Result<Record, String> {
    let (mut one, mut two) = (Run::<Dd>::new(scene, best), Run::<Dd>::new(scene, check));
    for run in [&mut one, &mut two] {
        run.through(instants, &[]).map_err(|e| e.to_string())?;
    }
    let kinds = |run: &Run<Dd>| run.events.iter().map(|e| e.event).collect::<Vec<_>>();
    if kinds(&one) != kinds(&two) {
        return Err("the two runs disagree on the events".into());
    }
    let pairs = one.samples.iter().zip(&two.samples);
    let times = one.events.iter().zip(&two.events);
    let event = |e: &crate::record::Passed<Dd>| EventRecord {
        time: e.time.hi,
        time_rest: e.time.lo,
        event: e.event,
        mode: e.mode,
    };
    Ok(Record {
        scene: scene.clone(),
        order: best.order,
        tolerance: best.tolerance,
        state_uncertainty: pairs.fold(0.0, |max, (a, b)| max.max(distance(&a.state, &b.state))),
        event_uncertainty: times.fold(0.0, |max, (a, b)| max.max((a.time - b.time).hi.abs())),
        events: one.events.iter().map(event).collect(),
        states: one.samples.iter().map(|sample| state_record(&one, sample)).collect(),
    })
}

/// Elements per bar of the reference hammers whose solutions are stored.
pub const MESHES: [usize; 4] = [5, 10, 20, 40];

/// Instants at which their states are kept: six in the first 20 ms (the first blow is at
/// 13.68 ms, the rebound at 14.39 ms), one before the second blow and four after its start at
/// 57.86 ms, s.
pub const INSTANTS: [f64; 11] =
    [10e-3, 13.72e-3, 14e-3, 15e-3, 17e-3, 20e-3, 46e-3, 58e-3, 59e-3, 62e-3, 70e-3];

/// Where a stored solution is.
pub fn path(elements: usize) -> std::path::PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/data");
    std::path::Path::new(folder).join(format!("reference_{elements}.json"))
}

/// The stored solution of the reference hammer with so many elements per bar.
///
/// # Errors
/// There is none of that mesh, or it cannot be read.
pub fn stored(elements: usize) -> std::io::Result<Record> {
    Ok(serde_json::from_str(&std::fs::read_to_string(path(elements))?)?)
}
