//! Grazes in closed form: levels that are just reached, and just missed. Within rounding of a level both answers are
//! right, and none is tested.

use super::mesh;
use super::row::{Row, Rows};
use hammer::{Error, Event, Fidelity, Input, InputValues, Machine, Parameters, RockEvent, Source};

/// Q2: the tip turns while viscous work is done. Then Q3: the barrier is reached.
const TURN: Event = Event::Rock(RockEvent::DissipativeTurn);
const BARRIER: Event = Event::Rock(RockEvent::Barrier);
const WHY: &str = "none: a thousand times the resolution of a guard on either side, but for the picometre, a hundred times";

fn weightless(gap: f64) -> Parameters {
    let mut p = Parameters { gravity: 0.0, ..Parameters::default() };
    (p.drive.source, p.contact.initial_gap) = (Source::Force, gap);
    p
}

/// True if the piston touches the bit. It is thrown and braked so that it would turn `excess` beyond touching.
fn touches(excess: f64) -> Result<bool, Error> {
    let mut p = weightless(1e-3);
    let brake = 1000.0;
    let reach = p.contact.initial_gap + excess;
    p.piston.initial_velocity = (2.0 * brake / p.piston_mass() * reach).sqrt();
    let inputs = InputValues { drive_force: -brake, ..mesh::no_inputs() };
    let mut m = Machine::new(&p, &inputs, 0.0)?;
    m.advance(0.02)?;
    Ok(m.counters().contacts > 0)
}

/// True if the rigid bit begins a drilling cycle. It leaves the rock and is brought back by a feed that changes sign
/// at quarters of the time, a dyadic number, or later by `stretch` (s).
fn drills(stretch: f64) -> Result<bool, Error> {
    let (pull, quarter) = (100.0, 1.0 / 1024.0);
    let p = Parameters { fidelity: Fidelity::Rigid, ..weightless(1.0) };
    let inputs = InputValues { feed_force: -pull, ..mesh::no_inputs() };
    let mut m = Machine::new(&p, &inputs, 0.0)?;
    for (feed, until) in [(pull, 1.0), (-pull, 3.0)] {
        m.advance(if until > 1.0 { until * quarter + stretch } else { quarter })?;
        m.set_input(Input::FeedForce, &[feed])?;
    }
    m.advance(6.0 * quarter)?;
    Ok(m.counters().rock_cycles > 0)
}

/// The first blow of a rigid hammer, in a single smooth drilling cycle: which of turn and barrier comes first, and
/// when.
fn first(barrier: f64) -> Result<(Option<Event>, f64), Error> {
    let mut p = mesh::bare(1);
    p.fidelity = Fidelity::Rigid;
    p.rock.viscosity = Parameters::default().rock.viscosity * 0.1;
    p.rock.energy_barrier = barrier;
    let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
    m.keep_journal(true);
    for step in 1..2000 {
        m.advance(1e-6 * f64::from(step))?;
        let found = m.take_journal().into_iter().map(|r| r.event);
        if let Some(event) = found.into_iter().find(|e| [TURN, BARRIER].contains(e)) {
            return Ok((Some(event), m.energies().viscous));
        }
    }
    Ok((None, f64::NAN))
}

/// All grazes: 1 for an event that must happen, 0 for one that must not.
///
/// # Errors
/// Those of the engine.
pub fn rows() -> Result<Vec<Row>, Error> {
    let mut rows = Rows::new("grazes", "closed form", WHY);
    let mut add = |what: &str, wanted: bool, found: bool| {
        rows.add(what, f64::from(u8::from(wanted)), f64::from(u8::from(found)), 0.0);
    };
    for (what, excess) in [("nanometre", 1e-9), ("picometre", 1e-12)] {
        add(
            &format!("a piston turns a {what} beyond the bit's face: touches"),
            true,
            touches(excess)?,
        );
    }
    add("a piston turns a picometre before it: touches", false, touches(-1e-12)?);
    // Half a microsecond more of pulling or pushing makes 0.06 mm/s.
    add("a bit is brought back with 0.06 mm/s to spare: drills", true, drills(1e-6)?);
    add("a bit is turned just before the rock: drills", false, drills(-1e-6)?);
    let (_, full) = first(1e12)?;
    for (what, part) in [("below", 1.0 - 1e-9), ("above", 1.0 + 1e-9)] {
        let met = first(part * full)?.0 == Some(BARRIER);
        add(&format!("WR is {what} the viscous work by 1e-9: the barrier is met"), part < 1.0, met);
    }
    Ok(rows.list)
}
