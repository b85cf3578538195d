//! The FMU with its own start values, except for `overdamped`, against extended precision. It finds errors of the
//! face that a comparison of the engine alone would miss.

use crate::support::host::{Host, vr};
use crate::support::library::{Library, OK};
use hammer::presets::Preset;
use oracles::law::{Event, Rock};
use oracles::reference::stored;

/// The label of `rock_mode`, and whether the contact is closed.
fn mode(host: &Host) -> (Rock, bool) {
    let mut mode = [0];
    let integers = host.library.get_ints(false, host.handle, &[vr("rock_mode")], &mut mode);
    let mut closed = [0];
    let booleans = host.library.get_ints(true, host.handle, &[vr("contact_closed")], &mut closed);
    assert_eq!((integers, booleans), (OK, OK));
    let rock = [Rock::FF, Rock::DFC, Rock::FC, Rock::BC, Rock::SS][mode[0] as usize - 1];
    (rock, closed[0] == 1)
}

#[test]
fn two_blows_are_the_oracles() {
    let reference = stored(20).expect("a stored solution");
    let library = Library::load();
    let host = Host::new(&library);
    for (name, value) in Preset::named("overdamped").expect("a preset").differences() {
        match name {
            "mesh.degree" | "piston.elements" | "bit.elements" => host.set_int(name, value as i32),
            _ => host.set(name, value),
        }
    }
    host.start(0.0);
    let mut time = 0.0;
    for state in &reference.states {
        host.step(time, state.time - time);
        time = state.time;
        // The engine's tolerance in 1 mm and 1 m/s. It is a hundred times larger from the second blow on, since each
        // touch of the rock multiplies rounding. The error of a force is its law times that.
        let unit = if host.get("blow_count") > 1.0 { 1e-7 } else { 1e-9 };
        let rock = &reference.scene.rock;
        let push = rock.ratio * rock.stiffness * 1e-3 + rock.viscosity;
        let (tip, speed) = (state.u.last().expect("nodes"), state.v.last().expect("nodes"));
        for (name, exact, scale) in [
            ("bit_tip_position", *tip, 1e-3),
            ("bit_tip_velocity", *speed, 1.0),
            ("relative_position", state.relative, 1e-3),
            ("tip_depth", state.memory.uu, 1e-3),
            ("contact_force", state.contact_force, reference.scene.contact_stiffness * 1e-3),
            ("rock_force", state.rock_force, push),
        ] {
            let off = (host.get(name) - exact).abs();
            assert!(off <= unit * scale, "{name} at {time} s: {off:e}");
        }
        assert_eq!(mode(&host), (state.mode.rock, state.mode.closed), "at {time} s");
        let events = reference.events.iter().filter(|event| event.time <= time).count();
        assert_eq!(host.get("event_count"), events as f64, "at {time} s");
    }
    // A blow is the first closing after a fall; the bit's rebounds follow within a millisecond. The error of its time
    // is that of every event: the resolution of a velocity guard over the smallest slope.
    let mut closings = reference.events.iter().filter(|event| event.event == Event::Close);
    let second = closings.find(|event| event.time > 50e-3).expect("a second blow");
    assert_eq!(host.get("blow_count"), 2.0);
    let off = (host.get("blow_time") - second.time).abs();
    assert!(off <= 1e-10, "{off:e}");
}
