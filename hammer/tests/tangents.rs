//! Tangents against central differences, where both sides see the same events.

mod scenes;

use hammer::tangent::{Parameter, Seed};
use hammer::{Fidelity, InputValues, Parameters};
use scenes::Draw;
use scenes::differences::{compare, tangents};

#[test]
fn every_parameter_of_unequal_bodies_has_the_derivative_that_differences_tend_to() {
    let mut worst = 0.0;
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic] {
        let mut p = Parameters { fidelity, ..Default::default() };
        (p.piston.elements, p.bit.elements) = (8, 5);
        p.bit.length = 0.21;
        p.piston.initial_velocity = 1.0;
        for t in [1e-3, 0.0405, 0.06, 0.1] {
            let compared = compare(&p, t, &mut worst);
            assert!(compared >= 18, "{fidelity:?} {t}: {compared}");
        }
    }
}

#[test]
fn drawn_scenes_have_the_derivatives_that_differences_tend_to() {
    let (mut draw, mut compared, mut worst) = (Draw::new(5), 0, 0.0);
    for _ in 0..10 {
        let p = draw.scene();
        compared += compare(&p, draw.between(0.005, 0.05), &mut worst);
    }
    assert!(compared > 100, "{compared}");
}

/// The piston falls freely: `g = v0 t + a t^2 / 2` with `a = F0 / Mp + G`, onto a bit that stands
/// where its loads press it, `g = g0 + (FS + Mb G) / (gamma KR)`.
///
/// The instant is found to 1e-13 of the travel's time, and its derivatives with it; a thousand
/// times that is granted.
#[test]
fn the_first_blow_of_rigid_bodies_has_the_derivatives_of_its_closed_form() {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    (p.piston.initial_velocity, p.bit.length) = (0.7, 0.23);
    let feed = InputValues::default().feed_force;
    let (v0, f0) = (p.piston.initial_velocity, p.drive.amplitude);
    let (mass, a) = (p.piston_mass(), p.drive.amplitude / p.piston_mass() + p.gravity);
    let held = p.rock.unloading_ratio * p.rock.stiffness;
    let (weight, press) = (p.bit_mass() * p.gravity, feed + p.bit_mass() * p.gravity);
    let gap = p.contact.initial_gap + press / held;
    let speed = (v0 * v0 + 2.0 * a * gap).sqrt();
    let time = (speed - v0) / a;
    // Of speed and time by gap, push and first velocity.
    let by = |gap_change: f64, push: f64| {
        let of_speed = (a * gap_change + gap * push) / speed;
        [of_speed, of_speed / a - time / a * push]
    };
    let lighter = -f0 / mass;
    let of = |value: f64| by(weight / held / value, lighter / value);
    let expected = [
        (Parameter::InitialGap, by(1.0, 0.0)),
        (Parameter::PistonVelocity, [v0 / speed, (v0 / speed - 1.0) / a]),
        (Parameter::DriveAmplitude, by(0.0, 1.0 / mass)),
        (Parameter::Gravity, by(p.bit_mass() / held, 1.0)),
        (Parameter::Density, of(p.material.density)),
        (Parameter::CrossSection, of(p.cross_section)),
        (Parameter::PistonLength, by(0.0, lighter / p.piston.length)),
        (Parameter::BitLength, by(weight / held / p.bit.length, 0.0)),
        (Parameter::RockStiffness, by(-press / held / p.rock.stiffness, 0.0)),
        (Parameter::UnloadingRatio, by(-press / held / p.rock.unloading_ratio, 0.0)),
        (Parameter::RockViscosity, [0.0; 2]),
    ];
    let seeds: Vec<_> = expected.iter().map(|(q, _)| Seed::Parameter(*q)).collect();
    let (_, found) = tangents(&p, &seeds, 1.01 * time).expect("a run");
    for ((parameter, [of_speed, of_time]), d) in expected.iter().zip(&found) {
        let own = *parameter.slot(&mut p.clone());
        for (ours, exact, size) in [(d.blow.speed, of_speed, speed), (d.blow.time, of_time, time)] {
            let off = (ours - exact).abs() * own;
            assert!(off < 1e-10 * size, "{}: {ours:e} {exact:e}", parameter.name());
        }
    }
}
