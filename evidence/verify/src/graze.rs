//! Grazes: what is just reached, and just missed.

use crate::hard::{Case, missed};
use crate::mesh;
use crate::monitor::{Monitored, Violation};
use hammer::{Event, Fidelity, Input, InputValues, Parameters, RockEvent, Source};

/// What is done in a case; the string is the outcome.
type Play = fn(&mut Monitored) -> Result<String, Violation>;
/// Q2: the tip turns while viscous work is done.
const TURN: Event = Event::Rock(RockEvent::DissipativeTurn);
/// Q3: the barrier is reached.
const BARRIER: Event = Event::Rock(RockEvent::Barrier);

/// A piston thrown at the bit and braked so that it turns `excess` beyond touching.
fn thrown(name: &'static str, setting: &'static str, excess: f64, play: Play) -> Case {
    let mut p = Parameters::default();
    p.drive.source = Source::Force;
    p.gravity = 0.0;
    p.contact.initial_gap = 1e-3;
    let brake = 1000.0;
    let reach = p.contact.initial_gap + excess;
    p.piston.initial_velocity = (2.0 * brake / p.piston_mass() * reach).sqrt();
    let inputs = InputValues { drive_force: -brake, ..mesh::no_inputs() };
    Case { name, setting, parameters: p, inputs, allowed: 100_000, play: Box::new(play) }
}

fn touches(w: &mut Monitored) -> Result<String, Violation> {
    w.run(0.02, 20)?;
    let journal = w.machine.take_journal();
    let closings = journal.iter().filter(|r| r.event.is_contact()).count();
    if closings >= 2 && closings % 2 == 0 {
        Ok(format!("touched, {closings} crossings of the gap"))
    } else {
        Err(missed("touch", w))
    }
}

fn misses(w: &mut Monitored) -> Result<String, Violation> {
    w.run(0.02, 20)?;
    if w.machine.counters().contacts == 0 {
        Ok("not touched".into())
    } else {
        Err(missed("miss", w))
    }
}

/// Within rounding of the gap either answer is right; the work must stay bounded.
fn either(w: &mut Monitored) -> Result<String, Violation> {
    w.run(0.02, 20)?;
    let c = w.machine.counters();
    Ok(format!("{} touches", c.contacts))
}

/// The rigid bit leaves the rock and is brought back to it at no speed, by a feed that
/// turns at quarters of the way.
fn brought_back(excess: f64, play: Play, name: &'static str, setting: &'static str) -> Case {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    p.drive.source = Source::Force;
    p.gravity = 0.0;
    p.contact.initial_gap = 1.0;
    let inputs = InputValues { feed_force: -PULL, drive_force: excess, ..mesh::no_inputs() };
    Case { name, setting, parameters: p, inputs, allowed: 100_000, play: Box::new(play) }
}

const PULL: f64 = 100.0;
/// A quarter of the way, s: dyadic, so that the way back is exact but for sums.
const QUARTER: f64 = 1.0 / 1024.0;

fn come_back(w: &mut Monitored, stretch: f64) -> Result<u64, Violation> {
    w.run(QUARTER, 2)?;
    w.machine.set_input(Input::FeedForce, &[PULL])?;
    w.run(2.0 * QUARTER + stretch, 2)?;
    w.machine.set_input(Input::FeedForce, &[-PULL])?;
    w.run(3.0 * QUARTER, 6)?;
    Ok(w.machine.counters().rock_cycles)
}

fn reaches_rock(w: &mut Monitored) -> Result<String, Violation> {
    let cycles = come_back(w, 1e-6)?;
    if cycles > 0 {
        Ok(format!("reached, {cycles} drilling cycles"))
    } else {
        Err(missed("rock", w))
    }
}

fn misses_rock(w: &mut Monitored) -> Result<String, Violation> {
    let cycles = come_back(w, -1e-6)?;
    if cycles == 0 { Ok("not reached".into()) } else { Err(missed("rock missed", w)) }
}

fn grazes_rock(w: &mut Monitored) -> Result<String, Violation> {
    let cycles = come_back(w, 0.0)?;
    Ok(format!("{cycles} drilling cycles"))
}

/// Viscous work that the first main cycle would do if nothing stopped it.
fn full_work() -> f64 {
    let mut p = struck();
    p.rock.energy_barrier = 1e12;
    let Ok(mut m) = hammer::Machine::new(&p, &mesh::no_inputs(), 0.0) else { return f64::NAN };
    m.keep_journal(true);
    let mut time = 0.0;
    while time < 2e-3 && !m.take_journal().iter().any(|r| r.event == TURN) {
        time += 1e-6;
        if m.advance(time).is_err() {
            return f64::NAN;
        }
    }
    m.energies().viscous
}

/// A rigid hammer whose first blow is one smooth drilling cycle.
fn struck() -> Parameters {
    let mut p = mesh::bare(1);
    p.fidelity = Fidelity::Rigid;
    p.rock.viscosity = Parameters::default().rock.viscosity * 0.1;
    p
}

fn barrier(name: &'static str, setting: &'static str, factor: f64, play: Play) -> Case {
    let mut p = struck();
    p.rock.energy_barrier = full_work() * factor;
    Case {
        name,
        setting,
        parameters: p,
        inputs: mesh::no_inputs(),
        allowed: 100_000,
        play: Box::new(play),
    }
}

fn first_turn(w: &mut Monitored) -> Result<Option<Event>, Violation> {
    w.run(1e-3, 50)?;
    let journal = w.machine.take_journal();
    Ok(journal.iter().map(|r| r.event).find(|e| [TURN, BARRIER].contains(e)))
}

fn barrier_met(w: &mut Monitored) -> Result<String, Violation> {
    match first_turn(w)? {
        Some(BARRIER) => Ok("Q3 came first".into()),
        _ => Err(missed("barrier met", w)),
    }
}

fn barrier_missed(w: &mut Monitored) -> Result<String, Violation> {
    match first_turn(w)? {
        Some(TURN) => Ok("Q2 came first".into()),
        _ => Err(missed("barrier missed", w)),
    }
}

fn barrier_either(w: &mut Monitored) -> Result<String, Violation> {
    let first = first_turn(w)?.map_or("none".into(), |event| event.to_string());
    Ok(format!("{first} came first"))
}

/// All grazes.
pub fn cases() -> Vec<Case> {
    vec![
        thrown(
            "piston_touches_by_a_nanometre",
            "turns 1 nm beyond the bit's face: two crossings within microseconds",
            1e-9,
            touches,
        ),
        thrown("piston_touches_by_a_picometre", "turns 1 pm beyond the bit's face", 1e-12, touches),
        thrown("piston_misses_by_a_picometre", "turns 1 pm before the bit's face", -1e-12, misses),
        thrown("piston_grazes", "turns on the bit's face, to rounding", 0.0, either),
        brought_back(
            0.0,
            reaches_rock,
            "bit_reaches_rock",
            "brought back to the rock with 0.06 mm/s to spare",
        ),
        brought_back(0.0, misses_rock, "bit_misses_rock", "turned just before the rock"),
        brought_back(
            0.0,
            grazes_rock,
            "bit_grazes_rock",
            "brought back to the rock at no speed, at a communication point",
        ),
        barrier(
            "barrier_just_met",
            "WR below the cycle's viscous work by 1e-9",
            1.0 - 1e-9,
            barrier_met,
        ),
        barrier(
            "barrier_just_missed",
            "WR above the cycle's viscous work by 1e-9",
            1.0 + 1e-9,
            barrier_missed,
        ),
        barrier(
            "barrier_grazed",
            "WR equal to the cycle's viscous work, to rounding",
            1.0,
            barrier_either,
        ),
    ]
}
