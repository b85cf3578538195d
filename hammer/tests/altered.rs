//! Altered states: whoever changes a number of a stored state gets motion or a named error, and no
//! step of it takes more work than its budget.

use hammer::{Counters, Error, Fidelity, InputValues, Machine, Parameters, Source, State};
use serde_json::Value;

/// Units of work that a step may take within a second's allowance: 375 million coordinates, of which a
/// unit takes 20 at least, and what one guard does between two looks at it, 64 windows of 4096 steps each.
const BUDGET: u64 = 375_000_000 / 20 + 64 * 4096;

/// Evaluations, rotations and windows, as the counters tell them.
fn work(counters: Counters) -> u64 {
    counters.guard_evaluations + counters.samples + counters.scans + 16 * counters.windows
}

/// What stands in place of a number of the state.
const STRANGE: [f64; 8] = [0.0, -1.0, 1e300, -1e300, 1e-300, 1e6, 1e9, -0.3];

/// Puts `strange` in place of number `place` of all that `value` holds; false if it holds fewer.
fn alter(value: &mut Value, place: &mut usize, strange: f64) -> bool {
    match value {
        Value::Number(number) => {
            if *place > 0 {
                *place -= 1;
                return false;
            }
            // What was whole stays so: nothing else is read back.
            *value = if number.is_f64() { strange.into() } else { (strange.abs() as u64).into() };
            true
        }
        Value::Array(items) => items.iter_mut().any(|item| alter(item, place, strange)),
        Value::Object(items) => items.values_mut().any(|item| alter(item, place, strange)),
        _ => false,
    }
}

/// A scene in flight, contacts, rock and drive at work; in a casing of some mass, its bit may hang on
/// the ring and vent the drive.
fn scene(fidelity: Fidelity, source: Source, casing: f64) -> Machine {
    let mut p = Parameters { fidelity, ..Parameters::default() };
    (p.mesh.degree, p.piston.elements, p.bit.elements, p.drive.source) = (1, 2, 2, source);
    (p.casing.mass, p.casing.impedance) = (casing, 100.0 * casing);
    (p.chuck.travel, p.chuck.idle_travel) = (2e-3, 1e-3);
    p.work_limit = 1;
    let inputs = InputValues::default();
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    machine.advance(0.02).expect("a step");
    machine.advance(0.02125).expect("a step");
    machine
}

#[test]
fn an_altered_state_ends_in_motion_or_a_named_error_within_its_budget() {
    let mut ends = [0; 4];
    for (fidelity, source, casing) in [
        (Fidelity::Rigid, Source::Air, 0.0),
        (Fidelity::Elastic, Source::Relay, 0.0),
        (Fidelity::Elastic, Source::Relay, 40.0),
    ] {
        let machine = scene(fidelity, source, casing);
        let honest = serde_json::to_value(machine.state()).expect("a state in JSON");
        for place in 0.. {
            let (mut forged, strange) = (honest.clone(), STRANGE[place % STRANGE.len()]);
            if !alter(&mut forged, &mut place.clone(), strange) {
                assert!(place > 200, "only {place} numbers");
                break;
            }
            let end = serde_json::from_value::<State>(forged).ok().map(|state| {
                let mut other = scene(fidelity, source, casing);
                other.restore(&state)?;
                let from = other.time();
                let before = work(other.counters());
                let stepped = other.advance(other.time() + 0.02);
                let done = work(other.counters()) - before;
                assert!(done <= BUDGET, "number {place} as {strange}: {done} units");
                other.kinematics();
                assert!(other.time() >= from, "number {place} as {strange}: time runs backwards");
                assert!(stepped.is_err() || other.time() == from + 0.02, "{place}");
                stepped
            });
            let end = match end {
                None => 0,
                Some(Ok(())) => 1,
                Some(Err(Error::Overwork { .. })) => 2,
                Some(Err(error)) => {
                    assert!(!error.to_string().is_empty());
                    3
                }
            };
            ends[end] += 1;
        }
    }
    let [_, moved, overwork, refused] = ends;
    assert!(moved > 50 && overwork > 0 && refused > 50, "{ends:?}");
}

/// What has happened is in the past: a blow to come would be one of negative period.
#[test]
fn a_state_whose_past_is_to_come_is_refused() {
    let machine = scene(Fidelity::Rigid, Source::Relay, 0.0);
    let honest = serde_json::to_value(machine.state()).expect("a state in JSON");
    let mut other = scene(Fidelity::Rigid, Source::Relay, 0.0);
    let places = [
        "/blows/last/time",
        "/blows/milestones/0/time",
        "/blows/milestones/1/time",
        "/blows/collision",
        "/blows/opened",
        "/zeno/burst_start",
    ];
    for place in places {
        let mut forged = honest.clone();
        let value = forged.pointer_mut(place).unwrap_or_else(|| panic!("{place}: {honest}"));
        assert!(alter(value, &mut 0, machine.time() + 1e-3), "{place}");
        let state = serde_json::from_value(forged).expect("a state");
        assert!(matches!(other.restore(&state), Err(Error::Corrupt { .. })), "{place}");
    }
    let state = serde_json::from_value(honest).expect("a state");
    other.restore(&state).expect("as it was written");
}

/// A host's name of an instant is rounded, so a state may name an event's a little before it: nothing is turned
/// back then.
#[test]
fn a_state_that_is_named_before_its_event_stands_at_it() {
    let machine = scene(Fidelity::Elastic, Source::Relay, 0.0);
    let mut state = serde_json::to_value(machine.state()).expect("a state in JSON");
    let epoch = state["motion"]["epoch"]["high"].as_f64().expect("a number");
    let named = epoch - 1e-12 * (1.0 + 0.9 * epoch);
    let place = |state: &mut Value, place: &str, value: f64| {
        *state.pointer_mut(place).unwrap_or_else(|| panic!("{place}")) = value.into();
    };
    place(&mut state, "/motion/time", named);
    place(&mut state, "/motion/now", 0.0);
    place(&mut state, "/step_start", 0.0);
    let mut other = scene(Fidelity::Elastic, Source::Relay, 0.0);
    let state = serde_json::from_value(state).expect("a state");
    other.restore(&state).expect("within the rounding");
    let before = other.kinematics().relative_position;
    other.advance(named).expect("no step");
    // 1 m/s for 1e-12 s, and the forces of a blow.
    let moved = other.kinematics().relative_position - before;
    assert!(moved.abs() < 1e-11, "{moved:e}");
    other.advance(epoch + 1e-3).expect("a step");
}

/// The tip's work would be summed from there in panels of some 1e-6 s.
#[test]
fn a_bit_that_stands_ages_before_its_event_is_refused() {
    let machine = scene(Fidelity::Elastic, Source::Relay, 0.0);
    let mut state = serde_json::to_value(machine.state()).expect("a state in JSON");
    state["motion"]["anchors"][0]["at"] = (-1e6).into();
    let state: State = serde_json::from_value(state).expect("a state");
    let mut other = scene(Fidelity::Elastic, Source::Relay, 0.0);
    assert!(matches!(other.restore(&state), Err(Error::Corrupt { .. })));
}
