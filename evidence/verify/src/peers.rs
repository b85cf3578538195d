//! Every event of two blows against the stored solution of `oracles`: a Taylor series in
//! double-double arithmetic of an independently assembled model.

use crate::row::{Row, Rows};
use hammer::{InputValues, Machine, Parameters, RockMode};
use serde::Deserialize;
use std::path::Path;

/// Meshes whose solution is stored.
pub const MESHES: [usize; 4] = [5, 10, 20, 40];

/// A stored solution.
#[derive(Deserialize)]
struct Stored {
    event_uncertainty: f64,
    events: Vec<Event>,
}

#[derive(Deserialize)]
struct Event {
    time: f64,
    time_rest: f64,
    mode: Mode,
}

#[derive(Deserialize, PartialEq)]
struct Mode {
    closed: bool,
    rock: String,
    down: bool,
}

/// Why there are no rows.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] std::io::Error),
    /// It is not what it was.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// The engine says so.
    #[error(transparent)]
    Engine(#[from] hammer::Error),
}

fn stored(elements: usize) -> Result<Stored, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../oracles/data");
    let text = std::fs::read_to_string(folder.join(format!("reference_{elements}.json")))?;
    Ok(serde_json::from_str(&text)?)
}

fn mode(mode: hammer::Mode) -> Mode {
    let rock = match mode.rock {
        RockMode::FreeFlight => "FF",
        RockMode::DissipativeForward => "DFC",
        RockMode::Forward => "FC",
        RockMode::Backward => "BC",
        RockMode::Standstill => "SS",
    };
    Mode { closed: mode.closed, rock: rock.into(), down: mode.relay == hammer::Relay::Drive }
}

const WHY: &str = "resolution of a velocity guard, 1e-9 m/s, over the smallest slope at a crossing, 10 m/s2 (a tip that creeps back into the rock)";

/// Events, their order and the largest difference of their times.
///
/// # Errors
/// A file that cannot be read; whatever the engine says.
pub fn rows() -> Result<Vec<Row>, Failure> {
    let mut list = Vec::new();
    for elements in MESHES {
        let theirs = stored(elements)?;
        let mut p = Parameters::default();
        (p.piston.elements, p.bit.elements) = (elements, elements);
        let mut m = Machine::new(&p, &InputValues::default(), 0.0)?;
        m.keep_journal(true);
        m.advance(theirs.events.last().map_or(0.0, |e| e.time) + 1e-6)?;
        let ours = m.take_journal();
        let pairs = || ours.iter().zip(&theirs.events);
        let alike = pairs().filter(|(r, e)| mode(r.mode) == e.mode).count();
        let off = |(r, e): (&hammer::Record, &Event)| {
            ((r.time - e.time) + (r.time_rest - e.time_rest)).abs()
        };
        let worst = pairs().map(off).fold(0.0, f64::max);
        let case = format!("reference hammer, two blows, {elements} elements");
        let mut rows = Rows::new(case, "double-double Taylor series (oracles)", WHY);
        let count = theirs.events.len() as f64;
        rows.add("events", count, ours.len() as f64, 0.0);
        rows.add("events that enter the same mode", count, alike as f64, 0.0);
        let tolerance = 1e-10 + theirs.event_uncertainty;
        rows.add("largest difference of an event's time, s", 0.0, worst, tolerance);
        list.extend(rows.list);
    }
    Ok(list)
}
