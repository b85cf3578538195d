//! An outside drive through both standards: the same numbers as from the engine, and the warnings.

use crate::support::host::{Host, vr};
use crate::support::library::{ERROR, Library, OK};
use crate::support::three::{Three, extra};
use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Source};

const STEP: f64 = 1e-4;
/// Stiffness of trapped oil, 75 kN/mm; duration in steps.
const STIFFNESS: f64 = 7.5e7;
const STEPS: u32 = 60;
const SCENE: [(&str, f64); 3] =
    [("contact.initial_gap", 1e-4), ("piston.initial_velocity", 3.0), ("coupling.delay", 0.5)];
const READ: [&str; 4] = ["piston_position", "piston_velocity", "energy_exchange", "blow_count"];

fn by_engine() -> Vec<f64> {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    (p.contact.initial_gap, p.piston.initial_velocity) = (1e-4, 3.0);
    (p.drive.source, p.drive.delay) = (Source::Force, 0.5);
    let mut machine = Machine::new(&p, &InputValues::default(), 0.0).unwrap();
    let mut found = Vec::new();
    for step in 0..STEPS {
        machine.set_input(Input::DriveForce, &[-STIFFNESS * machine.swept()]).unwrap();
        machine.advance(f64::from(step) * STEP + STEP).unwrap();
        let now = machine.kinematics();
        let blows = machine.counters().blows as f64;
        let exchanged = machine.exchanged_energy();
        found.extend([now.piston.displacement, now.piston.velocity, exchanged, blows]);
    }
    found
}

fn start_two(library: &Library) -> Host<'_> {
    let host = Host::new(library);
    start(&host);
    host
}

/// Starts a new or reset instance with the scene.
fn start(host: &Host) {
    let driven = [("fidelity", 1.0), ("drive.source", 2.0)];
    driven.iter().chain(&SCENE).for_each(|(name, value)| host.set(name, *value));
    host.start(0.0);
}

fn start_three(library: &Library, events: bool) -> Three<'_> {
    let host = Three::new(library, events, events);
    host.set("Int64", vr("fidelity"), 1_i64);
    host.set("Int64", vr("drive.source"), 2_i64);
    SCENE.iter().for_each(|(name, value)| host.set("Float64", vr(name), *value));
    host.start(events);
    host
}

/// The swept volume over the area: the piston's position since the start.
const SWEPT: &str = "relative_position";

/// Repeated values, calls of getters, restoring a state, event mode with early returns: none of these changes a bit
/// of the engine's results.
#[test]
fn both_standards_extrapolate_as_the_engine() {
    let (library, expected) = (Library::load(), by_engine());
    let host = start_two(&library);
    let (began, mut found) = (host.get(SWEPT), Vec::new());
    for step in 0..STEPS {
        let force = -STIFFNESS * (host.get(SWEPT) - began);
        for set in [force, 1.0, force] {
            host.set("drive_force", set);
        }
        if step % 7 == 3 {
            let mut state = host.state();
            host.step(f64::from(step) * STEP, STEP);
            assert_eq!(library.set_state(host.handle, state), OK);
            library.free_state(host.handle, Some(&mut state));
        }
        host.step(f64::from(step) * STEP, STEP);
        found.extend(READ.map(|name| host.get(name)));
    }
    assert_eq!(found, expected);
    assert!(found.last() >= Some(&1.0), "it strikes");
    for events in [false, true] {
        let (host, mut found) = (start_three(&library, events), Vec::new());
        let (began, mut early) = (host.get(vr(SWEPT)), 0);
        for step in 0..STEPS {
            let force = -STIFFNESS * (host.get(vr(SWEPT)) - began);
            host.set("Float64", vr("drive_force"), force);
            host.set("Float64", extra("drive_force_rate"), 0.0);
            let at = f64::from(step) * STEP;
            host.run(at, at + STEP, |ended, _| early += usize::from(ended.early));
            found.extend(READ.map(|name| host.get(vr(name))));
        }
        // After an early return the end of a step is a sum, and so has a rounding error.
        let close = |(a, b): (&f64, &f64)| (a - b).abs() <= if events { 1e-9 } else { 0.0 };
        assert!(found.iter().zip(&expected).all(close), "{events}");
        assert_eq!(early > 0, events);
    }
}

/// After a reset and a new start, nothing is left of the earlier exchange.
#[test]
fn a_reset_forgets_what_was_handed_over() {
    let library = Library::load();
    let run = |host: &Host| {
        for step in 0..5 {
            host.set("drive_force", 1e3 * f64::from(step * step));
            host.step(f64::from(step) * STEP, STEP);
        }
        READ.map(|name| host.get(name))
    };
    let host = start_two(&library);
    let first = run(&host);
    host.plain("fmi2Reset");
    start(&host);
    assert_eq!(run(&host), first);
    // The delay is tunable, with effect from the next step.
    let held = start_two(&library);
    held.set("coupling.delay", 0.0);
    assert_ne!(run(&held), first);
    held.take_log();
    assert_eq!(library.set_reals(held.handle, &[vr("coupling.delay")], &[2.5]), ERROR);
    let log = held.only_error();
    assert_eq!(log, "coupling.delay = 2.5 is not allowed: it must be -0.5 to 2");
}

/// An exchange that makes more than a hundredth of a cycle's work is told, with step, delay and remedy, and again each
/// time that this has doubled. Other warnings are given once: of an impact that steel does not withstand, with any drive; and of a feed that does not press.
#[test]
fn what_a_step_shows_is_told_once_or_as_it_doubles() {
    let library = Library::load();
    let host = start_two(&library);
    host.set("coupling.delay", 0.0);
    let began = host.get(SWEPT);
    for step in 0..2000 {
        host.set("drive_force", -STIFFNESS * (host.get(SWEPT) - began));
        host.step(f64::from(step) * 2e-5, 2e-5);
    }
    let log: Vec<String> = host.take_log().into_iter().map(|line| line.2).collect();
    let reported: Vec<&String> =
        log.iter().filter(|text| text.starts_with("energy_exchange: ")).collect();
    let share = |text: &String| text.split(" %").next()?.rsplit(' ').next()?.parse::<f64>().ok();
    let shares: Vec<f64> = reported.iter().filter_map(|text| share(text)).collect();
    // Rounded to a hundredth of a per cent.
    assert!(shares.first() > Some(&0.99) && shares.len() == reported.len(), "{log:?}");
    assert!(shares.windows(2).all(|two| two[1] > 2.0 * two[0] - 0.02), "{shares:?}");
    for part in ["steps of 0.00002 s", "coupling.delay = 0 ", "set coupling.delay (0.5"] {
        assert!(reported[0].contains(part), "{}", reported[0]);
    }
    let thrown = [("fidelity", 1.0), ("piston.initial_velocity", 14.0), ("feed_force", 0.0)];
    let hard = Host::running(&library, &thrown);
    for step in 0..20 {
        hard.step(f64::from(step) * 1e-3, 1e-3);
    }
    let log: Vec<String> = hard.take_log().into_iter().map(|line| line.2).collect();
    let count = |start: &str| log.iter().filter(|text| text.starts_with(start)).count();
    let reported = ["An impact at 1", "feed_force = 0 N at the first step: "].map(count);
    assert_eq!(reported, [1, 1], "{log:?}");
}

/// A host whose clock counts from 1970 gets the same motion, with blows on its clock.
#[test]
fn a_run_that_starts_years_on_is_that_from_zero() {
    let library = Library::load();
    // Multiples of 2^-10 s, which both clocks represent exactly.
    let (step, start) = (2f64.powi(-10), 1.7e9);
    let read = |from: f64| {
        let host = Host::new(&library);
        host.start(from);
        for k in 0..64 {
            host.step(from + f64::from(k) * step, step);
        }
        let blow = host.get("blow_time");
        assert_eq!(library.step(host.handle, from, step), ERROR, "not a point that was");
        host.take_log();
        (["piston_position", "tip_depth", "blow_count"].map(|name| host.get(name)), blow)
    };
    let ((here, blow), (there, late)) = (read(0.0), read(start));
    assert_eq!(here, there);
    // The spacing of doubles at that time.
    assert!((late - start - blow).abs() <= 2.4e-7 && blow > 0.01, "{late} {blow}");
}
