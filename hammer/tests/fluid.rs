//! A stiff fluid that drives the piston from outside: `drive.stiffness`.

use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Source};

const STIFFNESS: f64 = 7.5e7;

/// The reference hammer under a force from outside, on a fluid of this stiffness.
fn driven(stiffness: f64) -> Parameters {
    let mut p = Parameters::default();
    (p.drive.source, p.drive.stiffness) = (Source::Force, stiffness);
    p
}

fn mass(p: &Parameters) -> f64 {
    p.material.density * p.cross_section * p.piston.length
}

fn applied(machine: &Machine) -> f64 {
    machine.kinematics().applied_drive_force
}

/// A piston in flight on the fluid alone is an oscillator about where its force is zero; from where the
/// force is set again it is another.
#[test]
fn in_flight_the_piston_swings_about_where_the_force_is_zero() {
    let mut p = driven(STIFFNESS);
    (p.gravity, p.material.damping_time, p.contact.initial_gap) = (0.0, 0.0, 10.0);
    let force = 2e4;
    let inputs = InputValues { drive_force: force, ..InputValues::default() };
    let mut machine = Machine::new(&p, &inputs, 0.0).unwrap();
    let omega = (STIFFNESS / mass(&p)).sqrt();
    let amplitude = force / STIFFNESS;
    let close = |found: f64, expected: f64, size: f64| {
        // Some hundred roundings of the place, which is 10 m from the bit; of works, these times forces.
        assert!((found - expected).abs() <= 1e-12 * size, "{found} {expected}");
    };
    for t in [3e-5, 1e-4, 1e-3, 2e-3] {
        machine.advance(t).unwrap();
        let (sine, cosine) = (omega * t).sin_cos();
        close(machine.kinematics().piston_position, amplitude * (1.0 - cosine), 10.0);
        close(machine.kinematics().piston_velocity, amplitude * omega * sine, 10.0 * omega);
        close(applied(&machine), force * cosine, 10.0 * STIFFNESS);
        close(
            machine.kinematics().applied_drive_force_rates[0],
            -force * omega * sine,
            1e9 * omega,
        );
        let work = machine.energies();
        close(work.drive, work.kinetic, 1e3);
    }
    let [place, speed] =
        [machine.kinematics().piston_position, machine.kinematics().piston_velocity];
    machine.set_input(Input::DriveForce, &[-5e3]).unwrap();
    close(applied(&machine), -5e3, 10.0 * STIFFNESS);
    machine.advance(2e-3 + 7e-5).unwrap();
    let (sine, cosine) = (omega * 7e-5).sin_cos();
    let off = -5e3 / STIFFNESS;
    let expected = place + off * (1.0 - cosine) + speed / omega * sine;
    close(machine.kinematics().piston_position, expected, 10.0);
    let work = machine.energies();
    close(work.drive, work.kinetic, 1e3);
    // The same value again is set again.
    let now = applied(&machine);
    assert!((now + 5e3).abs() > 100.0);
    machine.set_input(Input::DriveForce, &[-5e3]).unwrap();
    close(applied(&machine), -5e3, 10.0 * STIFFNESS);
}

/// What a partner in a loop over its own steps would do with the same spring: `steps` in a run, each with
/// the force held that the spring has at its start.
fn by_hand(p: &Parameters, force: f64, end: f64, steps: u32) -> [f64; 3] {
    let loose = driven(0.0);
    let p = Parameters { drive: loose.drive, ..*p };
    let inputs = InputValues { drive_force: force, ..InputValues::default() };
    let mut machine = Machine::new(&p, &inputs, 0.0).unwrap();
    let start = machine.kinematics().piston_position;
    for step in 1..=steps {
        let x = machine.kinematics().piston_position - start;
        let v = machine.kinematics().piston_velocity;
        let h = end / f64::from(steps);
        // The force at the middle of the step, to second order.
        let middle = force - STIFFNESS * (x + 0.5 * h * v);
        machine.set_input(Input::DriveForce, &[middle, -STIFFNESS * v]).unwrap();
        machine.advance(f64::from(step) * h).unwrap();
    }
    read(&machine)
}

fn read(machine: &Machine) -> [f64; 3] {
    let now = machine.kinematics();
    [now.piston_position, now.bit_tip_position, now.piston_velocity]
}

/// Through a blow and the rock's modes, an elastic piston on the fluid moves as one whose force is set to
/// the spring's in ever smaller steps; the energies balance, and slicing changes no bit.
#[test]
fn through_a_blow_the_force_is_the_springs() {
    let mut p = driven(STIFFNESS);
    p.contact.initial_gap = 2e-4;
    let (force, end) = (3e4, 6e-4);
    let inputs = InputValues { drive_force: force, ..InputValues::default() };
    let run = |slices: u32| {
        let mut machine = Machine::new(&p, &inputs, 0.0).unwrap();
        for slice in 1..=slices {
            machine.advance(end * f64::from(slice) / f64::from(slices)).unwrap();
        }
        machine
    };
    let machine = run(1);
    let own = read(&machine);
    assert_eq!(own, read(&run(7)));
    assert!(machine.counters().contacts >= 1 && machine.counters().events > 5);
    let energies = machine.energies();
    assert!(energies.residual.abs() <= energies.residual_bound(), "{energies:?}");
    let [coarse, fine] = [2000, 4000].map(|steps| by_hand(&p, force, end, steps));
    for k in 0..3 {
        let [far, near] = [coarse, fine].map(|other| (other[k] - own[k]).abs());
        let size = own[k].abs();
        // Second order in flight and in contact, first order over the steps in which an event falls: at
        // least halved, and small.
        assert!(near <= 0.6 * far + 1e-9 * size, "{k}: {far:e} {near:e} of {size:e}");
        assert!(near <= 5e-4 * size, "{k}: {far:e} {near:e} of {size:e}");
    }
}

/// An oil chamber outside: its volume shrinks as the piston moves back, and its pressure is set at each
/// step. Exchanged so, it blows up; with the piston informed of its stiffness, the motion is that of the spring.
#[test]
fn an_oil_chamber_that_is_told_of_stays_calm() {
    let (modulus, volume, area) = (1.5e9, 2e-5, 1e-3);
    let own = modulus * area * area / volume;
    let mut p = driven(0.0);
    p.fidelity = Fidelity::Rigid;
    (p.gravity, p.contact.initial_gap) = (0.0, 0.05);
    (p.drive.source, p.drive.area_drive, p.drive.area_return) = (Source::Pressure, area, 0.0);
    p.piston.initial_velocity = 1.0;
    let (mass, end) = (mass(&p), 0.02);
    let amplitude = (mass / own).sqrt();
    let largest = |stiffness: f64, step: f64| {
        let mut p = p;
        p.drive.stiffness = stiffness;
        let mut machine = Machine::new(&p, &InputValues::default(), 0.0).unwrap();
        let mut largest = 0.0f64;
        for k in 1..=(end / step).round() as u32 {
            let swept = area * machine.swept();
            machine.set_input(Input::DrivePressure, &[-modulus * swept / volume]).unwrap();
            machine.advance(f64::from(k) * step).unwrap();
            largest = largest.max(machine.swept().abs());
        }
        largest / amplitude
    };
    // A step multiplies the swing by 1 + (omega h)^2 / 4, 400 times.
    let grown = (1.0 + own / mass * 5e-5f64.powi(2) / 4.0).powi(400);
    let untold = largest(0.0, 5e-5);
    assert!(grown > 100.0 && (untold / grown - 1.0).abs() < 0.1, "{untold} {grown}");
    let informed = largest(own, 5e-5);
    assert!((informed - 1.0).abs() < 0.05, "{informed}");
    // An estimate above the truth damps the swing; of one below, what is missing makes it grow.
    let over = largest(2.0 * own, 5e-5);
    assert!(over < 1.05, "{over}");
    let under = largest(0.5 * own, 5e-5);
    assert!((under / grown.sqrt() - 1.0).abs() < 0.1, "{under}");
    let informed = largest(own, 2e-5);
    assert!((informed - 1.0).abs() < 0.003, "{informed}");
}

/// A piston that a fluid holds starts as far from the bit, which a feed shortens, as one in flight.
#[test]
fn a_piston_starts_at_the_same_place_on_a_fluid_and_in_flight() {
    for fidelity in Fidelity::ALL {
        let gap = |stiffness| {
            let mut p = driven(stiffness);
            (p.fidelity, p.contact.initial_gap) = (fidelity, 1e-4);
            let inputs = InputValues { feed_force: 5e4, ..InputValues::default() };
            Machine::new(&p, &inputs, 0.0).unwrap().kinematics().contact_gap
        };
        // Some roundings of places below a millimetre; the feed shortens the bit by 4e-6 m.
        assert!((gap(STIFFNESS) - gap(0.0)).abs() < 1e-17, "{fidelity:?}");
        assert!(gap(0.0) > 1.03e-4, "{fidelity:?}");
    }
}
