//! The blows of a communication step, one by one, through the C functions.

use crate::support::host::Host;
use crate::support::library::{ERROR, Handle, Library, OK};
use dth_hammer::blows::{COUNT, first};
use hammer::families::OF_BLOW;

const END: f64 = 0.4;

fn at(host: &Host, reference: u32) -> f64 {
    let mut value = [f64::NAN];
    let status = host.library.get_reals(host.handle, &[reference], &mut value);
    assert_eq!(status, OK, "{:?}", host.take_log());
    value[0]
}

/// All figures of the last step's blows, a row each.
fn rows(host: &Host) -> Vec<Vec<u64>> {
    let figure = |family, index| at(host, first(family) + index).to_bits();
    let row = |index| (0..OF_BLOW.len()).map(|family| figure(family, index)).collect();
    (0..at(host, COUNT) as u32).map(row).collect()
}

/// The table of blows of a run in steps of one size.
fn table(library: &Library, steps: u32) -> Vec<Vec<u64>> {
    let host = Host::running(library, &[]);
    let point = |k: u32| END * f64::from(k) / f64::from(steps);
    let mut found = Vec::new();
    for k in 0..steps {
        host.step(point(k), point(k + 1) - point(k));
        found.extend(rows(&host));
        assert_eq!(found.len() as f64, host.get("blow_count"));
    }
    found
}

#[test]
fn the_table_of_blows_does_not_depend_on_the_step() {
    let library = Library::load();
    let one = table(&library, 1);
    assert!(one.len() > 5, "{}", one.len());
    for steps in [2, 7, 400] {
        assert_eq!(table(&library, steps), one, "{steps} steps");
    }
}

#[test]
fn each_blow_is_as_the_outputs_told_it() {
    let figures = hammer::families::OF_BLOW.iter();
    let outputs_of: Vec<&str> = figures.map(|figure| figure.output).collect();
    let library = Library::load();
    let host = Host::running(&library, &[]);
    assert_eq!(at(&host, COUNT), 0.0);
    let (mut time, mut reported) = (0.0, 0);
    while time < 0.1 {
        host.step(time, 1e-3);
        time += 1e-3;
        for row in rows(&host) {
            let outputs: Vec<u64> =
                outputs_of.iter().map(|name| host.get(name).to_bits()).collect();
            assert_eq!(row, outputs);
            reported += 1;
        }
    }
    assert!(reported >= 2);
}

#[test]
fn what_was_no_blow_is_an_error_and_no_blow_can_be_set() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    host.step(0.0, 1e-3);
    assert_eq!(library.get_reals(host.handle, &[first(0)], &mut [0.0]), ERROR);
    assert_eq!(host.only_error(), "there is no step_blow_time[1]: the last step had 0 blows");
    assert_eq!(library.set_reals(host.handle, &[first(0)], &[1.0]), ERROR);
    assert_eq!(host.only_error(), "a blow cannot be set: it is a result");
}

#[test]
fn a_restored_state_has_the_blows_of_its_step() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    host.step(0.0, 0.2);
    let before = rows(&host);
    assert!(before.len() > 1);
    let mut state = Handle(0);
    assert_eq!(library.get_state(host.handle, Some(&mut state)), OK);
    host.step(0.2, 0.0);
    assert!(rows(&host).is_empty());
    assert_eq!(library.set_state(host.handle, state), OK);
    assert_eq!(rows(&host), before);
    library.free_state(host.handle, Some(&mut state));
}
