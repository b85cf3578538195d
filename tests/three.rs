//! The FMI 3.0 face by its C symbols: the same hammer as in FMI 2.0, with events.

use crate::support::host::{FINGERPRINT as NAMES, Host, vr};
use crate::support::library::{ERROR, Handle, Library, OK};
use crate::support::three::{Three, extra};
use dth_hammer::events::Extra;
use dth_hammer::symbols;
use hammer::variables::OF_BLOW;
use hammer::{InputValues, Machine, Parameters};

const END: f64 = 0.25;

/// FMI 2.0 in steps of `size`: the instants of blows as reported, and the bits at the end.
fn two(library: &Library, size: f64) -> (Vec<u64>, Vec<u64>) {
    let host = Host::running(library, &[]);
    let (mut blows, mut point) = (Vec::new(), 0.0);
    while point < END {
        let end = (point + size).min(END);
        host.step(point, end - point);
        point = end;
        let instant = host.get("blow_time").to_bits();
        if host.get("blow_count") > blows.len() as f64 {
            blows.push(instant);
        }
    }
    (blows, host.fingerprint())
}

/// The next point of a grid with this spacing.
fn point_after(point: f64, size: f64) -> f64 {
    let after = (0..).map(|step| f64::from(step) * size).find(|next| *next > point);
    after.unwrap_or(END).min(END)
}

/// FMI 3.0 in steps of `size` with events: their instants, kinds, and relative positions.
fn three(host: &Three, size: f64) -> Vec<(f64, [i32; 2], f64)> {
    let (mut point, mut events) = (0.0, Vec::new());
    while point < END {
        let next = point_after(point, size);
        let ended = host.step(point, next - point);
        assert_eq!(ended.early, ended.event && ended.time < next);
        assert!(ended.early || ended.time == next);
        point = ended.time;
        assert_eq!(host.get(extra("time")), point);
        if ended.event {
            host.event(|host, happened| {
                let happened = happened.map(|number| number as i32);
                events.push((point, happened, host.get(vr("relative_position"))));
            });
        }
    }
    events
}

#[test]
fn steps_end_at_blows_to_the_bit_and_the_motion_is_that_of_fmi_2() {
    let library = Library::load();
    let (blows, end) = two(&library, 1e-3);
    assert!(blows.len() > 3, "{blows:?}");
    for size in [0.05, 0.013, END] {
        let host = Three::new(&library, true, true);
        host.start(true);
        let events = three(&host, size);
        assert!(events.iter().all(|event| event.1 == [1, 0]));
        let found: Vec<u64> = events.iter().map(|event| event.0.to_bits()).collect();
        assert_eq!(found, blows, "in steps of {size} s");
        assert_eq!(host.fingerprint(&NAMES), end, "in steps of {size} s");
    }
}

#[test]
fn a_host_without_events_or_early_return_gets_whole_steps() {
    let library = Library::load();
    let (_, end) = two(&library, 0.05);
    for [events, early] in [[false, false], [true, false], [false, true]] {
        let host = Three::new(&library, events, early);
        host.start(events);
        let mut before = 0.0;
        for step in 0..5 {
            let (point, next) = (f64::from(step) * 0.05, f64::from(step + 1) * 0.05);
            let ended = host.step(point, next - point);
            assert!(!ended.early && ended.time == point + (next - point));
            let blows = host.get(vr("blow_count"));
            assert_eq!(ended.event, events && blows > before, "{events} {early}");
            assert_eq!(host.happened(), Some([f64::from(u8::from(ended.event)), 0.0]));
            before = blows;
            if ended.event {
                host.event(|_, _| ());
            }
        }
        assert!(before > 3.0);
        assert_eq!(host.get(vr("blow_time")).to_bits(), end[7]);
        assert_eq!(host.get(vr("event_count")).to_bits(), end[6]);
    }
}

/// Steps end where the piston passes a position. Without early return the same passages are reported at the end of
/// their step, even those that go back within it, and they do not change the motion.
#[test]
fn passages_are_told_without_early_return_too() {
    const LEVELS: [f64; 2] = [-0.005, -0.03];
    let library = Library::load();
    let run = |early: bool| {
        let host = Three::new(&library, true, early);
        host.set("Boolean", extra("event.blow"), 0_u8);
        host.set("Int32", extra("event.positions"), 2_i32);
        for (index, level) in LEVELS.into_iter().enumerate() {
            host.set("Float64", Extra::Position(index).reference(), level);
        }
        host.start(true);
        (three(&host, 0.013), host.fingerprint(&NAMES))
    };
    let ((ending, end), (noted, same)) = (run(true), run(false));
    assert_eq!(end, same);
    assert_eq!(end, two(&library, 1e-3).1, "nothing moves by it");
    for (time, [kind, position], x) in &ending {
        // At 10 m/s, some units in the last place of the time.
        let off = x - LEVELS[*position as usize - 1];
        assert!(*kind == 2 && off.abs() < 1e-14, "{x} at {time} s is {off} m off");
    }
    // At a communication point, the last of its step's passages is reported.
    let mut last: Vec<(f64, i32)> = Vec::new();
    for (time, [_, position], _) in ending {
        let point = point_after(time.next_down(), 0.013);
        last.retain(|(at, _)| *at != point);
        last.push((point, position));
    }
    let noted_last: Vec<(f64, i32)> = noted.iter().map(|(time, [_, at], _)| (*time, *at)).collect();
    assert!(noted_last.len() > 6, "{noted_last:?}");
    assert_eq!(noted_last, last);
}

#[test]
fn blows_need_not_end_a_step() {
    let library = Library::load();
    let host = Three::new(&library, true, true);
    host.set("Boolean", extra("event.blow"), 0_u8);
    host.start(true);
    assert_eq!(three(&host, 0.05), []);
}

/// The hammer's relay, in a host: two monitored positions, and a force that it sets.
#[test]
fn a_relay_outside_in_steps_of_50_ms_is_the_relay_inside() {
    let library = Library::load();
    let inside = Host::running(&library, &[]);
    let (amplitude, stroke) = (inside.get("drive.amplitude"), inside.get("drive.stroke"));
    let force = vr("drive_force");
    let host = Three::new(&library, true, true);
    host.set("Int64", vr("drive.source"), 2_i64);
    host.set("Int32", extra("event.positions"), 2_i32);
    host.set("Float64", Extra::Position(0).reference(), -stroke);
    host.set("Float64", Extra::Position(1).reference(), 0.0);
    host.set("Float64", force, inside.get("applied_drive_force"));
    host.start(true);
    let (mut point, mut calls) = (0.0, 0);
    while point < END {
        let next = point_after(point, 0.05);
        let ended = host.step(point, next - point);
        (point, calls) = (ended.time, calls + 1);
        if ended.event {
            host.event(|host, _| {
                let x = host.get(vr("relative_position"));
                let now = host.get(force);
                if now < 0.0 && x <= -stroke {
                    host.set("Float64", force, amplitude);
                } else if now > 0.0 && x >= 0.0 {
                    host.set("Float64", force, -amplitude);
                }
            });
        }
    }
    inside.step(0.0, END);
    for name in ["blow_count", "blow_time", "blow_speed", "piston_position", "tip_depth"] {
        let [found, expected] = [host.get(vr(name)), inside.get(name)];
        assert!((found - expected).abs() < 1e-10, "{name}: {found}, not {expected}");
    }
    assert!(calls < 60, "{calls} calls");
}

#[test]
fn a_slope_makes_an_input_the_line_that_a_derivative_makes_of_it() {
    let library = Library::load();
    let derived = Host::running(&library, &[]);
    let host = Three::new(&library, false, false);
    host.start(false);
    let (mut point, size) = (0.0, 0.02);
    for (value, slope) in [(4e3, 1e5), (6e3, -4e4), (5e3, 0.0)] {
        derived.set("feed_force", value);
        derived.set_derivative("feed_force", 1, slope);
        derived.step(point, size);
        host.set("Float64", extra("feed_force_rate"), slope);
        host.set("Float64", vr("feed_force"), value);
        assert_eq!(host.get(extra("feed_force_rate")), slope);
        point = host.step(point, size).time;
        assert_eq!(host.fingerprint(&NAMES), derived.fingerprint());
    }
}

#[test]
fn waves_are_arrays_as_long_as_the_host_has_said_before() {
    let library = Library::load();
    let host = Three::new(&library, false, false);
    let stations = extra("waves.stations");
    assert_eq!(host.access("SetUInt64", &[stations], &mut [7_u64]), ERROR);
    assert!(host.only_error().starts_with("waves.stations cannot be set: it is structural"));
    host.calls(&["EnterConfigurationMode"]);
    assert_eq!(host.access("SetUInt64", &[stations], &mut [0_u64]), ERROR);
    let range = "waves.stations = 0 is not allowed: it must be 1 to 10000";
    assert_eq!(host.only_error(), range);
    // As many stations as elements, so that each is at the middle of its element.
    let count = Parameters::default().piston.elements;
    host.set("UInt64", stations, count as u64);
    assert_eq!(host.enter_initialization(0.0), ERROR);
    let line = host.only_error();
    assert_eq!(line, "fmi3EnterInitializationMode is not allowed in configuration mode");
    host.calls(&["ExitConfigurationMode"]);
    host.start(false);
    let mut machine = hammer();
    machine.advance(0.05).unwrap();
    host.step(0.0, 0.05);
    let mut stress = vec![f64::NAN; count];
    assert_eq!(host.access("GetFloat64", &[extra("piston_stress")], &mut stress), OK);
    assert_eq!(stress, machine.profile().piston_stress);
    let short = &mut stress[..count - 1];
    assert_eq!(host.access("GetFloat64", &[extra("piston_stress")], short), ERROR);
    assert!(host.only_error().starts_with("nValues = "));
}

/// With more than three blows in a step, the arrays contain what the engine reports blow by blow.
#[test]
fn blows_of_a_step_are_arrays_and_too_short_ones_have_the_last() {
    let library = Library::load();
    let mut machine = hammer();
    machine.advance(END).unwrap();
    let blows = machine.step_blows();
    let count = blows.len();
    assert!(count > 3, "{count}");
    for room in [count + 2, count, count - 2] {
        let host = Three::new(&library, false, false);
        host.calls(&["EnterConfigurationMode"]);
        host.set("UInt64", extra("blows.capacity"), room as u64);
        host.calls(&["ExitConfigurationMode"]);
        host.start(false);
        host.step(0.0, END);
        assert_eq!(host.get(extra("step_blow_count")), count as f64);
        for row in &OF_BLOW {
            let mut found = vec![f64::NAN; room];
            assert_eq!(host.access("GetFloat64", &[extra(row.name)], &mut found), OK);
            let last = blows.iter().skip(count.saturating_sub(room));
            let mut expected: Vec<f64> = last.map(row.value).collect();
            expected.resize(room, 0.0);
            assert_eq!(found, expected, "{} in {room} places", row.name);
        }
    }
}

/// The default hammer in the engine.
fn hammer() -> Machine {
    Machine::new(&Parameters::default(), &InputValues::default(), 0.0).unwrap()
}

#[test]
fn a_host_without_event_mode_or_the_token_is_told() {
    let library = Library::load();
    let plain = Three::new(&library, false, true);
    plain.start(false);
    assert_eq!(plain.plain("EnterEventMode"), ERROR);
    assert!(plain.only_error().ends_with("eventModeUsed was false"));
    let line = Three::refused(&library, "not the token");
    assert!(line.starts_with("instantiationToken is \"not the token\""), "{line}");
}

#[test]
fn what_is_of_another_type_or_a_result_is_refused() {
    let library = Library::load();
    let host = Three::new(&library, true, true);
    let (feed, depth, source) = (vr("feed_force"), vr("tip_depth"), vr("drive.source"));
    let wrong: [(&str, u32); 7] = [
        ("GetInt32", feed),
        ("GetInt32", source),
        ("GetInt64", feed),
        ("GetInt32", extra("event_kind")),
        ("GetClock", extra("event_kind")),
        ("GetBoolean", extra("event.positions")),
        ("GetUInt8", feed),
    ];
    for (call, reference) in wrong {
        assert_eq!(host.access(call, &[reference], &mut [0_u64]), ERROR, "{call}");
        assert!(host.only_error().starts_with(&format!("value reference {reference} is not")));
    }
    assert_eq!(host.access("SetFloat64", &[feed, depth], &mut [1.0, 2.0]), ERROR);
    assert_eq!(host.only_error(), "tip_depth cannot be set: it is a result");
    assert_eq!(host.get(feed), 5e3, "nothing was set");
    host.set("Int32", extra("event.positions"), 9_i32);
    assert_eq!(host.enter_initialization(0.0), OK);
    assert_eq!(host.plain("ExitInitializationMode"), ERROR);
    assert_eq!(host.only_error(), "event.positions = 9 is not allowed: it must be 0 to 8");
    host.set("Int32", extra("event.positions"), 8_i32);
    host.calls(&["ExitInitializationMode"]);
    let fixed = host.access("SetInt32", &[extra("event.positions")], &mut [1_i32]);
    assert_eq!(fixed, ERROR);
    let line = host.only_error();
    assert_eq!(line, "event.positions cannot be set: it is fixed after initialization");
}

#[test]
fn each_function_refuses_what_is_no_handle_and_survives_null_pointers() {
    let library = Library::load();
    let gone = Host::new(&library).handle;
    let [beside, alone] = [(); 2].map(|()| Host::running(&library, &[]));
    let two = Host::running(&library, &[]);
    let three = Three::new(&library, true, true);
    three.start(true);
    let mut refused = 0;
    for name in symbols() {
        // Functions without an instance, or without a result.
        let other = ["GetVersion", "GetTypesPlatform", "Instantiate", "FreeInstance"];
        if other.iter().any(|begin| name[4..].starts_with(begin)) {
            continue;
        }
        for handle in [0, gone.0, usize::MAX] {
            assert_eq!(library.with_nothing(&name, Handle(handle)), ERROR, "{name}");
            refused += 1;
        }
        for handle in [two.handle, three.handle] {
            let status = library.with_nothing(&name, handle);
            assert!([OK, ERROR].contains(&status), "{name}: {status}");
        }
        // The handle of one standard in a function of the other may have changed its phase.
        three.calls(&["Reset"]);
        three.start(true);
    }
    assert_eq!(refused, 3 * (30 + 70));
    assert!(three.lines().iter().all(|line| !line.contains("internal error")));
    for host in [&beside, &alone] {
        host.step(0.0, 0.05);
    }
    assert_eq!(beside.fingerprint(), alone.fingerprint());
}

#[test]
fn without_logging_nothing_is_told_and_without_arrays_nothing_is_structural() {
    let library = Library::load();
    let host = Three::silent(&library, dth_hammer::TOKEN, [true; 2]);
    for call in ["EnterConfigurationMode", "ExitConfigurationMode", "EnterStepMode", "Terminate"] {
        assert_eq!(host.plain(call), ERROR, "{call}");
    }
    assert_eq!(host.lines(), [""; 0]);
    host.start(true);
    let arrays = Three::new(&library, true, true);
    assert_eq!(arrays.plain("ExitConfigurationMode"), ERROR);
    assert_eq!(arrays.lines().len(), 1);
}
