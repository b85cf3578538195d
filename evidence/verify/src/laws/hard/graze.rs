//! Grazes: what is just reached, and just missed, by closed forms.

use super::{Case, missed};
use crate::laws::monitor::{Monitored, Violation};
use crate::rows::mesh;
use hammer::{Event, Fidelity, Input, InputValues, Machine, Parameters, RockEvent, Source};

/// True if what happened is what is to happen.
type Judge<T> = fn(T) -> bool;
/// Q2: the tip turns while viscous work is done. Q3: the barrier is reached.
const TURN: Event = Event::Rock(RockEvent::DissipativeTurn);
const BARRIER: Event = Event::Rock(RockEvent::Barrier);

fn weightless(gap: f64) -> Parameters {
    let mut p = Parameters { gravity: 0.0, ..Parameters::default() };
    (p.drive.source, p.contact.initial_gap) = (Source::Force, gap);
    p
}

fn graze(
    (name, setting): (&'static str, &'static str),
    (parameters, inputs): (Parameters, InputValues),
    play: impl Fn(&mut Monitored) -> Result<String, Violation> + 'static,
) -> Case {
    Case { name, setting, parameters, inputs, allowed: 100_000, play: Box::new(play) }
}

/// A piston thrown at the bit and braked so that it turns `excess` beyond touching: how often it touches.
fn thrown(said: (&'static str, &'static str), excess: f64, judge: Judge<u64>) -> Case {
    let mut p = weightless(1e-3);
    let brake = 1000.0;
    let reach = p.contact.initial_gap + excess;
    p.piston.initial_velocity = (2.0 * brake / p.piston_mass() * reach).sqrt();
    let inputs = InputValues { drive_force: -brake, ..mesh::no_inputs() };
    graze(said, (p, inputs), move |w| {
        w.run(0.02, 20)?;
        let touched = w.machine.counters().contacts;
        if judge(touched) { Ok(format!("{touched} touches")) } else { Err(missed("touch", w)) }
    })
}

const PULL: f64 = 100.0;
/// A quarter of the way, s: dyadic, so that the way back is exact but for sums.
const QUARTER: f64 = 1.0 / 1024.0;

/// The rigid bit leaves the rock and is brought back to it, by a feed that turns at quarters of the way, or
/// later by `stretch` (s): how many drilling cycles it begins.
fn brought_back(said: (&'static str, &'static str), stretch: f64, judge: Judge<u64>) -> Case {
    let p = Parameters { fidelity: Fidelity::Rigid, ..weightless(1.0) };
    let inputs = InputValues { feed_force: -PULL, ..mesh::no_inputs() };
    graze(said, (p, inputs), move |w| {
        w.run(QUARTER, 2)?;
        w.machine.set_input(Input::FeedForce, &[PULL])?;
        w.run(2.0 * QUARTER + stretch, 2)?;
        w.machine.set_input(Input::FeedForce, &[-PULL])?;
        w.run(3.0 * QUARTER, 6)?;
        let cycles = w.machine.counters().rock_cycles;
        if judge(cycles) { Ok(format!("{cycles} drilling cycles")) } else { Err(missed("rock", w)) }
    })
}

/// A rigid hammer whose first blow is one smooth drilling cycle.
fn struck() -> Parameters {
    let mut p = mesh::bare(1);
    p.fidelity = Fidelity::Rigid;
    p.rock.viscosity = Parameters::default().rock.viscosity * 0.1;
    p
}

/// Viscous work that the first main cycle would do if nothing stopped it.
fn full_work() -> f64 {
    let mut p = struck();
    p.rock.energy_barrier = 1e12;
    let Ok(mut m) = Machine::new(&p, &mesh::no_inputs(), 0.0) else { return f64::NAN };
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

/// A barrier of a part of that work: which comes first.
fn barrier(said: (&'static str, &'static str), part: f64, judge: Judge<Event>) -> Case {
    let mut p = struck();
    p.rock.energy_barrier = full_work() * part;
    graze(said, (p, mesh::no_inputs()), move |w| {
        w.run(1e-3, 50)?;
        let journal = w.machine.take_journal();
        match journal.iter().map(|r| r.event).find(|e| [TURN, BARRIER].contains(e)) {
            Some(event) if judge(event) => Ok(format!("{event} came first")),
            _ => Err(missed("barrier or turn", w)),
        }
    })
}

/// All grazes. Within rounding of the level either answer is right; the work must stay bounded.
pub fn cases() -> Vec<Case> {
    let either = |_| true;
    vec![
        thrown(("piston_touches_by_a_nanometre", "turns 1 nm beyond the bit's face"), 1e-9, |n| {
            n > 0
        }),
        thrown(("piston_touches_by_a_picometre", "turns 1 pm beyond the bit's face"), 1e-12, |n| {
            n >= 2 && n.is_multiple_of(2)
        }),
        thrown(("piston_misses_by_a_picometre", "turns 1 pm before it"), -1e-12, |n| n == 0),
        thrown(("piston_grazes", "turns on the bit's face, to rounding"), 0.0, either),
        brought_back(("bit_reaches_rock", "back at the rock with 0.06 mm/s to spare"), 1e-6, |n| {
            n > 0
        }),
        brought_back(("bit_misses_rock", "turned just before the rock"), -1e-6, |n| n == 0),
        brought_back(
            ("bit_grazes_rock", "back at the rock at no speed, at a step's end"),
            0.0,
            either,
        ),
        barrier(("barrier_just_met", "WR below the viscous work by 1e-9"), 1.0 - 1e-9, |e| {
            e == BARRIER
        }),
        barrier(("barrier_just_missed", "WR above it by 1e-9"), 1.0 + 1e-9, |e| e == TURN),
        barrier(("barrier_grazed", "WR equal to it, to rounding"), 1.0, |_| true),
    ]
}
