//! FMUs with other start values than the general one, which the library learns from their GUID.

use crate::support::host::{Host, vr};
use crate::support::library::{Library, OK};
use dth_hammer::GUID;
use dth_hammer::variant::SET;

const SCENE: [(&str, f64); 6] = [
    ("drive.source", 3.0),
    ("rock.stiffness", 3e8),
    ("bit.elements", 9.0),
    ("feed_force", 7e3),
    ("drive_pressure", 1.2e6),
    ("return_pressure", 2e5),
];

/// The GUID of the FMU with these start values.
fn guid(values: &[(&str, f64)]) -> String {
    let mut list: Vec<(u32, f64)> = values.iter().map(|(name, value)| (vr(name), *value)).collect();
    list.sort_by_key(|(reference, _)| *reference);
    let list: Vec<String> =
        list.iter().map(|(at, value)| format!("{at}:{:016x}", value.to_bits())).collect();
    format!("{GUID}{SET}{}", list.join(","))
}

/// A plain hammer that is set to the scene, and the FMU that starts with it.
fn both(library: &Library) -> [Host<'_>; 2] {
    [Host::with(library, &SCENE), Host::of_guid(library, &guid(&SCENE))]
}

fn run(host: &Host) -> Vec<u64> {
    host.start(0.0);
    host.step(0.0, 0.03);
    host.fingerprint()
}

#[test]
fn a_host_that_sets_nothing_simulates_the_scene() {
    let library = Library::load();
    let [plain, configured] = both(&library);
    assert_eq!(configured.get("feed_force"), 7e3);
    assert_eq!(run(&configured), run(&plain));
    assert_ne!(run(&Host::new(&library)), configured.fingerprint());
    // A reset goes back to the scene, not to the plain start values.
    configured.plain("fmi2Reset");
    assert_eq!(configured.get("rock.stiffness"), 3e8);
    assert_eq!(run(&configured), plain.fingerprint());
    let mut source = [0];
    library.get_ints(false, configured.handle, &[vr("drive.source")], &mut source);
    assert_eq!(source, [3]);
}

#[test]
fn what_is_set_goes_before_what_it_starts_with() {
    let library = Library::load();
    let [plain, configured] = both(&library);
    [&plain, &configured].iter().for_each(|host| host.set("drive_pressure", 2e6));
    assert_eq!(run(&configured), run(&plain));
}

#[test]
fn a_state_taken_before_the_start_keeps_the_scene() {
    let library = Library::load();
    let (plain, configured) = (Host::new(&library), Host::of_guid(&library, &guid(&SCENE)));
    let mut state = configured.state();
    assert_eq!(library.set_state(plain.handle, state), OK);
    assert_eq!(run(&plain), run(&configured));
    library.free_state(plain.handle, Some(&mut state));
}

#[test]
fn wrong_start_values_are_told_where_wrong_settings_are() {
    let library = Library::load();
    let host = Host::of_guid(&library, &guid(&[("rock.unloading_ratio", 0.5)]));
    host.plain("fmi2EnterInitializationMode");
    assert_ne!(library.plain("fmi2ExitInitializationMode", host.handle), OK);
    assert!(host.only_error().starts_with("rock.unloading_ratio = 0.5 is not allowed"));
    let wrong = format!("{GUID}{SET}{}:zz", vr("gravity"));
    assert_eq!(library.instantiate(Some("x"), 1, Some(&wrong), None, None, false).0, 0);
}
