//! Hard cases of loads, starts, steps and interventions.

use crate::hard::{BLOWS, Case, case, cycles, missed, run, summary, trajectory};
use crate::monitor::{Monitored, Violation};
use hammer::RockMode;
use hammer::{Input, InputValues, Parameters, Relay, Source};

fn force(p: &mut Parameters) {
    p.drive.source = Source::Force;
}

/// Loads of every sign.
fn loads() -> Vec<Case> {
    vec![
        case("zero_gravity", "G = 0", |p, _| p.gravity = 0.0, cycles),
        case(
            "gravity_upward",
            "G = -9.81 m/s2: drilling upward",
            |p, _| p.gravity = -p.gravity,
            cycles,
        ),
        case("feed_none", "FS = 0", |_, i| i.feed_force = 0.0, cycles),
        case(
            "feed_negative",
            "FS = -2000 N: the bit is lifted off from the start",
            |_, i| i.feed_force = -2000.0,
            cycles,
        ),
        case(
            "lifted_from_standstill",
            "feed turned to -500 N in standstill: the slow lift",
            |p, i| {
                force(p);
                i.drive_force = -100.0;
            },
            |w| {
                w.run(0.01, 5)?;
                w.machine.set_input(Input::FeedForce, &[-500.0])?;
                w.run(0.01, 20)?;
                let lifted =
                    w.machine.take_journal().iter().any(|r| r.mode.rock == RockMode::FreeFlight);
                if lifted { Ok(summary(w)) } else { Err(missed("lift-off", w)) }
            },
        ),
        case(
            "rests_for_good",
            "F0 = 20 N, less than the piston's weight: it comes to rest on the bit",
            |p, _| {
                p.drive.amplitude = 20.0;
                p.contact.initial_gap = 1e-4;
                p.material.damping_time = 1e-6;
            },
            |w| {
                w.run(2.0, 200)?;
                let events = w.machine.counters().events;
                w.run(10.0, 1)?;
                if w.machine.counters().events == events {
                    Ok(summary(w))
                } else {
                    Err(missed("rest", w))
                }
            },
        ),
    ]
}

/// Starts and states that last.
fn rests() -> Vec<Case> {
    vec![
        case(
            "rests_on_drive",
            "a light piston on a long bit that the feed all but lifts: at rest with alpha = +1",
            |p, i| {
                (p.piston.length, p.bit.length) = (0.05, 2.0);
                (p.drive.amplitude, p.contact.initial_gap) = (0.5, 1e-5);
                p.material.damping_time = 1e-5;
                let weight = (p.piston_mass() + p.bit_mass()) * p.gravity;
                i.feed_force = 0.5 - weight;
            },
            |w| {
                w.run(3.0, 300)?;
                let events = w.machine.counters().events;
                w.run(10.0, 1)?;
                let drives = w.machine.mode().relay == Relay::Drive;
                if drives && w.machine.stalled() && w.machine.counters().events == events {
                    Ok(format!("{}, alpha = +1", summary(w)))
                } else {
                    Err(missed("rest with alpha = +1", w))
                }
            },
        ),
        case(
            "resting_contact",
            "g0 = 0, constant push of 1000 N: contact that never opens for good",
            |p, i| {
                force(p);
                p.contact.initial_gap = 0.0;
                i.drive_force = 1000.0;
            },
            cycles,
        ),
        case(
            "all_at_once",
            "g0 = 0 and v0 = 5 m/s: contact and rock at the first instant",
            |p, i| {
                p.contact.initial_gap = 0.0;
                p.piston.initial_velocity = 5.0;
                p.gravity = 0.0;
                i.feed_force = 0.0;
                p.drive.amplitude = 0.0;
                p.rock.standstill_speed = 0.0;
            },
            run(1e-3, 200),
        ),
        case(
            "creeping_flight",
            "D1 = 0.5 m: the bit creeps in DFC through a long flight",
            |p, _| p.drive.stroke = 0.5,
            run(0.5, 100),
        ),
        case(
            "equal_bars_long",
            "equal bars, every frequency twice: twenty cycles",
            |_, _| (),
            run(1.0, 200),
        ),
    ]
}

/// Steps and interventions.
fn interventions() -> Vec<Case> {
    vec![
        case(
            "no_drive",
            "F0 = 0: the piston falls once and rests",
            |p, _| p.drive.amplitude = 0.0,
            run(1.0, 200),
        ),
        case(
            "swinging_drive",
            "external force, a quartic that turns within one step of 10 ms",
            |p, i| {
                force(p);
                p.contact.initial_gap = 1e-4;
                i.drive_force = 0.0;
            },
            swinging,
        ),
        case(
            "retuned_in_contact",
            "KR, gamma, CR, WR and F0 changed in mid-contact",
            |_, _| (),
            |w| {
                w.run(0.01372, 10)?;
                if !w.machine.mode().closed() {
                    return Err(missed("contact", w));
                }
                let mut p = *w.machine.parameters();
                p.rock.stiffness *= 2.5;
                p.rock.unloading_ratio *= 0.6;
                p.rock.viscosity *= 0.3;
                p.rock.energy_barrier *= 0.01;
                p.drive.amplitude *= 1.3;
                w.machine.retune(&p)?;
                w.run(0.1, 200)?;
                Ok(summary(w))
            },
        ),
        case("step_of_ten_seconds", "one communication step of 10 s", |_, _| (), run(10.0, 1)),
        case(
            "steps_of_a_nanosecond",
            "steps of 1 ns through an impact; bitwise as one step",
            |_, _| (),
            nanoseconds,
        ),
        case(
            "steps_on_events",
            "communication points exactly at events; bitwise as one step",
            |_, _| (),
            on_events,
        ),
    ]
}

/// Loads, starts and interventions.
pub fn scenes() -> Vec<Case> {
    [loads(), rests(), interventions()].into_iter().flatten().collect()
}

fn nanoseconds(w: &mut Monitored) -> Result<String, Violation> {
    let (from, to, mut one) =
        (0.01367, 0.01369, Monitored::new(w.machine.parameters(), &InputValues::default(), BLOWS)?);
    w.machine.advance(from)?;
    for k in 1..20_000 {
        w.machine.advance(from + 1e-9 * f64::from(k))?;
    }
    w.machine.advance(to)?;
    one.machine.advance(to)?;
    same(w, &mut one)
}

fn on_events(w: &mut Monitored) -> Result<String, Violation> {
    let mut one = Monitored::new(w.machine.parameters(), &InputValues::default(), BLOWS)?;
    one.machine.advance(0.1)?;
    let times: Vec<f64> = one.machine.take_journal().iter().map(|r| r.time).collect();
    for t in times {
        w.machine.advance(t)?;
        w.observe()?;
    }
    w.machine.advance(0.1)?;
    same(w, &mut one)
}

fn same(w: &mut Monitored, one: &mut Monitored) -> Result<String, Violation> {
    if trajectory(&w.machine) == trajectory(&one.machine) {
        Ok(format!("{}, bitwise equal", summary(w)))
    } else {
        Err(missed("bitwise equality", w))
    }
}

/// Each step of 10 ms pushes, pulls, pushes and pulls by `F0 (20 T4(2 t / 10 ms - 1) + 2)`,
/// `T4` Chebyshev's polynomial, given by its value and derivatives at the start.
fn swinging(w: &mut Monitored) -> Result<String, Violation> {
    let (size, x): (f64, f64) = (1800.0, 2.0 / 0.01);
    // T4 and its derivatives at -1: 1, -16, 80, -192, 192.
    let taylor = [1.0, -16.0 * x, 80.0 * x * x, -192.0 * x.powi(3), 192.0 * x.powi(4)];
    let mut force = taylor.map(|d| 20.0 * size * d);
    force[0] += 2.0 * size;
    // 1 + 32 + 160 + 256 + 128, where the step ends.
    w.terms = 577.0 * 20.0 * size;
    let mut most = 0;
    for _ in 0..10 {
        w.machine.set_input(Input::DriveForce, &force)?;
        let before = w.machine.counters().contacts;
        w.run(0.01, 1)?;
        most = most.max(w.machine.counters().contacts - before);
    }
    if most < 2 {
        return Err(missed("two collisions in a step", w));
    }
    Ok(format!("{}, {most} collisions in one step", summary(w)))
}
