//! Settings that are allowed but probably not intended are logged once, as a warning.

use crate::support::host::Host;
use crate::support::library::{ERROR, Library, OK};

const WARNING: i32 = 1;

/// The warnings since the last call. Nothing else may have been logged.
fn warnings(host: &Host) -> Vec<String> {
    let log = host.take_log();
    assert!(log.iter().all(|line| (line.0, &*line.1) == (WARNING, "logStatusWarning")), "{log:?}");
    log.into_iter().map(|line| line.2).collect()
}

#[test]
fn an_input_that_the_source_ignores() {
    let library = Library::load();
    let log = "drive_pressure is ignored: drive.source is Relay, and only Pressure reads it";
    let host = Host::running(&library, &[("drive_pressure", 1e6)]);
    assert_eq!(warnings(&host), [log]);
    host.set("drive_pressure", 2e6);
    host.step(0.0, 1e-3);
    assert!(warnings(&host).is_empty(), "once");
    // An input is set during the run, to its own value and to another.
    host.set("drive_force", 0.0);
    host.step(1e-3, 1e-3);
    assert!(warnings(&host).is_empty());
    host.set_derivative("drive_force", 1, 1e3);
    host.step(2e-3, 1e-3);
    let log = "drive_force is ignored: drive.source is Relay, and only Force reads it";
    assert_eq!(warnings(&host), [log]);
}

/// A host that cannot set enumerations leaves the drive as it was, and would make another hammer of a preset's numbers.
/// They are refused when initialisation ends, which may then be repeated; a number left at its start is not.
#[test]
fn a_parameter_of_a_drive_that_does_not_act() {
    let library = Library::load();
    for (name, value, readers) in [
        ("air.discharge", 0.7, "Air reads"),
        ("drive.area_drive", 0.005, "Pressure, Air read"),
        ("coupling.delay", 1.5, "Force, Pressure read"),
    ] {
        let host = Host::new(&library);
        let start = host.get(name);
        assert_ne!(start, value);
        host.set(name, value);
        host.plain("fmi2EnterInitializationMode");
        assert_eq!(library.plain("fmi2ExitInitializationMode", host.handle), ERROR);
        let log = host.only_error();
        let reason = format!("drive.source is Relay, and only {readers} it. Set drive.source too");
        assert!(log.starts_with(&format!("{name} = {value} is not allowed: {reason}")), "{log}");
        assert!(log.contains(&format!("leave it at {start} ")), "{log}");
        host.set(name, start);
        host.plain("fmi2ExitInitializationMode");
        host.step(0.0, 1e-3);
    }
    let host = Host::with(&library, &[("drive.area_drive", 5e-3), ("drive.source", 3.0)]);
    host.start(0.0);
}

#[test]
fn a_source_that_gets_nothing() {
    let library = Library::load();
    let log = "drive.source is Pressure, but nothing sets drive_pressure or return_pressure: \
                the piston is not driven";
    let [without, with, late] = [(); 3].map(|()| Host::with(&library, &[("drive.source", 3.0)]));
    with.set("return_pressure", 1e5);
    for host in [&without, &with, &late] {
        host.start(0.0);
        // A step of size 0 needs no drive.
        host.step(0.0, 0.0);
        assert!(warnings(host).is_empty());
    }
    // Masters set inputs only just before the first step.
    late.set("drive_pressure", 1e6);
    for (host, expected) in [(&without, &[log][..]), (&with, &[]), (&late, &[])] {
        host.step(0.0, 1e-3);
        assert_eq!(warnings(host), expected);
        host.step(1e-3, 1e-3);
        assert!(warnings(host).is_empty(), "once");
    }
}

#[test]
fn a_value_in_another_unit() {
    let library = Library::load();
    for (name, value, log) in [
        ("piston.length", 168.0, "168 m is 1000 times the reference hammer's 0.168 m"),
        ("feed_force", 5.0, "5 N is 0.001 times the reference hammer's 5000 N"),
        ("cross_section", 2600.0, "2600 m2 is 1000000 times the reference hammer's 0.0026 m2"),
    ] {
        let host = Host::running(&library, &[(name, value)]);
        // A piston of 168 m is also too heavy for its drive.
        let text = format!("{name} = {log}: is the unit right?");
        assert!(warnings(&host).contains(&text), "{text}");
    }
    // Laws that are switched off.
    let host = Host::running(&library, &[("rock.energy_barrier", 1e9), ("gravity", 0.0)]);
    host.step(0.0, 1e-3);
    assert!(warnings(&host).is_empty());
}

#[test]
fn nobody_is_warned_who_listens_to_no_warnings() {
    let library = Library::load();
    let host = Host::new(&library);
    assert_eq!(library.set_logging(host.handle, false, &["logStatusWarning"]), OK);
    host.set("piston.length", 168.0);
    host.start(0.0);
    assert!(host.take_log().is_empty());
}
