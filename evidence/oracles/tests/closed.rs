//! The reference itself against closed forms: what it is trusted with, it must do.

use oracles::dd::Dd;
use oracles::law::{Event, Rock};
use oracles::linear::Real;
use oracles::run::Run;
use oracles::scene::{Action, Body, Coupling, Drive, Fidelity, Input, RockLaw, Scene, Section};
use oracles::taylor::Accuracy;

const ACCURACY: Accuracy = Accuracy { order: 36, tolerance: 1e-28 };

/// A small hammer of unequal, stepped bodies, undamped.
fn scene() -> Scene {
    let body = |parts: &[(f64, f64, usize)]| Body {
        sections: parts
            .iter()
            .map(|&(length, area, elements)| Section { length, area, elements })
            .collect(),
        velocity: 0.0,
    };
    Scene {
        fidelity: Fidelity::Elastic,
        youngs_modulus: 2e11,
        density: 8000.0,
        damping_time: 0.0,
        bodies: vec![body(&[(0.1, 1e-3, 1), (0.05, 2e-3, 1)]), body(&[(0.2, 2e-3, 2)])],
        coupling: Coupling::default(),
        contact_stiffness: 1e10,
        casing: None,
        anvil_area: 0.0,
        gap: 1e-4,
        rock: RockLaw {
            stiffness: 1e8,
            ratio: 3.0,
            viscosity: 1e4,
            barrier: 1.0,
            standstill_speed: 1e-3,
            standstill_penetration: 1e-6,
            reloads: false,
        },
        drive: Drive::Relay { amplitude: 1000.0, stroke: 0.05 },
        gravity: 10.0,
        inputs: [2000.0, 0.0, 0.0, 0.0],
        resolutions: [1e-14, 1e-9],
    }
}

/// A free body under a force of every order up to 4: its mean moves as the integral says, to
/// the digits of double-double arithmetic; and the work is force times way.
#[test]
fn a_free_piston_follows_a_polynomial_force() {
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic, Fidelity::Spectral(6), Fidelity::Spline(3)]
    {
        let mut scene = Scene { fidelity, drive: Drive::Force, gravity: 0.0, gap: 1.0, ..scene() };
        scene.bodies[0].velocity = 2.0;
        let mass = 8000.0 * (0.1 * 1e-3 + 0.05 * 2e-3);
        let derivatives = vec![100.0, -1e6, 3e10, 2e14, -5e18];
        let (begin, span) = (1e-5, 2e-4);
        let schedule = vec![(begin, Action::Set(Input::Force, derivatives.clone()))];
        let mut run = Run::<Dd>::new(&scene, ACCURACY);
        run.through(&[begin + span], &schedule).unwrap();
        let sample = &run.samples[0];
        let nodes = 0..run.model.bit;
        let mean = |x: &[Dd]| {
            nodes.clone().fold(Dd::default(), |sum, i| sum + run.model.relative[i] * x[i]).to_f64()
        };
        // `v + sum d_k t^(k+1) / (k+1)! / m`, and its integral.
        let (mut speed, mut place, mut term) = (2.0, 2.0 * (begin + span), span / mass);
        for (k, d) in derivatives.iter().enumerate() {
            speed += d * term;
            place += d * term * span / (k as f64 + 2.0);
            term *= span / (k as f64 + 2.0);
        }
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-14 * b.abs(), "{a} {b}");
        close(mean(&sample.state.v), speed);
        close(mean(&sample.state.u), place);
        if fidelity == Fidelity::Rigid {
            // All that the force did is motion: a sum of hundreds of joules.
            let gained = 0.5 * mass * (speed * speed - 4.0);
            let work = sample.energies.drive.to_f64();
            assert!((work - gained).abs() < 1e-12 * gained.abs(), "{work} {gained}");
        }
    }
}

/// Without material damping the balance must leave nothing for it: that holds the works, the
/// stored energies, the losses of the rock and what retuning puts in, through every mode.
#[test]
fn the_balance_leaves_nothing_to_an_undamped_material() {
    let tight = scene();
    let mut loose = tight.clone();
    loose.bodies.extend([loose.bodies[1].clone(), loose.bodies[1].clone()]);
    loose.coupling = Coupling { stiffness: 1e10, slack: 1e-5 };
    let [few, many] = [tight, loose].map(balanced);
    assert!(few == 0 && many > 3, "{few} {many}");
}

/// See above; how often joints met and parted.
fn balanced(mut scene: Scene) -> usize {
    scene.bodies[0].velocity = 8.0;
    let wave = |k: i32| 500.0 * 3e4f64.powi(k);
    let tuned = RockLaw { stiffness: 4e7, ratio: 5.0, viscosity: 3e4, barrier: 0.2, ..scene.rock };
    let schedule = vec![
        (2e-5, Action::Set(Input::Feed, vec![3000.0, wave(1), -wave(2), -wave(3), wave(4)])),
        (6e-5, Action::Retune(tuned, Some(1500.0))),
        (9e-5, Action::Set(Input::Feed, vec![-500.0, 1e7])),
    ];
    let instants: Vec<f64> = (1..=20).map(|i| 2e-5 * f64::from(i)).collect();
    let mut run = Run::<Dd>::new(&scene, ACCURACY);
    run.through(&instants, &schedule).unwrap();
    assert!(run.events.len() > 5, "{:?}", run.events);
    for sample in &run.samples {
        let e = &sample.energies;
        let play = e.stored[0].to_f64() + e.stored[1].to_f64() + e.rock.to_f64();
        // What series of works leave out, 1e-23 of a sum at a step, in some tens of steps.
        assert!(e.damping.to_f64().abs() < 1e-21 * play.max(1.0), "{} {e:?}", sample.time);
    }
    assert!(run.samples.last().unwrap().energies.retuned.to_f64() != 0.0);
    run.events.iter().filter(|e| matches!(e.event, Event::Joint(..))).count()
}

#[test]
fn no_barrier_is_passed_at_once() {
    let mut scene = scene();
    scene.rock.barrier = 0.0;
    scene.bodies[0].velocity = 8.0;
    let mut run = Run::<Dd>::new(&scene, ACCURACY);
    run.through(&[2e-4], &[]).unwrap();
    let entries = run.events.iter().zip(run.events.iter().skip(1));
    let mut entered = 0;
    for (from, to) in entries.filter(|(from, _)| from.mode.rock == Rock::DFC) {
        assert_eq!((to.event, to.time), (Event::Q3, from.time));
        entered += 1;
    }
    assert!(entered > 0, "{:?}", run.events);
    assert_eq!(run.samples[0].energies.viscous.to_f64(), 0.0);
}

/// A bit that its loads pull up starts in free flight, just touching, strained as in the
/// acceleration that follows: it falls away from the rock as one, without oscillation.
#[test]
fn a_lifted_bit_starts_in_free_flight() {
    let mut scene = Scene { gap: 1.0, ..scene() };
    scene.inputs[Input::Feed as usize] = -300.0;
    let mut run = Run::<Dd>::new(&scene, ACCURACY);
    let start = run.model.start().0;
    run.through(&[1e-3], &[]).unwrap();
    let (model, state) = (&run.model, &run.samples[0].state);
    assert_eq!(run.samples[0].mode.rock, Rock::FF);
    let way = 0.5 * (10.0 - 300.0 / (8000.0 * 0.2 * 2e-3)) * 1e-6;
    for i in model.bit..model.nodes() {
        let moved = (state.u[i] - start.u[i]).to_f64();
        assert!((moved - way).abs() < 1e-14 * way.abs(), "{moved} {way}");
    }
    // Pulled at its upper face: longer by half of what the force would do to a held bar.
    let stretch = (start.u[model.nodes() - 1] - start.u[model.bit]).to_f64();
    let exact = 0.5 * 300.0 * 0.2 / (2e11 * 2e-3);
    assert!((stretch - exact).abs() < 1e-14 * exact, "{stretch} {exact}");
}
