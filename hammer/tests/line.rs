//! A transmission line at the piston (`drive.impedance`): closed forms, slices and states to the bit, the energy
//! balance, and refusals. `cargo compare --kind line` compares drawn hammers with the reference.

use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Scene, Source};

const FORCE: f64 = 900.0;
const IMPEDANCE: f64 = 300.0;
/// Each window changes a speed by less than a tenth of the guards' resolution, which for these hammers, with a travel
/// of 10 m at their waves' frequency, is 2e-7 m/s.
const SPEED: f64 = 2e-7;

/// Piston and casing, pushed apart by an outside force; or a piston that it lifts, whose line pulls the bit along.
fn floating(casing: f64, fidelity: Fidelity) -> Scene {
    let mut scene = Scene::default();
    let p = &mut scene.parameters;
    (p.fidelity, p.gravity, p.casing.mass) = (fidelity, 0.0, casing);
    (p.drive.source, p.drive.impedance, p.contact.initial_gap) = (Source::Force, IMPEDANCE, 10.0);
    p.chuck.travel = 20.0;
    (scene.inputs.feed_force, scene.inputs.drive_force) = (0.0, force(casing));
    scene
}

fn force(casing: f64) -> f64 {
    if casing > 0.0 { FORCE } else { -FORCE }
}

/// `mu v' = F mu / Mp - Z v`, with the reduced mass `mu` of the two masses at the line's ends. The drive pushes
/// against a casing; without one, against an outside holder.
fn speed(p: &Parameters, time: f64) -> f64 {
    let other = if p.casing.mass > 0.0 { p.casing.mass } else { p.bit_mass() };
    let reduced = 1.0 / (1.0 / p.piston_mass() + 1.0 / other);
    let force = if p.casing.mass > 0.0 { FORCE } else { -FORCE * reduced / p.piston_mass() };
    let z = p.drive.impedance;
    force / z * -(-z * time / reduced).exp_m1()
}

#[test]
fn the_speed_nears_that_at_which_the_line_carries_the_force() {
    for (casing, fidelity) in
        [(0.0, Fidelity::Rigid), (20.0, Fidelity::Rigid), (0.0, Fidelity::Elastic)]
    {
        let scene = floating(casing, fidelity);
        let mut machine = scene.machine().unwrap();
        for time in [1e-3, 7e-3, 0.05, 0.5] {
            machine.advance(time).unwrap();
            let (found, exact) = (machine.kinematics(), speed(&scene.parameters, time));
            let off = (found.relative.velocity - exact).abs();
            assert!(off < SPEED, "{casing} {fidelity:?} {time}: {off:e}");
            let off = found.applied_drive_force - (force(casing) - IMPEDANCE * exact);
            assert!(off.abs() < IMPEDANCE * SPEED, "{casing} {fidelity:?} {time}: {off:e}");
        }
    }
}

/// Hammers with every drive that may have a line: bare, in a casing that is lifted so that its relay is vented, and
/// on loose rods.
fn hammers() -> Vec<Scene> {
    let scene = |source: Source, change: fn(&mut Parameters)| {
        let mut scene = Scene::default();
        let p = &mut scene.parameters;
        (p.fidelity, p.drive.source, p.drive.impedance) = (Fidelity::Rigid, source, 60.0);
        (p.contact.initial_gap, p.piston.initial_velocity) = (4e-3, 5.0);
        change(p);
        scene.inputs.drive_force = 1500.0;
        (scene.inputs.drive_pressure, scene.inputs.return_pressure) = (3e6, 1e5);
        scene
    };
    let cased = |p: &mut Parameters| {
        (p.casing.mass, p.chuck.idle_travel, p.drive.stroke) = (12.0, 1e-3, 0.01);
    };
    let elastic = |p: &mut Parameters| {
        (p.fidelity, p.piston.elements, p.bit.elements) = (Fidelity::Elastic, 3, 3);
    };
    let loose = |p: &mut Parameters| {
        (p.fidelity, p.piston.elements, p.bit.elements) = (Fidelity::Elastic, 3, 12);
        (p.drill.rods, p.drill.joint.stiffness, p.drill.joint.slack) = (1, 1e9, 1e-3);
        p.drill.rod.length = 0.5;
    };
    vec![
        scene(Source::Relay, cased),
        scene(Source::Force, elastic),
        scene(Source::Pressure, |_| ()),
        scene(Source::Force, loose),
    ]
}

/// A host that sets inputs, retunes, and reads at any time.
fn run(machine: &mut Machine, points: &[f64]) -> String {
    for point in points {
        machine.advance(*point).unwrap();
        if *point == 0.004 {
            machine.set_input(Input::DriveForce, &[1200.0, 1e4]).unwrap();
            machine.set_input(Input::DrivePressure, &[2.5e6]).unwrap();
            let mut tuned = *machine.parameters();
            tuned.rock.stiffness *= 1.25;
            machine.retune(&tuned).unwrap();
        }
    }
    format!("{:?} {:?}", machine.kinematics(), machine.energies())
}

#[test]
fn slices_and_states_change_no_bit_and_the_energies_balance() {
    let few = [0.004, 0.02];
    let mut many: Vec<f64> = (1..100).map(|k| f64::from(k) * 1.9e-4).chain(few).collect();
    many.sort_by(f64::total_cmp);
    for scene in hammers() {
        let (mut one, mut other) = (scene.machine().unwrap(), scene.machine().unwrap());
        let expected = run(&mut one, &few);
        assert_eq!(run(&mut other, &many), expected);
        assert!(one.counters().blows > 0, "{:?}", one.counters());
        // In the middle of a window.
        let (mut from, mut into) = (scene.machine().unwrap(), scene.machine().unwrap());
        from.advance(0.0033).unwrap();
        into.advance(0.0071).unwrap();
        into.restore(&from.state()).unwrap();
        assert_eq!(run(&mut into, &few), expected);
        let energies = one.energies();
        // Some hundred windows, each with some hundred roundings of the sum of all energies.
        assert!(energies.residual.abs() < 1e-11 * energies.turnover(), "{energies:?}");
    }
}

#[test]
fn air_has_no_line_beside_it_and_none_is_faster_than_waves() {
    for (source, value, why) in
        [(Source::Air, 50.0, "air.drag"), (Source::Force, 1e6, "a wave passes the piston")]
    {
        let mut p = Parameters::default();
        (p.drive.source, p.drive.impedance) = (source, value);
        let made = Machine::new(&p, &InputValues::default(), 0.0);
        let error = made.map(|_| ()).unwrap_err().to_string();
        let begin = format!("drive.impedance = {value} is not allowed");
        assert!(error.contains(&begin) && error.contains(why), "{error}");
    }
}
