//! Uses each capability that the description claims.

use crate::support::host::{Host, vr};
use crate::support::library::{ERROR, Handle, Library, OK};
use hammer::variables::{Role, VARIABLES};

const STEP: f64 = 1e-3;

/// A hammer whose piston flies free under `drive_force`: its motion is a polynomial.
fn free_flight(library: &Library) -> Host<'_> {
    let scene = [("drive.source", 2.0), ("gravity", 0.0), ("contact.initial_gap", 10.0)];
    Host::running(library, &scene)
}

fn piston_mass(host: &Host) -> f64 {
    ["material.density", "cross_section", "piston.length"]
        .map(|name| host.get(name))
        .iter()
        .product()
}

#[track_caller]
fn close(found: f64, expected: f64) {
    let error = (found - expected).abs();
    assert!(error <= 1e-11 * expected.abs().max(1e-3), "{found} is not {expected}: {error:e}");
}

#[test]
fn inputs_are_polynomials_inside_a_step() {
    let library = Library::load();
    let host = free_flight(&library);
    let [force, slope, second] = [100.0, 4e5, -3e8];
    host.set("drive_force", force);
    // In any order.
    host.set_derivative("drive_force", 2, second);
    host.set_derivative("drive_force", 1, slope);
    host.step(0.0, STEP);
    let t = STEP;
    let mass = piston_mass(&host);
    let speed = (force * t + slope * t * t / 2.0 + second * t.powi(3) / 6.0) / mass;
    let place = (force * t * t / 2.0 + slope * t.powi(3) / 6.0 + second * t.powi(4) / 24.0) / mass;
    close(host.get("piston_velocity"), speed);
    close(host.get("piston_position"), place);
    close(host.get("drive_force"), force + slope * t + second * t * t / 2.0);
}

#[test]
fn an_input_goes_on_until_it_is_set_again() {
    let library = Library::load();
    let host = free_flight(&library);
    host.set("drive_force", 0.0);
    host.set_derivative("drive_force", 1, 1e5);
    host.step(0.0, STEP);
    host.step(STEP, STEP);
    close(host.get("drive_force"), 1e5 * 2.0 * STEP);
    host.set("drive_force", 7.0);
    assert_eq!(host.get("drive_force"), 7.0, "before the step, too");
    host.step(2.0 * STEP, STEP);
    assert_eq!(host.get("drive_force"), 7.0, "a value alone is constant");
    assert_eq!(host.get("applied_drive_force"), 7.0);
    // A slope alone goes on from the value that there is.
    host.set_derivative("drive_force", 1, 1e3);
    host.step(3.0 * STEP, STEP);
    close(host.get("drive_force"), 7.0 + 1e3 * STEP);
}

#[test]
fn unsuitable_derivatives_are_refused() {
    let library = Library::load();
    let host = free_flight(&library);
    let force = vr("drive_force");
    for (reference, order, value) in [
        (force, 0, 1.0),
        (force, -1, 1.0),
        (force, 5, 1.0),
        (force, i32::MAX, 1.0),
        (force, 1, f64::NAN),
        (vr("gravity"), 1, 1.0),
        (9999, 1, 1.0),
    ] {
        let status = library.set_derivatives(host.handle, &[reference], &[order], &[value]);
        assert_eq!(status, ERROR, "{reference} {order} {value}");
        host.only_error();
    }
}

#[test]
fn output_derivatives_are_those_of_the_outputs() {
    let library = Library::load();
    let host = free_flight(&library);
    host.set("drive_force", 340.0);
    host.step(0.0, STEP);
    close(host.rate("piston_position"), host.get("piston_velocity"));
    close(host.rate("piston_velocity"), 340.0 / piston_mass(&host));
    assert_eq!(host.rate("blow_count"), 0.0);
    for (name, order) in [("piston_position", 0), ("piston_position", -1), ("gravity", 1)] {
        let status = library.derivatives(host.handle, &[vr(name)], &[order], &mut [0.0]);
        assert_eq!(status, ERROR, "{name} {order}");
        host.only_error();
    }
    // The standard demands 0 for a derivative that is not known.
    for variable in VARIABLES.iter().filter(|variable| matches!(variable.role, Role::Output(_))) {
        for order in [3, 4, 17, i32::MAX] {
            assert_eq!(host.derivative(variable.name, order), 0.0, "{} {order}", variable.name);
        }
    }
}

/// A value and its first two derivatives, of every output at one instant.
type Jet = Vec<[f64; 3]>;

fn jet(host: &Host) -> Jet {
    let outputs = VARIABLES.iter().filter(|variable| matches!(variable.role, Role::Output(_)));
    let of = |name| [host.get(name), host.derivative(name, 1), host.derivative(name, 2)];
    outputs.map(|variable| of(variable.name)).collect()
}

/// Five jets `SPACING` apart, the middle one at `at`; `None` if an event is between them.
fn stencil(host: &Host, time: &mut f64, at: f64) -> Option<[Jet; 5]> {
    let mut events = Vec::new();
    let jets = std::array::from_fn(|k| {
        let to = at + (k as f64 - 2.0) * SPACING;
        host.step(*time, to - *time);
        *time = to;
        events.push(host.get("event_count"));
        jet(host)
    });
    (events[0] == events[4]).then_some(jets)
}

/// Spacing of the stencil's points, s. The fastest mode of an element of 8.4 mm has 2.1e6 rad/s, and an energy twice
/// that: the formula of fourth order has an error of (4.2e6 * 1e-8)^4 / 30 = 1e-7 of an amplitude; rounding of a
/// displacement of 0.1 m to 1e-17 contributes 1e-9 m/s.
const SPACING: f64 = 1e-8;

/// Hammers by three drives, with inputs that change.
fn driven<'a>(library: &'a Library, source: i32) -> Host<'a> {
    let by = [("drive.source", source.into()), ("drive_pressure", 1e6)];
    let thrown = [("contact.initial_gap", 2e-3), ("piston.initial_velocity", 9.0)];
    // The first has a casing, whose shoulder presses against the bit by spring and dashpot.
    let more: &[_] = match source {
        1 => &[("casing.mass", 40.0), ("chuck.viscosity", 1e5)],
        4 => &[("air.error", 1e-11)],
        _ => &[],
    };
    let host = Host::running(library, &[&by[..], &thrown, more].concat());
    for (name, value, slope) in
        [("drive_force", 900.0, 3e5), ("drive_pressure", 1e6, 4e8), ("return_pressure", 2e5, -1e8)]
    {
        host.set(name, value);
        host.set_derivative(name, 1, slope);
        host.set_derivative(name, 2, slope * 1e3);
    }
    host.set_derivative("feed_force", 1, 2e5);
    host
}

#[test]
fn every_output_derivative_is_that_of_its_output() {
    let library = Library::load();
    let outputs: Vec<_> = VARIABLES
        .iter()
        .filter_map(
            |v| if let Role::Output(output) = &v.role { Some((v.name, output)) } else { None },
        )
        .collect();
    // In flight, in the collision, and while the bit drills and rebounds. No window of air ends within a stencil: there
    // the force may leap by ten times `air.error`.
    let instants = [1e-4, 2.26e-4, 2.4e-4, 2.61e-4, 2.8e-4, 4e-4, 7e-4, 1.5e-3, 3e-3, 6e-3];
    for source in 1..=4 {
        let host = driven(&library, source);
        let mut time = 0.0;
        let stencils: Vec<_> =
            instants.iter().filter_map(|at| stencil(&host, &mut time, *at)).collect();
        assert!(stencils.len() >= 8, "{} of {source}", stencils.len());
        assert!(host.get("blow_count") >= 1.0 && host.get("rock_cycle_count") >= 1.0);
        for (index, (name, output)) in outputs.iter().enumerate() {
            // Outputs that belong to the last step; errors, which have no rate; and outputs that change only when a
            // value is passed.
            let of_steps =
                ["_peak", "_flow_mean", "energy_exchange"].iter().any(|end| name.ends_with(end));
            if of_steps || name.ends_with("residual") {
                continue;
            }
            for order in [1, 2] {
                if order == 2 && output.second.is_none() {
                    continue;
                }
                let differences: Vec<f64> = stencils.iter().map(|s| s[2][index][order]).collect();
                let found = stencils.iter().map(|s| {
                    let f = |k: usize| s[k][index][order - 1];
                    (8.0 * (f(3) - f(1)) - (f(4) - f(0))) / (12.0 * SPACING)
                });
                let size = differences.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                let values = stencils.iter().map(|s| s[2][index][order - 1].abs());
                let rounding = values.fold(0.0, f64::max) * 1e-13 / SPACING;
                for (found, differences) in found.zip(&differences) {
                    assert!(
                        (found - differences).abs() <= 1e-5 * size + rounding,
                        "{name}, order {order}, source {source}: {differences:e} is not {found:e}"
                    );
                }
            }
        }
    }
}

/// Continues from a state with pending inputs and parameters, in three instances.
#[test]
fn a_state_goes_on_bit_for_bit_wherever_it_is_restored() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    host.step(0.0, 0.03);
    host.set("feed_force", 4500.0);
    host.set_derivative("feed_force", 1, 1e3);
    host.set("rock.viscosity", 1.8e5);
    let state = host.state();
    let bytes = library.serialize(host.handle, state).expect("serialises");
    let go_on = |host: &Host| {
        host.step(0.03, 0.05);
        host.fingerprint()
    };
    let expected = go_on(&host);

    assert_eq!(library.set_state(host.handle, state), OK);
    assert_eq!(host.get("rock.viscosity"), 1.8e5);
    assert_eq!(go_on(&host), expected, "in the same instance");

    let other = Host::new(&library);
    assert_eq!(library.set_state(other.handle, state), OK);
    assert_eq!(go_on(&other), expected, "in a new instance");

    let longer = Host::running(&library, &[("bit.length", 0.3)]);
    let mut from_bytes = Handle(0);
    assert_eq!(library.deserialize(longer.handle, &bytes, &mut from_bytes), OK);
    assert_eq!(library.set_state(longer.handle, from_bytes), OK);
    assert_eq!(go_on(&longer), expected, "in another scene, from bytes");
    for mut state in [state, from_bytes] {
        assert_eq!(library.free_state(host.handle, Some(&mut state)), OK);
        assert_eq!(state, Handle(0));
    }
}

#[test]
fn a_state_can_be_taken_in_any_phase() {
    let library = Library::load();
    let host = Host::with(&library, &[("feed_force", 3e3)]);
    let instantiated = host.state();
    host.plain("fmi2EnterInitializationMode");
    let initialising = host.state();
    host.plain("fmi2ExitInitializationMode");
    host.step(0.0, 1e-3);
    host.plain("fmi2Terminate");
    let terminated = host.state();

    let other = Host::new(&library);
    assert_eq!(library.set_state(other.handle, terminated), OK);
    assert_eq!(library.step(other.handle, 1e-3, 1e-3), ERROR);
    assert_eq!(other.fingerprint(), host.fingerprint());
    assert_eq!(library.set_state(other.handle, initialising), OK);
    other.plain("fmi2ExitInitializationMode");
    other.step(0.0, 1e-3);
    assert_eq!(other.fingerprint(), host.fingerprint());
    assert_eq!(library.set_state(other.handle, instantiated), OK);
    assert_eq!(other.get("feed_force"), 3e3);
    other.start(0.0);
    other.step(0.0, 1e-3);
    assert_eq!(other.fingerprint(), host.fingerprint());
    for mut state in [instantiated, initialising, terminated] {
        library.free_state(host.handle, Some(&mut state));
    }
}

#[test]
fn a_damaged_or_stale_state_is_refused() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    host.step(0.0, 1e-3);
    let mut state = host.state();
    let bytes = library.serialize(host.handle, state).expect("serialises");
    let before = host.fingerprint();
    let refused = |bytes: &[u8], why: &str| {
        let mut made = Handle(0);
        assert_eq!(library.deserialize(host.handle, bytes, &mut made), ERROR, "{why}");
        assert_eq!(made, Handle(0));
        let line = host.only_error();
        assert!(line.contains(why), "{line}");
    };
    for (position, why) in [
        (0, "not a state"),
        (4, "another version"),
        (9, "length"),
        (16, "checksum"),
        (20, "another build"),
        (bytes.len() - 1, "checksum"),
    ] {
        let mut damaged = bytes.clone();
        damaged[position] ^= 1;
        refused(&damaged, why);
    }
    refused(&bytes[..bytes.len() - 1], "length");
    refused(&bytes[..10], "too short");
    refused(&[], "too short");
    let mut short = vec![0; bytes.len() - 1];
    assert_eq!(library.serialize_into(host.handle, state, &mut short), ERROR);
    assert!(host.only_error().contains("too few"));

    let stale = state;
    assert_eq!(library.free_state(host.handle, Some(&mut state)), OK);
    assert_eq!(library.set_state(host.handle, stale), ERROR);
    assert_eq!(library.get_state(host.handle, Some(&mut stale.clone())), ERROR);
    assert_eq!(library.free_state(host.handle, Some(&mut stale.clone())), ERROR);
    assert_eq!(library.set_state(host.handle, Handle(0)), ERROR);
    assert_eq!(library.free_state(host.handle, Some(&mut Handle(0))), OK);
    assert_eq!(library.free_state(host.handle, None), OK);
    assert_eq!(host.fingerprint(), before, "nothing changed");
}
