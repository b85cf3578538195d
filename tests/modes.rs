//! The state machine of FMI 3.0 co-simulation: which call is allowed in which mode, and what a host finds after
//! restoring a state.

use crate::support::host::vr;
use crate::support::library::{ERROR, Handle, Library, OK};
use crate::support::three::{Ended, Three, extra};

/// The modes, by their names in messages, with the calls that lead to each.
const MODES: [(&str, &[&str]); 6] = [
    ("before initialization", &[]),
    ("in configuration mode", &["EnterConfigurationMode"]),
    ("in initialization mode", &["EnterInitializationMode"]),
    ("in event mode", &["EnterInitializationMode", "ExitInitializationMode"]),
    ("while stepping", &["EnterInitializationMode", "ExitInitializationMode", "EnterStepMode"]),
    ("after termination", &["EnterInitializationMode", "ExitInitializationMode", "Terminate"]),
];

/// Calls that FMI 3.0 allows (sections 2.3 and 4.2, state machine of co-simulation) in each of the modes above. No
/// structural parameter is tunable, so there is no reconfiguration mode.
const ALLOWED: [(&str, [u8; 6]); 19] = [
    ("EnterConfigurationMode", [1, 0, 0, 0, 0, 0]),
    ("ExitConfigurationMode", [0, 1, 0, 0, 0, 0]),
    ("EnterInitializationMode", [1, 0, 0, 0, 0, 0]),
    ("ExitInitializationMode", [0, 0, 1, 0, 0, 0]),
    ("EnterEventMode", [0, 0, 0, 0, 1, 0]),
    ("EnterStepMode", [0, 0, 0, 1, 0, 0]),
    ("UpdateDiscreteStates", [0, 0, 0, 1, 0, 0]),
    ("EvaluateDiscreteStates", [0, 0, 0, 1, 0, 0]),
    ("DoStep", [0, 0, 0, 0, 1, 0]),
    ("Terminate", [0, 0, 0, 1, 1, 0]),
    ("SetUInt64", [0, 1, 0, 0, 0, 0]),
    ("SetInt32", [1, 0, 1, 0, 0, 0]),
    ("SetBoolean", [1, 0, 1, 0, 0, 0]),
    ("SetFloat64 feed_force", [1, 0, 1, 1, 1, 0]),
    ("SetFloat64 rock.stiffness", [1, 0, 1, 1, 1, 0]),
    ("SetFloat64 contact.stiffness", [1, 0, 1, 0, 0, 0]),
    ("GetFloat64 tip_depth", [1, 1, 1, 1, 1, 1]),
    ("GetFMUState", [1, 1, 1, 1, 1, 1]),
    ("Reset", [1, 1, 1, 1, 1, 1]),
];

/// Makes one of these calls. Setters set an input, a tunable, a fixed or a structural parameter.
fn call(host: &Three, name: &str) -> i32 {
    if let Some((function, variable)) = name.split_once(' ') {
        return host.access(function, &[vr(variable)], &mut [1.3e8]);
    }
    match name {
        "EnterInitializationMode" => host.enter_initialization(0.0),
        "UpdateDiscreteStates" => host.try_update(),
        "DoStep" => host.try_step(0.0, 1e-3).0,
        "SetUInt64" => host.access(name, &[extra("waves.stations")], &mut [7_u64]),
        "SetInt32" => host.access(name, &[extra("event.positions")], &mut [0_i32]),
        "SetBoolean" => host.access(name, &[extra("event.blow")], &mut [1_u8]),
        "GetFMUState" => {
            let mut state = Handle(0);
            let status = host.save(&mut state);
            assert_eq!(host.forget(&mut state), OK);
            status
        }
        plain => host.plain(plain),
    }
}

#[test]
fn each_call_is_allowed_in_the_modes_of_the_standard_and_no_other() {
    let library = Library::load();
    for (mode, (words, way)) in MODES.iter().enumerate() {
        for (name, allowed) in ALLOWED {
            let host = Three::new(&library, true, true);
            for step in *way {
                assert_eq!(call(&host, step), OK, "{step}");
            }
            let expected = if allowed[mode] == 1 { OK } else { ERROR };
            assert_eq!(call(&host, name), expected, "{name} {words}: {:?}", host.lines());
            if expected == ERROR {
                let line = host.only_error();
                let function = name.split(' ').next().unwrap();
                let mine = line.starts_with(&format!("fmi3{function}"))
                    && line.ends_with(&format!("is not allowed {words}"));
                // The error names the variable, not the call.
                assert!(
                    mine || name.starts_with("Set") && line.contains("cannot be set"),
                    "{line}"
                );
            }
        }
    }
}

/// How each step of a run ends, and its event.
type Ends = Vec<(Ended, Option<[f64; 2]>)>;

/// The rest of a run: the ends of its steps, and the final bits.
fn rest(host: &Three, from: f64) -> (Ends, Vec<u64>) {
    let mut ends = Ends::new();
    host.run(from, 0.25, |ended, event| ends.push((ended, event)));
    let names = ["piston_position", "bit_tip_velocity", "tip_depth", "event_count"];
    (ends, host.fingerprint(&names))
}

#[test]
fn a_host_that_goes_back_meets_the_same_events_to_the_bit() {
    let library = Library::load();
    let host = Three::new(&library, true, true);
    host.set("Int32", extra("event.positions"), 1_i32);
    host.set("Float64", extra("event.position"), -0.02);
    host.start(true);
    let first = host.step(0.0, 0.25);
    assert!(first.early);
    // In event mode, and after a step that ended between two events.
    host.calls(&["EnterEventMode"]);
    let mut handling = Handle(0);
    assert_eq!(host.save(&mut handling), OK);
    let happened = host.happened();
    host.update();
    host.calls(&["EnterStepMode"]);
    let middle = host.step(first.time, 1e-4);
    assert!(!middle.event);
    let mut between = Handle(0);
    assert_eq!(host.save(&mut between), OK);
    let expected = rest(&host, middle.time);
    assert!(
        expected.0.len() > 10 && expected.0.iter().any(|(_, events)| *events == Some([1.0, 0.0]))
    );

    // Restores the state from the end, after another feed was tried.
    assert_eq!(host.restore(between), OK);
    host.set("Float64", vr("feed_force"), 9e3);
    assert_ne!(rest(&host, middle.time), expected);
    assert_eq!(host.restore(between), OK);
    assert_eq!(rest(&host, middle.time), expected);

    // Restores the state that was taken in event mode.
    assert_eq!(host.restore(handling), OK);
    assert_eq!(host.happened(), happened);
    assert_eq!(host.try_step(first.time, 1e-4).0, ERROR);
    assert_eq!(host.only_error(), "fmi3DoStep is not allowed in event mode");
    host.update();
    host.calls(&["EnterStepMode"]);
    assert_eq!(host.step(first.time, 1e-4), middle);
    assert_eq!(rest(&host, middle.time), expected);
    for mut state in [handling, between] {
        assert_eq!(host.forget(&mut state), OK);
    }
}

/// After a reset, everything is as before initialization: mode, events, passages, lengths and slopes.
#[test]
fn a_reset_out_of_any_mode_is_a_new_instance() {
    let library = Library::load();
    let fresh = Three::new(&library, true, true);
    fresh.start(true);
    let expected = rest(&fresh, 0.0);
    for (words, way) in MODES {
        let host = Three::new(&library, true, true);
        host.set("Int32", extra("event.positions"), 1_i32);
        host.set("Float64", extra("event.position"), -0.02);
        host.set("Float64", extra("feed_force_rate"), 1e4);
        host.set("Float64", vr("feed_force"), 6e3);
        for step in way {
            assert_eq!(call(&host, step), OK, "{step}");
        }
        if words == "while stepping" {
            assert!(host.step(0.0, 0.25).event);
        }
        host.calls(&["Reset"]);
        host.start(true);
        assert_eq!(rest(&host, 0.0), expected, "{words}");
    }
}
