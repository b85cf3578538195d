//! Scaling laws on the reference hammer: exact, but for the resolutions of the guards, which
//! are lengths and speeds and do not scale.

use crate::draw::{Draw, heavier, larger};
use crate::row::{Row, Rows};
use hammer::{Error, InputValues, Machine, Parameters, Record};

/// The first blow of the reference hammer: in its second a tip grazes zero by less than the
/// resolution, which a hammer twice as large decides otherwise.
fn first_blow() -> Draw {
    let (parameters, inputs) = (Parameters::default(), InputValues::default());
    Draw { parameters, inputs, duration: 1.0, cuts: vec![] }
}

/// Events and the tip's place at the end.
fn run(draw: &Draw) -> Result<(Vec<Record>, f64), Error> {
    let mut m = Machine::new(&draw.parameters, &draw.inputs, 0.0)?;
    m.keep_journal(true);
    m.advance(0.05)?;
    Ok((m.take_journal(), m.kinematics().bit_tip_position))
}

/// Largest difference of an event's time; infinite if the events are others.
fn apart(a: &[Record], b: &[Record]) -> f64 {
    if a.len() != b.len() || a.iter().zip(b).any(|(x, y)| (x.event, x.mode) != (y.event, y.mode)) {
        return f64::INFINITY;
    }
    let off = |(x, y): (&Record, &Record)| ((x.time - y.time) + (x.time_rest - y.time_rest)).abs();
    a.iter().zip(b).map(off).fold(0.0, f64::max)
}

const EXACT: &str = "none: a power of four changes no digit of any product or square root";
const RESOLVED: &str = "resolution of a velocity guard, 1e-9 m/s, over the smallest slope at a crossing, 10 m/s2; the larger at b below 1, over b";

/// Closed form 7.
///
/// # Errors
/// Whatever the engine says.
pub fn rows() -> Result<Vec<Row>, Error> {
    let scene = first_blow();
    let (events, tip) = run(&scene)?;
    let mut list = Vec::new();
    for a in [16.0, 1.0 / 64.0] {
        let (ours, place) = run(&heavier(&scene, a))?;
        let case = format!("first blow; masses, stiffnesses, viscosities, forces, WR times {a}");
        let mut rows = Rows::new(case, "scaling law", EXACT);
        rows.add("largest difference of an event's time, s", 0.0, apart(&events, &ours), 0.0);
        rows.add("place of the tip, m", tip, place, 0.0);
        list.extend(rows.list);
    }
    for b in [0.25, 2.0, 8.0] {
        let (ours, place) = run(&larger(&scene, b))?;
        let case = format!("first blow; displacements, velocities, forces times {b}, WR times b^2");
        let mut rows = Rows::new(case, "scaling law", RESOLVED);
        let late = 1e-10 / b.min(1.0);
        rows.add("largest difference of an event's time, s", 0.0, apart(&events, &ours), late);
        // No faster than the piston.
        rows.add("place of the tip / b, m", tip, place / b, late * 20.0);
        list.extend(rows.list);
    }
    Ok(list)
}
