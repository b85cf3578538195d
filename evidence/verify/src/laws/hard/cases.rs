//! The cases of parameters, starts and interventions that no drawn scene is.

use super::{Case, case, cycles, graze, missed, run, summary};
use crate::laws::monitor::{Monitored, Violation};
use crate::rows::mesh;
use hammer::{Fidelity, Input, Parameters, Relay, RockMode, Source};

fn elements(p: &mut Parameters, piston: usize, bit: usize) {
    (p.piston.elements, p.bit.elements) = (piston, bit);
}

fn force(p: &mut Parameters) {
    p.drive.source = Source::Force;
}

/// The least `CR` at which a bit of one element on the rock has a double real root. Its
/// polynomial is `a(s) + CR b(s)`, so on the real axis `CR = -a / b`, and a double root is
/// where that is least.
fn critical_viscosity(p: &Parameters) -> f64 {
    let (m, k) = (p.bit_mass() / 6.0, mesh::stretch(p) / p.bit.length);
    let viscosity = |s: f64| {
        let (own, across) = (2.0 * m * s * s + k, m * s * s - k);
        let rest = own + p.rock.stiffness - across * across / own;
        rest / s
    };
    // Between a tenth of the rock's frequency and ten times, s = -e^x, by golden section.
    let middle = (p.rock.stiffness / p.bit_mass()).sqrt().ln();
    let (mut low, mut high) = (middle - 2.3, middle + 2.3);
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    while high - low > 1e-9 {
        let (x, y) = (high - ratio * (high - low), low + ratio * (high - low));
        if viscosity(x.exp()) < viscosity(y.exp()) { high = y } else { low = x }
    }
    viscosity((0.5 * (low + high)).exp())
}

/// Defective pairs, fine meshes.
fn bodies() -> Vec<Case> {
    let mut list = vec![
        case(
            "critical_bars",
            "beta = 2 / omega of a free mode: a defective pair in flight",
            |p, _| {
                let section = hammer::bodies::bar::Section {
                    youngs_modulus: p.material.youngs_modulus,
                    density: p.material.density,
                    area: p.cross_section,
                    length: p.piston.length,
                };
                p.material.damping_time = 2.0
                    / hammer::bodies::bar::Bar::free(section, p.piston.elements).omega2[5].sqrt();
            },
            cycles,
        ),
        case(
            "critical_rock",
            "rigid, CR = 2 sqrt(KR Mb): a defective pair in the rock",
            |p, _| {
                p.fidelity = Fidelity::Rigid;
                p.rock.viscosity = 2.0 * (p.rock.stiffness * p.bit_mass()).sqrt();
            },
            cycles,
        ),
        case(
            "critical_tip",
            "a bit of one element, CR tuned: a defective pair of bar and rock",
            |p, _| {
                elements(p, 20, 1);
                p.material.damping_time = 0.0;
                p.rock.viscosity = critical_viscosity(p);
            },
            cycles,
        ),
        case(
            "four_hundred",
            "400 elements per bar, through the first blow",
            |p, _| elements(p, 400, 400),
            run(0.015, 20),
        ),
        case(
            "quiet_tip",
            "100 elements, undamped: amplitudes cancel to nothing before the front arrives",
            |p, i| {
                *p = mesh::bare(100);
                *i = mesh::no_inputs();
            },
            |w| {
                // Radians of the fastest mode, sqrt(12) c / h, in nine tenths of a transit.
                let radians = 12f64.sqrt() * 100.0 * 0.9;
                w.run(mesh::strike() + 0.9 * w.machine.parameters().timescales().bit_transit, 1)?;
                let windows = w.machine.counters().windows;
                if windows as f64 > 2.0 * radians {
                    return Err(missed("a window of a radian", w));
                }
                Ok(format!(
                    "{windows} windows over {radians:.0} radians, ends {:?}",
                    w.machine.mode().rock
                ))
            },
        ),
    ];
    for c in &mut list {
        // Undamped, how many micro-events there are is a matter of chance.
        if c.name == "four_hundred" {
            c.allowed *= 4;
        }
    }
    list
}

/// States that last, steps and interventions.
fn scenes() -> Vec<Case> {
    vec![
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
            "swinging_drive",
            "external force, a quartic that turns within one step of 10 ms",
            |p, i| {
                force(p);
                p.contact.initial_gap = 1e-4;
                i.drive_force = 0.0;
            },
            swinging,
        ),
    ]
}

/// All of them.
pub fn all() -> Vec<Case> {
    [bodies(), scenes(), graze::cases()].into_iter().flatten().collect()
}

/// Plays the case of this name.
///
/// # Panics
/// If there is none, or it fails.
pub fn assert_case(name: &str) {
    let cases = all();
    let case = cases.iter().find(|c| c.name == name).expect("a case of this name");
    if let Err(violation) = case.run() {
        panic!("{name}: {violation}");
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
