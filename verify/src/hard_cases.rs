//! Hard cases of parameters: stiffness, damping, rock, lengths, meshes, loads.

use crate::hard::{Case, Play};
use crate::mesh;
use crate::watch::{Fault, Watched};
use hammer::mode::RockMode;
use hammer::{Fidelity, Input, InputValues, Parameters, Source};

/// Samples for a couple of blows: an ordinary one takes about two thousand.
const BLOWS: u64 = 500_000;

fn case(
    name: &'static str,
    setting: &'static str,
    change: impl FnOnce(&mut Parameters, &mut InputValues),
    play: Play,
) -> Case {
    let (mut parameters, mut inputs) = (Parameters::default(), InputValues::default());
    change(&mut parameters, &mut inputs);
    Case { name, setting, parameters, inputs, allowed: BLOWS, play }
}

fn told(w: &mut Watched) -> String {
    let (c, mode) = (w.machine.counters(), w.machine.mode());
    let stalled = if w.machine.stalled() { ", stalled" } else { "" };
    format!("{} blows, {} drilling cycles, ends {:?}{stalled}", c.blows, c.rock_cycles, mode.rock)
}

/// Two cycles of the reference hammer.
fn cycles(w: &mut Watched) -> Result<String, Fault> {
    w.run(0.1, 200)?;
    Ok(told(w))
}

fn elements(p: &mut Parameters, piston: usize, bit: usize) {
    (p.piston.elements, p.bit.elements) = (piston, bit);
}

/// Extreme numbers.
pub fn stiff() -> Vec<Case> {
    let mut list = vec![
        case(
            "contact_twenty_times_the_element",
            "KC = 20 E A / h: contact nodes rattle",
            |p, _| {
                p.contact.stiffness =
                    20.0 * mesh::stretch(p) * p.piston.elements as f64 / p.piston.length
            },
            cycles,
        ),
        case("contact_1e8", "KC = 1e8 N/m", |p, _| p.contact.stiffness = 1e8, cycles),
        case("contact_1e13", "KC = 1e13 N/m", |p, _| p.contact.stiffness = 1e13, cycles),
        case("contact_1e15", "KC = 1e15 N/m", |p, _| p.contact.stiffness = 1e15, cycles),
        case(
            "undamped",
            "beta = 0: micro-events without end as the mesh is refined",
            |p, _| p.material.damping_time = 0.0,
            cycles,
        ),
        case(
            "undamped_fine",
            "beta = 0, 60 elements",
            |p, _| {
                p.material.damping_time = 0.0;
                elements(p, 60, 60);
                mesh::soften_contact(p);
            },
            cycles,
        ),
        case(
            "overdamped",
            "beta = 1e-5 s: most modes overdamped",
            |p, _| p.material.damping_time = 1e-5,
            cycles,
        ),
        case(
            "critical_bars",
            "beta = 2 / omega of a free mode: a defective pair in flight",
            |p, _| {
                let section = hammer::bar::Section {
                    youngs_modulus: p.material.youngs_modulus,
                    density: p.material.density,
                    area: p.cross_section,
                    length: p.piston.length,
                };
                p.material.damping_time =
                    2.0 / hammer::bar::Bar::free(section, p.piston.elements).omega2[5].sqrt();
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
            "viscosity_impedance",
            "CR = Z: the tip reflects nothing",
            |p, _| p.rock.viscosity = p.impedance(),
            cycles,
        ),
        case("viscosity_none", "CR = 0", |p, _| p.rock.viscosity = 0.0, cycles),
        case("viscosity_1e9", "CR = 1e9 N s/m, far above Z", |p, _| p.rock.viscosity = 1e9, cycles),
        case(
            "barrier_none",
            "WR = 0: DFC passes to FC at once",
            |p, _| p.rock.energy_barrier = 0.0,
            cycles,
        ),
        case(
            "barrier_huge",
            "WR = 1e12 J: FC is never reached",
            |p, _| p.rock.energy_barrier = 1e12,
            cycles,
        ),
        case("gamma_one", "gamma = 1 + 1e-12", |p, _| p.rock.unloading_ratio = 1.0 + 1e-12, cycles),
        case("gamma_near_one", "gamma = 1.001", |p, _| p.rock.unloading_ratio = 1.001, cycles),
        case("gamma_thousand", "gamma = 1000", |p, _| p.rock.unloading_ratio = 1000.0, cycles),
        case("rock_1e5", "KR = 1e5 N/m", |p, _| p.rock.stiffness = 1e5, cycles),
        case("rock_1e11", "KR = 1e11 N/m", |p, _| p.rock.stiffness = 1e11, cycles),
        case(
            "no_standstill",
            "vs = dps = 0: every micro-cycle drills",
            |p, _| {
                p.rock.standstill_speed = 0.0;
                p.rock.standstill_penetration = 0.0;
            },
            cycles,
        ),
        case("short_piston", "Lp / Lb = 0.1", |p, _| p.piston.length *= 0.1, cycles),
        case("long_piston", "Lp / Lb = 10", |p, _| p.piston.length *= 10.0, cycles),
        case(
            "incommensurate",
            "Lp / Lb the golden ratio",
            |p, _| p.piston.length *= 0.5 * (1.0 + 5f64.sqrt()),
            cycles,
        ),
        case("one_element", "one element a bar", |p, _| elements(p, 1, 1), cycles),
        case("one_and_sixty", "1 and 60 elements", |p, _| elements(p, 1, 60), cycles),
        case(
            "four_hundred",
            "400 elements a bar, through the first blow",
            |p, _| elements(p, 400, 400),
            |w| {
                w.run(0.015, 20)?;
                Ok(told(w))
            },
        ),
        case("rigid", "rigid bodies", |p, _| p.fidelity = Fidelity::Rigid, cycles),
        case(
            "precursor",
            "100 elements, KC 2 E A / h: precursors in preloaded rock",
            |p, _| {
                elements(p, 100, 100);
                mesh::soften_contact(p);
            },
            |w| {
                w.run(0.02, 20)?;
                Ok(told(w))
            },
        ),
    ];
    for c in &mut list {
        if matches!(c.name, "four_hundred" | "undamped_fine" | "no_standstill") {
            c.allowed *= 4;
        }
    }
    list
}

fn force(p: &mut Parameters) {
    p.drive.source = Source::Force;
}

/// Loads, starts and interventions.
pub fn scenes() -> Vec<Case> {
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
            |w| {
                w.run(0.1, 200)?;
                Ok(told(w))
            },
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
                if lifted { Ok(told(w)) } else { Err(missed("lift-off", w)) }
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
                    Ok(told(w))
                } else {
                    Err(missed("rest", w))
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
            |w| {
                w.run(1e-3, 200)?;
                Ok(told(w))
            },
        ),
        case(
            "creeping_flight",
            "D1 = 0.5 m: the bit creeps in DFC through a long flight",
            |p, _| p.drive.stroke = 0.5,
            |w| {
                w.run(0.5, 100)?;
                Ok(told(w))
            },
        ),
        case(
            "equal_bars_long",
            "equal bars, every frequency twice: twenty cycles",
            |_, _| (),
            |w| {
                w.run(1.0, 200)?;
                Ok(told(w))
            },
        ),
        case(
            "no_drive",
            "F0 = 0: the piston falls once and rests",
            |p, _| p.drive.amplitude = 0.0,
            |w| {
                w.run(1.0, 200)?;
                Ok(told(w))
            },
        ),
        case(
            "swinging_drive",
            "external force, a quartic that turns within one step of 10 ms",
            |p, i| {
                force(p);
                i.drive_force = 0.0;
            },
            |w| {
                for _ in 0..10 {
                    w.machine
                        .set_input(Input::DriveForce, &[4000.0, -1.6e6, 2.4e8, -1.2e10, 6e9])?;
                    w.run(0.01, 1)?;
                }
                Ok(told(w))
            },
        ),
        case(
            "retuned_in_contact",
            "KR, gamma, CR, WR and F0 changed in mid-contact",
            |_, _| (),
            |w| {
                w.run(0.01372, 10)?;
                if !w.machine.mode().closed {
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
                Ok(told(w))
            },
        ),
        case(
            "step_of_ten_seconds",
            "one communication step of 10 s",
            |_, _| (),
            |w| {
                w.run(10.0, 1)?;
                Ok(told(w))
            },
        ),
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

/// A case that did not show what it is for.
pub fn missed(what: &'static str, w: &Watched) -> Fault {
    Fault::Wrong { what, time: w.machine.time(), value: 0.0, allowed: 1.0 }
}

/// What is left when host and step are taken out of a state.
pub fn trajectory(w: &mut hammer::Machine) -> hammer::State {
    let mut state = w.state();
    state.peaks = Default::default();
    state.step_start = 0.0;
    state
}

fn nanoseconds(w: &mut Watched) -> Result<String, Fault> {
    let (from, to, mut one) =
        (0.01367, 0.01369, Watched::new(w.machine.parameters(), &InputValues::default(), BLOWS)?);
    w.machine.advance(from)?;
    for k in 1..20_000 {
        w.machine.advance(from + 1e-9 * f64::from(k))?;
    }
    w.machine.advance(to)?;
    one.machine.advance(to)?;
    same(w, &mut one)
}

fn on_events(w: &mut Watched) -> Result<String, Fault> {
    let mut one = Watched::new(w.machine.parameters(), &InputValues::default(), BLOWS)?;
    one.machine.advance(0.1)?;
    let times: Vec<f64> = one.machine.take_journal().iter().map(|r| r.time).collect();
    for t in times {
        w.machine.advance(t)?;
        w.look()?;
    }
    w.machine.advance(0.1)?;
    same(w, &mut one)
}

fn same(w: &mut Watched, one: &mut Watched) -> Result<String, Fault> {
    if trajectory(&mut w.machine) == trajectory(&mut one.machine) {
        Ok(format!("{}, bitwise equal", told(w)))
    } else {
        Err(missed("bitwise equality", w))
    }
}
