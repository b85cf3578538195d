//! Whole cycles: the relay against a fixed bit, the stationary response of two earlier solvers, the first impact.

use crate::reference::overdamped;
use crate::rows::mesh;
use crate::rows::row::{Row, Rows};
use hammer::{
    Blow, Error, Event, Fidelity, InputValues, Machine, Parameters, Record, Relay, RockMode,
};

/// The last of many blows against a fixed bit.
struct Rebound {
    speed: f64,
    period: f64,
    restitution: f64,
    /// Deviation of `vr` from that of rigid contact while the piston turns, m.
    stray: f64,
    /// Change of the speed since the previous blow, m/s.
    change: f64,
}

/// The `blows`-th switch of the relay, and the blow that follows at once. `slide` is the time constant with which the
/// bit stops.
fn rebound(p: &Parameters, blows: usize, slide: f64) -> Result<Rebound, Error> {
    let mut m = Machine::new(p, &mesh::no_inputs(), 0.0)?;
    m.keep_journal(true);
    let t3 = p.timescales().pressure;
    // At these restitutions no cycle is longer than five T3, and no blow longer than one.
    m.advance(5.0 * t3 * blows as f64)?;
    let journal = m.take_journal();
    let switches: Vec<f64> =
        journal.iter().filter(|r| r.event == Event::Relay(Relay::Return)).map(|r| r.time).collect();
    let [.., a, b, start, end] = switches[..] else { return Err(Error::NotFinite { time: t3 }) };
    let opening = journal
        .iter()
        .rfind(|r| r.event.is_contact() && !r.mode.closed() && r.time < 0.5 * (start + end))
        .map_or(start, |r| r.time);
    let relative = |t: f64| -> Result<f64, Error> {
        let mut m = Machine::new(p, &mesh::no_inputs(), 0.0)?;
        m.advance(t)?;
        Ok(m.kinematics().relative.velocity)
    };
    let (speed, before) = (relative(start)?, relative(b)?);
    // After thirty time constants the bit has stopped in its dashpot.
    let left = -relative(opening + 30.0 * slide)?;
    Ok(Rebound {
        speed,
        period: 0.5 * (start - a),
        restitution: left / speed,
        stray: speed * (30.0 * slide + 0.5 * (opening - start)),
        change: (speed - before).abs(),
    })
}

const RELAY: &str = "vr strays from rigid contact by d while the piston turns (speed x half the contact, and the bit's slide): F0 d on the energy of a cycle; and the last change of the speed";

fn relay_rows(name: &str, p: &Parameters, blows: usize, slide: f64) -> Result<Vec<Row>, Error> {
    let r = rebound(p, blows, slide)?;
    let (t3, stroke) = (p.timescales().pressure, p.drive.stroke);
    let e = r.restitution;
    let speed = 2.0 * stroke / t3 / (1.0 - e * e).sqrt();
    let a = stroke / (t3 * t3);
    let back = (e * e * speed * speed + 2.0 * a * stroke).sqrt();
    let period = (2.0 * back + (1.0 - e) * speed) / a;
    // Energy of a cycle: (1 - e^2) M v^2 / 2 = 2 F0 D1, with an error of F0 d at each end.
    let relative = r.stray / stroke / (1.0 - e * e) + r.change / speed;
    let case = format!("relay, fixed bit, {name}, measured e = {e:.4}");
    let mut rows = Rows::new(case, "closed form", RELAY);
    rows.add("impact speed, m/s", speed, r.speed, relative * speed);
    rows.add("period, ms", 1e3 * period, 1e3 * r.period, 1e3 * 2.0 * relative * period);
    if e.abs() < 0.02 {
        let limit = (2.0 + 8f64.sqrt()) * t3;
        // d period / d e = -2 T3 at e = 0.
        let tolerance = 2.0 * e.abs() * t3 + 2.0 * relative * limit;
        rows.add("period against e = 0, ms", 1e3 * limit, 1e3 * r.period, 1e3 * tolerance);
    }
    Ok(rows.list)
}

/// Closed form 5: a viscous piston against a wall.
///
/// # Errors
/// Those of the engine.
pub fn relay_viscous() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    // The bit is a wall, and the piston so viscous that a blow takes much of its energy.
    for beta in [1e-6, 1e-5, 4e-5] {
        let mut p = mesh::bare(8);
        p.piston.initial_velocity = 0.0;
        p.drive.amplitude = Parameters::default().drive.amplitude;
        p.contact.initial_gap = p.drive.stroke;
        p.bit.length *= 1e7;
        p.bit.elements = 1;
        p.material.damping_time = beta;
        rows.extend(relay_rows(&format!("beta = {beta:e} s"), &p, 60, 0.0)?);
    }
    Ok(rows)
}

/// Closed form 5 at `e` near 0: equal rigid masses, the bit in a dashpot.
///
/// # Errors
/// Those of the engine.
pub fn relay_dead() -> Result<Vec<Row>, Error> {
    let mut p = mesh::bare(1);
    p.fidelity = Fidelity::Rigid;
    p.piston.initial_velocity = 0.0;
    p.drive.amplitude = Parameters::default().drive.amplitude;
    p.contact.initial_gap = p.drive.stroke;
    p.material.youngs_modulus = 1e19;
    p.contact.stiffness = 1e19;
    let slide = 1e-6;
    p.rock.viscosity = p.bit_mass() / slide;
    p.rock.stiffness = 1e3;
    p.rock.energy_barrier = 1e12;
    relay_rows("equal rigid masses, dashpot", &p, 12, slide)
}

/// The last blow; zeros before the first.
fn blow(m: &Machine) -> Blow {
    m.blow().copied().unwrap_or_default()
}

const PRINTED: &str = "half a unit of the last digit printed";
const MODEL: &str = "two earlier solvers of this project";

/// The response of a hammer from rest, of two earlier solvers of this project.
struct Printed {
    name: &'static str,
    /// First periods from rest, ms, and a unit of their last digit, since some are truncated rather than rounded.
    first_periods: (&'static [f64], f64),
    /// Settled numbers: name, value, and half a unit of the last digit.
    settled: &'static [(&'static str, f64, f64)],
}

const PERIOD: &str = "period, ms";
const RATE: &str = "tip rate, mm/s";
const SPEED: &str = "relative mean speed at impact, m/s";
const ENERGY: &str = "energy of a blow, J";
const CONTACT: &str = "peak contact force, kN";
const ROCK: &str = "peak rock force, kN";

const REFERENCE: Printed = Printed {
    name: "reference hammer",
    first_periods: (
        &[44.1463, 45.1652, 45.5082, 45.5884, 45.6071, 45.6116, 45.6127, 45.6129],
        1e-4,
    ),
    settled: &[
        (PERIOD, 45.61298, 0.5e-5),
        (RATE, 39.816, 0.5e-3),
        (SPEED, 11.51269, 0.5e-5),
        (ENERGY, 227.24, 0.5e-2),
        (CONTACT, 734.0, 0.05),
        (ROCK, 238.6, 0.05),
    ],
};

const OVERDAMPED: Printed = Printed {
    name: "overdamped",
    first_periods: (&[44.188, 44.984, 45.300, 45.370, 45.385, 45.388, 45.389], 1e-3),
    settled: &[
        (PERIOD, 45.389, 0.5e-3),
        (RATE, 33.98, 0.5e-2),
        (SPEED, 11.405, 0.5e-3),
        (CONTACT, 795.9, 0.05),
        (ROCK, 613.7, 0.05),
    ],
};

/// First periods, and the settled cycle, with the machine in the middle of a flight and the journal of two settled
/// cycles.
fn respond(
    p: &Parameters,
    printed: &Printed,
    rows: &mut Vec<Row>,
) -> Result<(Machine, Vec<Record>), Error> {
    let mut m = Machine::new(p, &InputValues::default(), 0.0)?;
    m.keep_journal(true);
    let mut first = Rows::new(format!("{} from rest", printed.name), MODEL, PRINTED);
    m.advance(0.43)?;
    let journal = m.take_journal();
    let returns = journal.iter().filter(|r| r.event == Event::Relay(Relay::Return));
    let switches: Vec<f64> = returns.map(|r| r.time).collect();
    let (periods, unit) = printed.first_periods;
    for (i, (value, pair)) in periods.iter().zip(switches.windows(2)).enumerate() {
        first.add(format!("period {}, ms", i + 1), *value, 1e3 * (pair[1] - pair[0]), unit);
    }
    rows.append(&mut first.list);
    while m.counters().blows < 30 {
        m.advance(m.time() + 0.01)?;
    }
    // Two whole cycles from the middle of a flight.
    m.take_journal();
    let (contacts, period) = (m.counters().contacts, blow(&m).period);
    m.advance(m.time() + 2.0 * period)?;
    let peaks = m.peaks();
    let peaks = [peaks.contact_force(), peaks.rock_force()].map(|force| 1e-3 * force);
    let now = blow(&m);
    let mut stay = Rows::new(format!("{}, stationary", printed.name), MODEL, PRINTED);
    for (name, value, digit) in printed.settled {
        let found = match *name {
            PERIOD => 1e3 * now.period,
            RATE => 1e3 * now.tip_rate,
            SPEED => now.speed,
            ENERGY => now.energy,
            CONTACT => peaks[0],
            _ => peaks[1],
        };
        stay.add(*name, *value, found, *digit);
    }
    let collisions = (m.counters().contacts - contacts) as f64 / 2.0;
    stay.add("collisions per cycle", 2.0, collisions, 0.0);
    rows.append(&mut stay.list);
    let journal = m.take_journal();
    Ok((m, journal))
}

/// The rock's modes from one blow to the next, and their durations, s. Those too short for the stored list, which
/// is sampled, are left out.
fn modes(journal: &[Record]) -> Vec<(char, f64)> {
    let letter = |record: &Record| match record.mode.rock {
        RockMode::FreeFlight => 'F',
        RockMode::DissipativeForward => 'D',
        RockMode::Forward => 'C',
        RockMode::Backward => 'B',
        RockMode::Standstill => 'S',
    };
    let merged = |list: Vec<(char, f64)>, (letter, lasts): (char, f64)| {
        let mut list = list;
        match list.last_mut() {
            Some((last, time)) if *last == letter => *time += lasts,
            _ => list.push((letter, lasts)),
        }
        list
    };
    let mut turns =
        journal.iter().enumerate().filter(|(_, r)| r.event == Event::Relay(Relay::Return));
    let (Some((from, _)), Some((to, _))) = (turns.next(), turns.next()) else { return Vec::new() };
    let spells = journal[from..=to].windows(2).map(|w| (letter(&w[0]), w[1].time - w[0].time));
    let all = spells.fold(Vec::new(), merged);
    all.into_iter().filter(|(_, lasts)| *lasts >= SAMPLED).fold(Vec::new(), merged)
}

/// The reference hammer and its overdamped variant, from rest and in their stationary cycles.
///
/// # Errors
/// Those of the engine.
pub fn stationary() -> Result<Vec<Row>, Error> {
    let (p, mut list) = (Parameters::default(), Vec::new());
    let (m, journal) = respond(&p, &REFERENCE, &mut list)?;
    let period = 1e3 * blow(&m).period;
    let modes = modes(&journal);
    let mut sequence =
        Rows::new("reference hammer, modes of the rock from a blow on", MODEL, SAMPLED_WHY);
    let found: String = modes.iter().map(|(letter, _)| letter).collect();
    sequence.add(format!("{SEQUENCE}: letters"), SEQUENCE.len() as f64, found.len() as f64, 0.0);
    let alike = found.chars().zip(SEQUENCE.chars()).filter(|(a, b)| a == b).count();
    sequence.add("letters that are alike", SEQUENCE.len() as f64, alike as f64, 0.0);
    let rest = modes.last().map_or(f64::NAN, |(_, lasts)| 1e3 * lasts);
    sequence.add("standstill, ms", 38.4, rest, 0.05);
    list.extend(sequence.list);
    let mut paper = Rows::new("reference hammer, stationary", "the paper", "printed as about");
    paper.add("period, ms", 45.0, period, 1.0);
    list.extend(paper.list);
    let scales = p.timescales();
    let mut times = Rows::new("reference hammer, timescales", MODEL, PRINTED);
    times.add("T1, ms", 0.0325, 1e3 * scales.piston_transit, 0.5e-4);
    times.add("T2, ms", 0.0325, 1e3 * scales.bit_transit, 0.5e-4);
    times.add("T3, ms", 9.76, 1e3 * scales.pressure, 0.5e-2);
    times.add("T4, ms", 0.169, 1e3 * scales.drilling, 0.5e-3);
    times.add("T5, ms", 1.8e-3, 1e3 * scales.barrier, 0.5e-4);
    times.add("T6, ms", 5.9e-3, 1e3 * scales.contact, 0.5e-4);
    list.extend(times.list);
    respond(&overdamped(20), &OVERDAMPED, &mut list)?;
    Ok(list)
}

/// The bit's modes from one blow to the next: D DFC, C FC, B BC, F FF, S SS. The stored list begins with an
/// additional B and D, a precursor of its mesh.
const SEQUENCE: &str = "CBFDCBDBFDCBDBFDBDBDBS";
/// The stored list lacks shorter modes, s.
const SAMPLED: f64 = 10e-6;
const SAMPLED_WHY: &str = "spells of less than 10 us are left out; half a unit of the last digit";

/// The first impact from rest: free fall, with the relay on the way.
///
/// # Errors
/// Those of the engine.
pub fn first_impact() -> Result<Vec<Row>, Error> {
    let (p, inputs) = (Parameters::default(), InputValues::default());
    let mut m = Machine::new(&p, &inputs, 0.0)?;
    m.keep_journal(true);
    m.advance(0.02)?;
    let journal = m.take_journal();
    let time = |event| journal.iter().find(|r| r.event == event).map_or(f64::NAN, |r| r.time);
    let (push, turn) = (p.drive.amplitude / p.piston_mass(), time(Event::Relay(Relay::Return)));
    let (fall, brake) = (p.gravity + push, p.gravity - push);
    // The bit's face is lower than where the relay turns, so the rest of the way is braked.
    let mean = resting(&p, [0.5, 1.0 / 3.0]);
    let v = fall * turn;
    let left = p.contact.initial_gap + resting(&p, [1.0, 0.5]) - 0.5 * fall * turn * turn;
    let why = "rounding: 8 eps of the time";
    let mut rows = Rows::new("reference hammer from rest", "free fall from rest", why);
    let exact = (2.0 * (p.contact.initial_gap + mean) / fall).sqrt();
    let rounding = |t: f64| 8e3 * f64::EPSILON * t;
    rows.add("first switch of the relay, ms", 1e3 * exact, 1e3 * turn, rounding(exact));
    let exact = turn + 2.0 * left / (v + (v * v + 2.0 * brake * left).sqrt());
    rows.add("first impact, ms", 1e3 * exact, 1e3 * time(Event::CLOSING), rounding(exact));
    Ok(rows.list)
}

/// How far a preloaded bit is below its unstressed position: by the rock's indentation, and by a share of its own
/// shortening under feed and weight. Its face has all of the former and half of the latter; its mean has a half and a
/// third, since splines represent a parabola.
fn resting(p: &Parameters, [by_feed, by_weight]: [f64; 2]) -> f64 {
    let (feed, weight) = (InputValues::default().feed_force, p.bit_mass() * p.gravity);
    (feed + weight) / (p.rock.unloading_ratio * p.rock.stiffness)
        + (by_feed * feed + by_weight * weight) * p.bit.length / mesh::stretch(p)
}
