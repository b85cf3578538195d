//! Stress and velocity along the bars, through the C functions.

use crate::support::host::{Host, vr};
use crate::support::library::{ERROR, Handle, Library, OK};
use dth_hammer::GUID;
use dth_hammer::variant::Variant;
use dth_hammer::waves::first;
use hammer::Parameters;
use hammer::families::ALONG;
use hammer::variables::VARIABLES;

const PISTON_STRESS: usize = 0;
const BIT_STRESS: usize = 1;
const PISTON_VELOCITY: usize = 2;
const BIT_VELOCITY: usize = 3;
const CASING_STRESS: usize = 4;

fn references(family: usize, count: usize) -> Vec<u32> {
    (0..count as u32).map(|index| first(family) + index).collect()
}

fn read(host: &Host, family: usize, count: usize) -> Vec<f64> {
    let mut values = vec![f64::NAN; count];
    let vr = references(family, count);
    let status = host.library.get_reals(host.handle, &vr, &mut values);
    assert_eq!(status, OK, "{:?}", host.take_log());
    values
}

/// A hammer on linear elements.
fn linear(library: &Library) -> Host<'_> {
    let host = Host::new(library);
    host.set_int("mesh.degree", 1);
    host.start(0.0);
    host
}

/// It stands some time after its first impact.
fn after_impact(library: &Library, delay: f64) -> Host<'_> {
    let scout = linear(library);
    let mut time = 0.0;
    while scout.get("blow_count") < 1.0 {
        assert!(time < 0.1, "no blow");
        scout.step(time, 1e-3);
        time += 1e-3;
    }
    let host = linear(library);
    host.step(0.0, scout.get("blow_time") + delay);
    host
}

#[test]
fn stresses_and_velocities_make_up_the_energies_and_momenta() {
    let library = Library::load();
    let p = Parameters::default();
    let (e, area) = (p.material.youngs_modulus, p.cross_section);
    let bars = [
        (PISTON_STRESS, PISTON_VELOCITY, p.piston.length, p.piston.elements, "piston_velocity"),
        (BIT_STRESS, BIT_VELOCITY, p.bit.length, p.bit.elements, "bit_velocity"),
    ];
    // Compression, release, and the bit's own waves after the collision.
    for delay in [5e-6, 2e-5, 5e-5, 2e-4] {
        let host = after_impact(&library, delay);
        let (mut strain, mut strain_error) = (0.0, 0.0);
        let (mut kinetic, mut fastest) = (0.0, 0.0_f64);
        for (stress, velocity, length, elements, mean) in bars {
            let (n, h) = (elements as f64, length / elements as f64);
            let sigma = read(&host, stress, elements);
            let v = read(&host, velocity, elements + 1);
            let line_mass = p.material.density * area * h;
            let mut momentum = 0.0;
            // A nodal displacement of up to 0.1 m is a sum over n + 1 modes, rounded at each.
            let rounding = e * 2.0 * (n + 1.0) * f64::EPSILON * 0.1 / h;
            for (sigma, v) in sigma.iter().zip(v.windows(2)) {
                let elastic = sigma - e * p.material.damping_time * (v[1] - v[0]) / h;
                strain += area * h * elastic * elastic / (2.0 * e);
                strain_error += area * h * (elastic.abs() + rounding) * rounding / e;
                momentum += line_mass * (v[0] + v[1]) / 2.0;
                kinetic += line_mass * (v[0] * v[0] + v[0] * v[1] + v[1] * v[1]) / 6.0;
            }
            let speed = v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            fastest = fastest.max(speed);
            let mass = line_mass * n;
            let bound = 2.0 * (n + 1.0) * f64::EPSILON * mass * speed;
            assert!((momentum - mass * host.get(mean)).abs() < bound, "{mean} after {delay}");
        }
        let found = host.get("energy_strain");
        assert!((strain - found).abs() < strain_error, "{strain} {found} after {delay}");
        assert!(strain > 1.0, "{strain} J show nothing");
        // Each velocity is rounded n + 1 times, and enters twice.
        let mass = p.material.density * area * (p.piston.length + p.bit.length);
        let terms = (p.piston.elements + 1) as f64;
        let bound = 4.0 * terms * f64::EPSILON * mass * fastest * fastest;
        assert!((kinetic - host.get("energy_kinetic")).abs() < bound, "after {delay}");
    }
}

#[test]
fn values_follow_steps_and_restored_states() {
    let library = Library::load();
    let host = after_impact(&library, 1e-5);
    let elements = Parameters::default().bit.elements;
    let here = read(&host, BIT_STRESS, elements);
    let mut state = Handle(0);
    assert_eq!(library.get_state(host.handle, Some(&mut state)), OK);
    let time = library.real_status(host.handle, 2).1;
    host.step(time, 1e-5);
    assert_ne!(read(&host, BIT_STRESS, elements), here);
    assert_eq!(library.set_state(host.handle, state), OK);
    assert_eq!(read(&host, BIT_STRESS, elements), here);
    assert_eq!(library.free_state(host.handle, Some(&mut state)), OK);
    host.plain("fmi2Reset");
    assert_ne!(read(&host, BIT_STRESS, elements), here);
}

#[test]
fn before_initialization_they_follow_what_is_set() {
    let library = Library::load();
    let host = Host::new(&library);
    let resting = read(&host, BIT_STRESS, 1)[0];
    // The first element carries the feed, and its own weight or less.
    let p = Parameters::default();
    let weight = p.bit_mass() * p.gravity;
    let expected = |feed: f64| {
        let low = -(feed + weight) / p.cross_section;
        low..=-feed / p.cross_section
    };
    assert!(expected(host.get("feed_force")).contains(&resting), "{resting}");
    host.set("feed_force", 2e4);
    let pressed = read(&host, BIT_STRESS, 1)[0];
    assert!(expected(2e4).contains(&pressed), "{pressed}");
    host.set_int("bit.elements", 3);
    assert!(expected(2e4).contains(&read(&host, BIT_STRESS, 3)[0]));
    let mut value = [f64::NAN];
    assert_eq!(library.get_reals(host.handle, &[first(BIT_STRESS) + 3], &mut value), ERROR);
}

#[test]
fn what_the_mesh_does_not_have_is_an_error_by_name() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    let mut value = [f64::NAN];
    let refused = |host: &Host, reference: u32, value: &mut [f64]| {
        assert_eq!(library.get_reals(host.handle, &[reference], value), ERROR);
        host.only_error()
    };
    let (p, b) = (Parameters::default().piston.elements, Parameters::default().bit.elements);
    let said = refused(&host, first(PISTON_STRESS) + p as u32, &mut value);
    assert_eq!(said, format!("there is no piston_stress[{}]: piston.elements = {p}", p + 1));
    let said = refused(&host, first(BIT_VELOCITY) + b as u32 + 1, &mut value);
    assert_eq!(said, format!("there is no bit_node_velocity[{}]: bit.elements = {b}", b + 2));
    let beyond = first(ALONG.len());
    let said = refused(&host, beyond, &mut value);
    assert_eq!(said, format!("value reference {beyond} is not that of a real variable"));
    assert!(value[0].is_nan());
    assert_eq!(library.set_reals(host.handle, &[first(PISTON_STRESS)], &[0.0]), ERROR);
    assert_eq!(host.only_error(), "piston_stress cannot be set: it is a result");

    let rigid = Host::new(&library);
    rigid.set_int("fidelity", 1);
    rigid.start(0.0);
    rigid.step(0.0, 0.01);
    assert_eq!(read(&rigid, PISTON_VELOCITY, 1)[0], rigid.get("piston_velocity"));
    let said = refused(&rigid, first(BIT_STRESS), &mut value);
    assert_eq!(said, "there is no bit_stress[1]: fidelity is Rigid");
    let said = refused(&host, first(CASING_STRESS), &mut value);
    assert_eq!(said, "there is no casing_stress[1]: casing.segments = 0");
}

/// A host that knows only a variant's GUID has its mesh, and sets nothing.
#[test]
fn a_variant_starts_with_the_mesh_of_its_guid() {
    let library = Library::load();
    let guid = format!("{GUID}{}", Variant::mesh_suffix(&[400, 7]));
    let handle = library.instantiate(Some("waves"), 1, Some(&guid), None, None, false);
    assert_ne!(handle.0, 0);
    for _ in 0..2 {
        assert_eq!(library.set_up(handle, 0.0, None), OK);
        assert_eq!(library.plain("fmi2EnterInitializationMode", handle), OK);
        assert_eq!(library.plain("fmi2ExitInitializationMode", handle), OK);
        let mut counts = [0, 0];
        let names = ["piston.elements", "bit.elements"].map(vr);
        assert_eq!(library.get_ints(false, handle, &names, &mut counts), OK);
        assert_eq!(counts, [400, 7]);
        // All that the description lists, in one call.
        let mut all: Vec<u32> = (0..VARIABLES.len() as u32)
            .filter(|row| {
                matches!(VARIABLES[*row as usize].role, hammer::variables::Role::Output(_))
            })
            .collect();
        all.extend([400, 7, 401, 8].into_iter().enumerate().flat_map(|(f, n)| references(f, n)));
        let mut values = vec![f64::NAN; all.len()];
        assert_eq!(library.get_reals(handle, &all, &mut values), OK);
        assert!(values.iter().all(|value| value.is_finite()));
        assert_eq!(library.plain("fmi2Reset", handle), OK);
    }
    library.free(handle);
}

/// A variant refuses a number that is not its own, by name.
fn assert_refused(library: &Library, guid: &str, name: &str, value: i32) {
    let host = Host::of_guid(library, guid);
    host.set_int(name, value);
    assert_eq!(library.set_up(host.handle, 0.0, None), OK);
    host.plain("fmi2EnterInitializationMode");
    assert_eq!(library.plain("fmi2ExitInitializationMode", host.handle), ERROR);
    let said = host.only_error();
    assert!(said.starts_with(&format!("{name} = {value} is not allowed")), "{said}");
}

#[test]
fn a_variant_keeps_to_its_mesh() {
    let library = Library::load();
    let guid = format!("{GUID}{}", Variant::mesh_suffix(&[16, 16]));
    let wrong = [("piston.elements", 21), ("bit.elements", 19), ("fidelity", 1)];
    for (name, value) in wrong {
        assert_refused(&library, &guid, name, value);
    }
    // Nor does a state bring another.
    let (plain, variant) = (Host::new(&library), Host::of_guid(&library, &guid));
    plain.set_int("bit.elements", 19);
    plain.start(0.0);
    variant.start(0.0);
    let mut state = Handle(0);
    assert_eq!(library.get_state(plain.handle, Some(&mut state)), OK);
    assert_eq!(library.set_state(variant.handle, state), ERROR);
    let said = variant.only_error();
    assert!(said.starts_with("bit.elements = 19 is not allowed"), "{said}");
    assert_eq!(library.free_state(plain.handle, Some(&mut state)), OK);
    let wrong = format!("{GUID}{}", Variant::mesh_suffix(&[0, 20]));
    assert_eq!(library.instantiate(Some("waves"), 1, Some(&wrong), None, None, false).0, 0);
}

/// A variant with a casing has its mesh too, and its stresses are there for hosts that set nothing.
#[test]
fn a_variant_that_lists_a_casing_keeps_to_its_mesh_and_its_sections() {
    let library = Library::load();
    let set = |name, value: f64| format!("{}:{:016x}", vr(name), value.to_bits());
    let start = format!("{}{}", dth_hammer::variant::SET, set("casing.segments", 1.0));
    let guid = format!("{GUID}{start}{}", Variant::mesh_suffix(&[20, 20, 3]));
    let host = Host::of_guid(&library, &guid);
    host.start(0.0);
    // The casing carries feed and weight less the drive's reaction, here a pull at its lower end.
    let p = Parameters::default();
    let (area, load) = (p.casing.segment[0].area, host.get("feed_force"));
    let mass = p.material.density * area * p.casing.segment[0].length;
    let spread = mass * p.gravity - p.drive.amplitude;
    for (k, stress) in read(&host, CASING_STRESS, 3).into_iter().enumerate() {
        let carried = -(load + spread * (k as f64 + 0.5) / 3.0) / area;
        // A strain of displacements of 1e-5 m, rounded some ten times.
        assert!((stress - carried).abs() < 1e-8 * carried.abs(), "{k}: {stress} {carried}");
    }
    let wrong = [("casing.elements", 4), ("casing.segments", 0)];
    for (name, value) in wrong {
        assert_refused(&library, &guid, name, value);
    }
}
