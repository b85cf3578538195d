//! Whole cycles: the relay against a fixed bit, mean forces, the published stationary
//! response, and exact waves over the first cycle of the reference hammer.

use crate::mesh;
use crate::row::{Row, Rows};
use crate::waves::{Scene, Waves};
use hammer::{Error, Fidelity, InputValues, Machine, Parameters};

/// The last of many blows against a fixed bit.
struct Rebound {
    speed: f64,
    period: f64,
    restitution: f64,
    /// How far `vr` strays from rigid contact while the piston turns, m.
    stray: f64,
    /// Change of the speed since the blow before, m/s.
    change: f64,
}

/// The `blows`-th switch of the relay and the blow that follows at once; `slide` is the
/// time in which the bit stops.
fn rebound(p: &Parameters, blows: usize, slide: f64) -> Result<Rebound, Error> {
    let mut m = Machine::new(p, &mesh::no_inputs(), 0.0)?;
    m.keep_journal(true);
    let t3 = p.timescales().pressure;
    // No cycle is longer than five T3 at the restitutions met here, nor a blow than one.
    m.advance(5.0 * t3 * blows as f64)?;
    let journal = m.take_journal();
    let switches: Vec<f64> = journal.iter().filter(|r| r.event == "Q9").map(|r| r.time).collect();
    let [.., a, b, start, end] = switches[..] else { return Err(Error::NotFinite { time: t3 }) };
    let opening = journal
        .iter()
        .rfind(|r| r.event == "Q11" && !r.mode.closed && r.time < 0.5 * (start + end))
        .map_or(start, |r| r.time);
    let relative = |t: f64| -> Result<f64, Error> {
        let mut m = Machine::new(p, &mesh::no_inputs(), 0.0)?;
        m.advance(t)?;
        Ok(m.kinematics().relative_velocity)
    };
    let (speed, before) = (relative(start)?, relative(b)?);
    // The bit has stopped in its dashpot after thirty of its times.
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
    // Energy of a cycle: (1 - e^2) M v^2 / 2 = 2 F0 D1, each end off by F0 d.
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
/// Whatever the engine says.
pub fn relay_viscous() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    // The bit a wall, the piston so viscous that a blow takes much of its energy.
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
/// Whatever the engine says.
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

/// Mean forces over a cycle of the reference hammer, after its `blows`-th blow.
fn means(blows: u64) -> Result<Vec<Row>, Error> {
    let (p, inputs) = (Parameters::default(), InputValues::default());
    let mut m = Machine::new(&p, &inputs, 0.0)?;
    while m.counters().blows < blows {
        m.advance(m.time() + 0.01)?;
    }
    let period = m.blow().period;
    let look = |m: &mut Machine| (m.impulses(), *m.kinematics());
    let (j0, k0) = look(&mut m);
    m.advance(m.time() + period)?;
    let (j1, k1) = look(&mut m);
    let (mp, mb) = (p.piston_mass(), p.bit_mass());
    let mean = |a: f64, b: f64| (b - a) / period;
    let contact = mean(j0.contact, j1.contact);
    let rock = mean(j0.rock, j1.rock);
    let gained = mb * mean(k0.bit_velocity, k1.bit_velocity);
    let mut rows = Rows::new(
        format!("reference hammer, cycle after blow {blows}"),
        "momentum",
        "rounding: 2 eps an event on the impulses summed since the start",
    );
    let rounding = 2.0
        * f64::EPSILON
        * (m.counters().events as f64)
        * (j1.contact.abs() + j1.rock.abs() + inputs.feed_force * m.time())
        / period;
    let load = inputs.feed_force + mb * p.gravity + contact;
    rows.add("mean rock force and momentum gained, N", load, rock + gained, rounding);
    let mut cycle = Rows::new(
        format!("reference hammer, cycle after blow {blows}"),
        "periodic cycle",
        "the momentum by which the cycle does not repeat, over the period",
    );
    cycle.add("mean rock force, N", load, rock, gained.abs() + rounding);
    let piston = mp * mean(k0.piston_velocity, k1.piston_velocity);
    // The relay's mean is the work of its force over no more than the piston's travel.
    let relay = (contact + piston - mp * p.gravity).abs();
    rows.add("mean drive force within F0, N", relay.min(p.drive.amplitude), relay, rounding);
    rows.list.extend(cycle.list);
    Ok(rows.list)
}

/// Closed form 6.
///
/// # Errors
/// Whatever the engine says.
pub fn mean_forces() -> Result<Vec<Row>, Error> {
    Ok([means(3)?, means(30)?].concat())
}

const PRINTED: &str = "half a unit of the last digit printed";
const MODEL: &str = "two independent solvers (the model's description)";

/// The reference hammer from rest and in its stationary cycle.
///
/// # Errors
/// Whatever the engine says.
pub fn stationary() -> Result<Vec<Row>, Error> {
    let mut m = Machine::new(&Parameters::default(), &InputValues::default(), 0.0)?;
    m.keep_journal(true);
    let mut rows = Rows::new("reference hammer from rest", MODEL, PRINTED);
    m.advance(0.38)?;
    let switches: Vec<f64> =
        m.take_journal().iter().filter(|r| r.event == "Q9").map(|r| r.time).collect();
    let names = ["period 1, ms", "period 2, ms", "period 3, ms", "period 4, ms", "period 5, ms"];
    let printed = [44.188, 44.984, 45.300, 45.370, 45.385];
    for ((name, value), pair) in names.into_iter().zip(printed).zip(switches.windows(2)) {
        // The table cuts some digits where it might round: a whole unit.
        rows.add(name, value, 1e3 * (pair[1] - pair[0]), 1e-3);
    }
    while m.counters().blows < 30 {
        m.advance(m.time() + 0.01)?;
    }
    // From the middle of a flight on, two whole cycles.
    let (contacts, period) = (m.counters().contacts, m.blow().period);
    m.advance(m.time() + 2.0 * period)?;
    let blow = *m.blow();
    let mut stay = Rows::new("reference hammer, stationary", MODEL, PRINTED);
    stay.add("period, ms", 45.389, 1e3 * blow.period, 0.5e-3);
    stay.add("collisions a cycle", 2.0, (m.counters().contacts - contacts) as f64 / 2.0, 0.0);
    stay.add("ROP, mm/s", 34.0, 1e3 * blow.rop, 0.05);
    rows.list.extend(stay.list);
    Ok(rows.list)
}

/// Nearly undamped bars on a fine mesh against exact waves, over the first cycle.
///
/// # Errors
/// Whatever the engine says.
pub fn first_cycle() -> Result<Vec<Row>, Error> {
    let mut p = Parameters::default();
    let inputs = InputValues::default();
    (p.piston.elements, p.bit.elements) = (160, 160);
    p.material.damping_time *= 0.1;
    let mut waves = Waves::new(Scene::of(&p, &inputs), 100);
    let mut m = Machine::new(&p, &inputs, 0.0)?;
    m.keep_journal(true);
    let scales = p.timescales();
    let fall = p.drive.amplitude / p.piston_mass() + p.gravity;
    let impact = (2.0 * p.contact.initial_gap / fall).sqrt();
    // By then the main drilling cycle is over, and the rebound has not begun.
    let settled = impact + 15.0 * scales.piston_transit;
    waves.advance(settled);
    m.advance(settled)?;
    let (depth, piston) = (waves.depth(), waves.means[0].velocity);
    let ours = *m.kinematics();
    let speed = fall * impact;
    let spread = mesh::spread(&p, 15.0);
    let case = "reference hammer, first cycle, 160 elements, beta / 10";
    let source = "exact waves";
    let why = "front spread over 15 transits, times the speed of the piston; the period by momentum, over its acceleration";
    let mut rows = Rows::new(case, source, why);
    rows.add(
        "hole after the main drilling cycle, mm",
        1e3 * depth,
        1e3 * ours.hole_depth,
        1e3 * spread * speed * scales.piston_transit,
    );
    // Contact force Z v / 2, begun and ended by a front.
    let momentum = spread * speed;
    rows.add("piston after the blow, m/s", piston, ours.piston_velocity, momentum);
    m.advance(0.06)?;
    waves.advance(0.06);
    let journal = m.take_journal();
    let q9: Vec<f64> = journal.iter().filter(|r| r.event == "Q9").map(|r| r.time).collect();
    let period = |t: &[f64]| 1e3 * (t[1] - t[0]);
    let tolerance = 1e3 * 2.0 * momentum / fall;
    rows.add("first period, ms", period(&waves.returns), period(&q9), tolerance);
    let why = "rounding: 8 eps of the time";
    let mut flight = Rows::new(case, "free fall from rest, relay on the way", why);
    let first = journal.iter().find(|r| r.event == "Q11").map_or(f64::NAN, |r| r.time);
    // The bit's face stands lower than where the relay turns: the rest of the way is braked.
    let turn = q9[0];
    let brake = p.gravity - p.drive.amplitude / p.piston_mass();
    let (v, left) =
        (fall * turn, p.contact.initial_gap + shortening(&p) - 0.5 * fall * turn * turn);
    let exact = turn + 2.0 * left / (v + (v * v + 2.0 * brake * left).sqrt());
    flight.add("first impact, ms", 1e3 * exact, 1e3 * first, 8e3 * f64::EPSILON * exact);
    rows.list.extend(flight.list);
    Ok(rows.list)
}

/// How far the bit's upper face stands below its unstressed place, under its dead loads.
fn shortening(p: &Parameters) -> f64 {
    let (feed, weight) = (InputValues::default().feed_force, p.bit_mass() * p.gravity);
    (feed + weight) / (p.rock.unloading_ratio * p.rock.stiffness)
        + (feed + 0.5 * weight) * p.bit.length / mesh::stretch(p)
}
