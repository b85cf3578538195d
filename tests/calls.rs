//! Rules of the standard about calls and their order, tested through the C symbols.

use crate::support::host::{Host, vr};
use crate::support::library::{Callbacks, ERROR, Handle, Library, Log, OK};
use dth_hammer::GUID;
use hammer::Domain;
use hammer::variables::{Role, VARIABLES};

#[test]
fn instantiate_refuses_what_it_cannot_be() {
    let library = Library::load();
    let log = Log::default();
    let logging = Callbacks::logging(&log);
    let cases: [(Option<&str>, i32, Option<&str>); 5] = [
        (None, 1, Some(GUID)),
        (Some("x"), 0, Some(GUID)),
        (Some("x"), 7, Some(GUID)),
        (Some("x"), 1, Some("not the guid")),
        (Some("x"), 1, None),
    ];
    for (name, kind, guid) in cases {
        let handle = library.instantiate(name, kind, guid, None, Some(&logging), false);
        assert_eq!(handle, Handle(0), "{name:?} {kind} {guid:?}");
        assert_eq!(std::mem::take(&mut *log.lock().unwrap()).len(), 1);
    }
}

#[test]
fn instantiate_takes_what_hosts_give() {
    let library = Library::load();
    assert_eq!(library.version(), ["2.0", "default"]);
    let none = Callbacks::none();
    for (resources, callbacks) in
        [(None, Some(&none)), (Some("file:////tmp/a b"), Some(&none)), (Some(""), None)]
    {
        let handle = library.instantiate(Some("a b  c"), 1, Some(GUID), resources, callbacks, true);
        assert_ne!(handle, Handle(0));
        library.free(handle);
        assert_eq!(library.plain("fmi2Reset", handle), ERROR, "a freed instance is known as such");
    }
}

#[test]
fn a_step_needs_initialization() {
    let library = Library::load();
    let host = Host::new(&library);
    assert_eq!(library.step(host.handle, 0.0, 1e-3), ERROR);
    assert_eq!(host.only_error(), "fmi2DoStep is not allowed before initialization");
    host.plain("fmi2EnterInitializationMode");
    assert_eq!(library.step(host.handle, 0.0, 1e-3), ERROR);
    assert_eq!(host.only_error(), "fmi2DoStep is not allowed in initialization mode");
    assert_eq!(library.plain("fmi2EnterInitializationMode", host.handle), ERROR);
    assert_eq!(library.set_up(host.handle, 0.0, None), ERROR);
    host.take_log();
    host.plain("fmi2ExitInitializationMode");
    host.step(0.0, 1e-3);
    host.plain("fmi2Terminate");
    assert_eq!(library.step(host.handle, 1e-3, 1e-3), ERROR);
    assert_eq!(host.only_error(), "fmi2DoStep is not allowed after termination");
    assert!(host.get("piston_position") > 0.0, "outputs stay readable");
    host.plain("fmi2Reset");
    host.start(0.25);
    host.step(0.25, 1e-3);
}

#[test]
fn every_parameter_out_of_its_domain_is_refused_by_name_value_and_range() {
    let library = Library::load();
    let host = Host::new(&library);
    let mut refused = 0;
    for variable in VARIABLES.iter() {
        let Role::Parameter(_) = &variable.role else { continue };
        let (wrong, range) = match variable.domain() {
            Some(Domain::AtLeast(low)) => (low - 1.0, format!("at least {low}")),
            Some(Domain::Above(low)) => (low, format!("above {low}")),
            Some(Domain::Between(low, high)) => (high + 1.0, format!("{low} to {high}")),
            Some(Domain::Any) | None => continue,
        };
        // A section is read only if it exists.
        if let Some((body, _)) = variable.name.split_once(".segment[") {
            host.set(&format!("{body}.segments"), 8.0);
        }
        host.set(variable.name, wrong);
        host.plain("fmi2EnterInitializationMode");
        assert_eq!(library.plain("fmi2ExitInitializationMode", host.handle), ERROR);
        let line = host.only_error();
        let begin = format!("{} = {wrong} is not allowed: it must be ", variable.name);
        assert!(line.starts_with(&begin) && line.ends_with(&range), "{line}");
        host.plain("fmi2Reset");
        refused += 1;
    }
    assert!(refused > 20, "{refused}");
    host.start(0.0);
    host.step(0.0, 1e-3);
}

#[test]
fn a_set_call_that_fails_changes_nothing() {
    let library = Library::load();
    let host = Host::new(&library);
    let (feed, depth) = (vr("feed_force"), vr("tip_depth"));
    let before = host.get("feed_force");
    let large = "input feed_force: a value of -1e300 is not allowed: it must be from -5e12 to 5e12";
    let calls: [(&[u32], &[f64], &str); 5] = [
        (&[feed, feed], &[1.0, -1e300], large),
        (&[feed, feed], &[1.0, f64::NAN], "feed_force = NaN is not allowed"),
        (&[feed, feed], &[1.0, f64::INFINITY], "feed_force = inf is not allowed"),
        (&[feed, depth], &[1.0, 2.0], "tip_depth cannot be set: it is a result"),
        (&[feed, 9999], &[1.0, 2.0], "value reference 9999 is not that of a real variable"),
    ];
    for (references, values, text) in calls {
        assert_eq!(library.set_reals(host.handle, references, values), ERROR);
        let line = host.only_error();
        assert!(line.starts_with(text), "{line}");
        assert_eq!(host.get("feed_force").to_bits(), before.to_bits());
    }
    assert_eq!(library.set_derivatives(host.handle, &[feed], &[1], &[1e19]), ERROR);
    let line = host.only_error();
    assert!(line.contains("a rate of 1e19 is not allowed"), "{line}");
    assert!(line.ends_with("it must be from -5e18 to 5e18"), "{line}");
    host.start(0.0);
    assert_eq!(library.set_reals(host.handle, &[vr("gravity")], &[0.0]), ERROR);
    assert_eq!(host.only_error(), "gravity cannot be set: it is fixed after initialization");
    assert_eq!(library.set_ints(false, host.handle, &[vr("fidelity")], &[1]), ERROR);
    assert_eq!(host.only_error(), "fidelity cannot be set: it is fixed after initialization");
    assert_eq!(library.set_reals(host.handle, &[vr("rock.stiffness")], &[-1.0]), ERROR);
    assert!(host.only_error().starts_with("rock.stiffness = -1 is not allowed"));
    host.set("rock.stiffness", 2e8);
    host.step(0.0, 1e-3);
    assert_eq!(host.get("rock.stiffness"), 2e8);
}

#[test]
fn every_variable_can_be_read_at_any_time_and_only_as_what_it_is() {
    let library = Library::load();
    let host = Host::new(&library);
    let read_all = |when: &str| {
        for (reference, variable) in (0u32..).zip(VARIABLES.iter()) {
            let (mut real, mut int) = ([0.0], [0]);
            let as_real = library.get_reals(host.handle, &[reference], &mut real) == OK;
            let as_int = library.get_ints(false, host.handle, &[reference], &mut int) == OK;
            let as_bool = library.get_ints(true, host.handle, &[reference], &mut int) == OK;
            let found = [as_real, as_int, as_bool];
            assert_eq!(found.iter().filter(|f| **f).count(), 1, "{when}: {}", variable.name);
            if let Role::Output(_) = variable.role {
                assert!(as_real && real[0].is_finite(), "{when}: {}", variable.name);
            }
        }
    };
    read_all("instantiated");
    host.plain("fmi2EnterInitializationMode");
    read_all("in initialization mode");
    host.plain("fmi2ExitInitializationMode");
    read_all("before the first step");
    host.set("feed_force", 4e3);
    read_all("after a set without a step");
    host.step(0.0, 1e-3);
    read_all("after a step");
    host.plain("fmi2Terminate");
    read_all("terminated");
}

#[test]
fn nothing_is_looked_at_when_the_count_is_zero() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    for name in ["Real", "Integer", "Boolean", "String"] {
        for verb in ["Get", "Set"] {
            let call = format!("fmi2{verb}{name}");
            assert_eq!(library.null_arrays(&call, host.handle, 0), OK, "{call}");
            for count in [1, 1000, usize::MAX / 8, usize::MAX] {
                assert_eq!(library.null_arrays(&call, host.handle, count), ERROR, "{call}");
                host.only_error();
            }
            assert_eq!(library.null_arrays(&call, Handle(0), 0), ERROR);
        }
    }
}

#[test]
fn the_communication_point_may_be_off_by_rounding_only() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    host.step(1e-10, 1e-3);
    assert_eq!(library.real_status(host.handle, 2), (OK, 1e-10 + 1e-3), "point + size, exactly");
    host.step(1e-3, 0.0);
    for (point, size) in [
        (2e-3, 1e-3),
        (0.0, 1e-3),
        (f64::NAN, 1e-3),
        (1e-3, f64::NAN),
        (1e-3, -1e-3),
        (1e-3, f64::INFINITY),
        (1e-3, 1e30),
    ] {
        assert_eq!(library.step(host.handle, point, size), ERROR, "{point} {size}");
        host.only_error();
        assert_eq!(library.int_status("fmi2GetStatus", host.handle, 0), (OK, ERROR));
    }
    host.step(1e-3, 1e-3);
    assert_eq!(library.int_status("fmi2GetStatus", host.handle, 0), (OK, OK));
}

#[test]
fn the_stop_time_holds_but_for_a_hair() {
    let library = Library::load();
    let host = Host::new(&library);
    for (start, stop) in [(0.0, -1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert_eq!(library.set_up(host.handle, start, Some(stop)), ERROR);
        host.only_error();
    }
    assert_eq!(library.set_up(host.handle, 0.0, Some(2e-3)), OK);
    host.plain("fmi2EnterInitializationMode");
    host.plain("fmi2ExitInitializationMode");
    host.step(0.0, 1e-3);
    host.step(1e-3, 1e-3 + 1e-9);
    assert_eq!(library.step(host.handle, 2e-3, 1e-3), ERROR);
    assert!(host.only_error().contains("past the stop time"));
}

#[test]
fn log_categories_can_be_switched_while_running() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    let mut time = 0.0;
    let mut categories = |host: &Host| {
        host.take_log();
        // Long enough for a blow, so that there is something to log.
        host.step(time, 0.05);
        time += 0.05;
        let mut found: Vec<String> = host.take_log().into_iter().map(|line| line.1).collect();
        found.dedup();
        found
    };
    assert!(categories(&host).is_empty());
    assert_eq!(library.set_logging(host.handle, true, &["logEvents"]), OK);
    assert_eq!(categories(&host), ["logEvents"]);
    assert_eq!(library.set_logging(host.handle, true, &["logAll"]), OK);
    assert!(categories(&host).contains(&"logEvents".to_owned()));
    assert_eq!(library.set_logging(host.handle, false, &[]), OK);
    assert!(categories(&host).is_empty());
    assert_eq!(library.set_logging(host.handle, true, &["logNonsense"]), ERROR);
    assert!(host.take_log().is_empty(), "off is off, for errors too");
    assert_eq!(library.set_logging(host.handle, true, &["logStatusError"]), OK);
    assert_eq!(library.set_logging(host.handle, true, &["logNonsense"]), ERROR);
    assert!(host.only_error().contains("logNonsense"));
    assert_eq!(library.set_logging(host.handle, false, &["logStatusError"]), OK);
    assert_eq!(library.step(host.handle, -1.0, 0.0), ERROR);
    assert!(host.take_log().is_empty());
}

#[test]
fn messages_are_written_as_the_standard_and_people_read_them() {
    let library = Library::load();
    let log = Log::default();
    let logging = Callbacks::logging(&log);
    library.instantiate(Some("x"), 1, Some("#r3#"), None, Some(&logging), false);
    let log = log.lock().unwrap().remove(0).2;
    assert!(log.contains("##r3##"), "{log}");
    let host = Host::running(&library, &[]);
    assert_eq!(library.step(host.handle, 1e-300, 1e-3), OK);
    for (point, size, expected) in
        [(0.5, 1e-300, "0.5 s"), (1e-3, -1e-300, "-1e-300 s"), (1e-3, 1e200, "1e200 s")]
    {
        assert_eq!(library.step(host.handle, point, size), ERROR);
        let log = host.only_error();
        assert!(log.contains(expected) && log.len() < 120, "{log}");
    }
    host.plain("fmi2Reset");
    host.set("rock.stiffness", -1e-300);
    host.plain("fmi2EnterInitializationMode");
    assert_eq!(library.plain("fmi2ExitInitializationMode", host.handle), ERROR);
    assert!(host.only_error().starts_with("rock.stiffness = -1e-300 is not allowed"));
}

#[test]
fn no_output_is_minus_nothing() {
    let library = Library::load();
    let host = Host::running(&library, &[("drive.amplitude", 0.0)]);
    let mut time = 0.0;
    for size in [0.0, 1e-3, 0.01, 0.02] {
        host.step(time, size);
        time += size;
        for variable in VARIABLES.iter().filter(|v| matches!(v.role, Role::Output(_))) {
            for value in [host.get(variable.name), host.rate(variable.name)] {
                assert!(value != 0.0 || value.is_sign_positive(), "{} at {time}", variable.name);
            }
        }
    }
}

#[test]
fn who_debugs_is_told_the_vectors_that_the_engine_runs_in() {
    let library = Library::load();
    let host = Host::with_logging(&library, true);
    let log = host.take_log();
    assert_eq!(log.len(), 1, "{log:?}");
    assert_eq!((log[0].0, &*log[0].1), (OK, "logEvents"));
    assert_eq!(log[0].2, format!("the engine runs in {} vectors", hammer::Vectors::in_use()));
    assert!(Host::new(&library).take_log().is_empty());
}

#[test]
fn the_status_family_answers() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    let h = host.handle;
    assert_eq!(library.int_status("fmi2GetStatus", h, 0), (OK, OK));
    assert_eq!(library.real_status(h, 2), (OK, 0.0));
    assert_eq!(library.int_status("fmi2GetBooleanStatus", h, 3), (OK, 0));
    assert_eq!(library.string_status(h, 1), (OK, "no step is pending".into()));
    assert_eq!(library.int_status("fmi2GetIntegerStatus", h, 0).0, ERROR);
    assert_eq!(library.real_status(h, 77).0, ERROR);
}

/// ctypes, Julia and Java pass the logger's text as a format without arguments. Text from a host or a user must
/// appear in it unchanged. (The collector of these tests refuses a format that asks for an argument.)
#[test]
fn what_looks_like_a_format_is_logged_as_it_was_written() {
    let library = Library::load();
    let host = Host::new(&library);
    for text in ["%s", "%n", "100 %", "%%", "%1$s%n%*d", "%s%s%s%s%s%s%n"] {
        assert_eq!(library.set_logging(host.handle, true, &[text]), ERROR);
        let error = host.only_error();
        assert!(error.contains(text), "{error}");
        let log = Log::default();
        let callbacks = Callbacks::logging(&log);
        let named = library.instantiate(Some(text), 1, Some(text), None, Some(&callbacks), true);
        assert_eq!(named.0, 0, "the GUID is none");
        let lines = log.lock().unwrap();
        assert!(lines.iter().any(|(_, _, line)| line.contains(text)), "{lines:?}");
    }
}
