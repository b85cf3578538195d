//! The engine against a Taylor solution in double-double arithmetic of an independently
//! assembled model (`evidence/oracles/data`, made by the crate `oracles`; its own uncertainty is below
//! 1e-20 on the state).

use hammer::{InputValues, Machine, Parameters, Record, RockMode};
use serde_json::Value;

fn reference(elements: usize) -> Value {
    let path = format!(
        "{}/../evidence/oracles/data/reference_{elements}.json",
        env!("CARGO_MANIFEST_DIR")
    );
    let text = std::fs::read_to_string(path).expect("the stored reference");
    serde_json::from_str(&text).expect("JSON")
}

fn machine(elements: usize) -> Machine {
    let mut parameters = Parameters::default();
    (parameters.piston.elements, parameters.bit.elements) = (elements, elements);
    Machine::new(&parameters, &InputValues::default(), 0.0).expect("a scene")
}

fn short(mode: RockMode) -> &'static str {
    match mode {
        RockMode::FreeFlight => "FF",
        RockMode::DissipativeForward => "DFC",
        RockMode::Forward => "FC",
        RockMode::Backward => "BC",
        RockMode::Standstill => "SS",
    }
}

/// Largest error of the state at an instant: displacements over 1 mm, velocities over 1 m/s.
fn error(machine: &mut Machine, state: &Value) -> f64 {
    let profile = machine.profile();
    let ours = profile.piston.iter().chain(&profile.bit);
    let list = |key: &str| state[key].as_array().expect("a list").clone();
    let theirs = list("u").into_iter().zip(list("v"));
    ours.zip(theirs)
        .map(|(x, (u, v))| {
            let (u, v) = (u.as_f64().expect("number"), v.as_f64().expect("number"));
            ((x[0] - u).abs() / 1e-3).max((x[1] - v).abs())
        })
        .fold(0.0, f64::max)
}

fn events(machine: &mut Machine, until: f64) -> Vec<Record> {
    machine.keep_journal(true);
    machine.advance(until).expect("a run");
    machine.take_journal()
}

/// 1e-9 after the first blow and 1e-7 after the second: rounding (1e-16 of displacements of
/// 0.05 m, 1e-14 of 1 mm and so on) multiplied at each touch of the rock, by 1e1 to 1e3.
#[test]
fn the_state_agrees_after_the_first_blow_and_after_the_second() {
    for elements in [5, 10, 20, 40] {
        let mut machine = machine(elements);
        let reference = reference(elements);
        for state in reference["states"].as_array().expect("states") {
            let time = state["time"].as_f64().expect("time");
            machine.advance(time).expect("a run");
            let bound = if machine.counters().blows < 2 { 1e-9 } else { 1e-7 };
            let error = error(&mut machine, state);
            assert!(error <= bound, "{elements} elements, t = {time}: {error:e}");
        }
    }
}

/// The same transitions in the same order, each to 1e-10 s: the resolution of a velocity
/// guard, 1e-9 m/s, over slopes that are at least 10 m/s2 where a tip creeps back into the
/// rock; elsewhere to rounding.
#[test]
fn every_event_of_two_blows_is_found_in_order_and_in_time() {
    for elements in [5, 10, 20, 40] {
        let reference = reference(elements);
        let theirs = reference["events"].as_array().expect("events");
        let last = theirs.last().expect("an event")["time"].as_f64().expect("time");
        let ours = events(&mut machine(elements), last + 1e-6);
        assert_eq!(ours.len(), theirs.len(), "{elements} elements");
        for (i, (r, e)) in ours.iter().zip(theirs).enumerate() {
            let mode = (Some(r.mode.closed), Some(short(r.mode.rock)));
            let expected = (e["mode"]["closed"].as_bool(), e["mode"]["rock"].as_str());
            assert_eq!(mode, expected, "{elements} elements, event {i}");
            let rest = e["time_rest"].as_f64().expect("rest");
            let off = (r.time - e["time"].as_f64().expect("time")) + (r.time_rest - rest);
            assert!(off.abs() < 1e-10, "{elements} elements, event {i}: {off:e} s");
        }
    }
}
