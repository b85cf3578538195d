//! The FMU with its own start values, except for `overdamped`, against extended precision. It finds errors of the
//! face that a comparison of the engine alone would miss.

use crate::support::host::{Host, vr};
use crate::support::library::{Library, OK};
use hammer::presets::Preset;
use oracles::law::{Event, Rock};
use oracles::model::Model;
use oracles::reference::{ELEMENTS, stored};

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
    let reference = stored().expect("a stored solution");
    let model = Model::<f64>::new(&reference.scene);
    let library = Library::load();
    let host = Host::new(&library);
    for (name, value) in Preset::named("overdamped").expect("a preset").differences() {
        host.set(name, if name.ends_with(".elements") { ELEMENTS as f64 } else { value });
    }
    host.start(0.0);
    let mut time = 0.0;
    for sample in &reference.states {
        host.step(time, sample.time - time);
        time = sample.time;
        // The engine's tolerance in 1 mm and 1 m/s. It is a hundred times larger from the second blow on, since each
        // touch of the rock multiplies rounding. The error of a force is its law times that.
        let unit = if host.get("blow_count") > 1.0 { 1e-7 } else { 1e-9 };
        let rock = &reference.scene.rock;
        let push = rock.ratio * rock.stiffness * 1e-3 + rock.viscosity;
        let [u, v] = [&sample.state.u, &sample.state.v]
            .map(|row| row.iter().map(|x| x.hi).collect::<Vec<_>>());
        let [contact, pressed] = sample.forces;
        for (name, exact, scale) in [
            ("bit_tip_position", u[model.tip], 1e-3),
            ("bit_tip_velocity", v[model.tip], 1.0),
            ("relative_position", model.mean_difference(&u) - reference.scene.gap, 1e-3),
            ("tip_depth", sample.memory.uu.hi, 1e-3),
            ("contact_force", contact.hi, reference.scene.contact_stiffness * 1e-3),
            ("rock_force", pressed.hi, push),
        ] {
            let off = (host.get(name) - exact).abs();
            assert!(off <= unit * scale, "{name} at {time} s: {off:e}");
        }
        assert_eq!(mode(&host), (sample.mode.rock, sample.mode.closed), "at {time} s");
        let events = reference.events.iter().filter(|event| event.time.hi <= time).count();
        assert_eq!(host.get("event_count"), events as f64, "at {time} s");
    }
    // A blow is the first closing after a fall; the bit's rebounds follow within a millisecond. The error of its time
    // is that of every event: the resolution of a velocity guard over the smallest slope.
    let mut closings = reference.events.iter().filter(|event| event.event == Event::Close);
    let second = closings.find(|event| event.time.hi > 50e-3).expect("a second blow");
    assert_eq!(host.get("blow_count"), 2.0);
    let off = (host.get("blow_time") - second.time.hi).abs();
    assert!(off <= 1e-10, "{off:e}");
}
