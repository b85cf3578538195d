//! Two blows of the reference hammer against the stored solutions of the crate `oracles`: Taylor
//! series in double-double arithmetic of an independently assembled model.

use crate::row::{Row, Rows};
use crate::scene;
use hammer::presets::Preset;
use hammer::{Error, InputValues, Machine, Parameters};
use oracles::law::State;
use oracles::reference::{EventRecord, MESHES, Record, distance, stored};

/// Why there are no rows.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] std::io::Error),
    /// The engine says so.
    #[error(transparent)]
    Engine(#[from] Error),
    /// There is no hammer of a datasheet.
    #[error(transparent)]
    Datasheet(#[from] hammer::datasheet::DatasheetError),
}

/// The reference hammer in very viscous rock, on linear elements.
///
/// # Panics
/// Never: the preset exists.
pub fn overdamped() -> Parameters {
    Preset::named("overdamped").expect("a preset").start().0
}

/// The hammer whose solutions are stored, on linear elements, with so many of them per bar: the oracles
/// have no others.
pub fn hammer(elements: usize) -> Parameters {
    let mut p = overdamped();
    (p.piston.elements, p.bit.elements) = (elements, elements);
    p
}

/// Nodes of both bodies, top to bottom.
pub fn nodal(machine: &Machine) -> State<f64> {
    let profile = machine.profile();
    let (u, v) = profile.piston.iter().chain(&profile.bit).map(|[u, v]| (*u, *v)).unzip();
    State { u, v, psi: machine.viscous_work_of_cycle() }
}

const WHY: &str = "state: rounding (1e-16 of displacements of 0.05 m, 1e-14 of 1 mm and so on) multiplied at each touch of the rock, by 1e1 to 1e3; events: resolution of a velocity guard, 1e-9 m/s, over the smallest slope at a crossing, 10 m/s2 (a tip that creeps back into the rock)";

/// Largest error of the state before the second blow and from it on, displacements over 1 mm,
/// velocities over 1 m/s.
fn states(theirs: &Record, p: &Parameters) -> Result<[f64; 2], Failure> {
    let mut machine = Machine::new(p, &InputValues::default(), 0.0)?;
    let mut worst = [0.0f64; 2];
    for known in &theirs.states {
        machine.advance(known.time)?;
        let own = nodal(&machine);
        let known = State { u: known.u.clone(), v: known.v.clone(), psi: known.psi };
        let part = &mut worst[usize::from(machine.counters().blows > 1)];
        *part = part.max(distance(&own, &known));
    }
    Ok(worst)
}

/// States; events, their order and the largest difference of their times.
///
/// # Errors
/// A file that cannot be read; whatever the engine says.
pub fn rows() -> Result<Vec<Row>, Failure> {
    let mut list = Vec::new();
    for elements in MESHES {
        let (theirs, p) = (stored(elements)?, hammer(elements));
        let case = format!("reference hammer, two blows, {elements} elements");
        let mut rows = Rows::new(case, "double-double Taylor series (oracles)", WHY);
        let [first, second] = states(&theirs, &p)?;
        let state = |until: &str| format!("largest error of the state {until} the second blow");
        rows.add(state("before"), 0.0, first, 1e-9);
        rows.add(state("from"), 0.0, second, 1e-7);
        let mut m = Machine::new(&p, &InputValues::default(), 0.0)?;
        m.keep_journal(true);
        m.advance(theirs.events.last().map_or(0.0, |e| e.time) + 1e-6)?;
        let ours = m.take_journal();
        let pairs = || ours.iter().zip(&theirs.events);
        let same = |(r, e): &(&hammer::Record, &EventRecord)| {
            scene::mode(&p, r.mode) == e.mode && scene::event(r, p.has_casing()) == e.event
        };
        let alike = pairs().filter(same).count();
        let off = |(r, e): (&hammer::Record, &EventRecord)| {
            ((r.time - e.time) + (r.time_rest - e.time_rest)).abs()
        };
        let worst = pairs().map(off).fold(0.0, f64::max);
        let count = theirs.events.len() as f64;
        rows.add("events", count, ours.len() as f64, 0.0);
        rows.add("events of the same kind that enter the same mode", count, alike as f64, 0.0);
        let tolerance = 1e-10 + theirs.event_uncertainty;
        rows.add("largest difference of an event's time, s", 0.0, worst, tolerance);
        list.extend(rows.list);
    }
    Ok(list)
}
