//! Tests of the oracles: exact waves against another program's, elwaspatid 2.0.1 (`data/*.py`), and the reference in
//! extended precision against closed forms.

use oracles::crossing::{Outcome, Zero, scan};
use oracles::dd::Dd;
use oracles::linear::Real;
use oracles::run::Run;
use oracles::scene::{Action, Body, Coupling, Drive, Fidelity, Input, RockLaw, Section};
use oracles::taylor::Accuracy;
use oracles::waves::line::{Line, Spread};
use oracles::waves::{self, Waves};
use serde::Deserialize;

const MODULUS: f64 = 210e9;
const DENSITY: f64 = 7850.0;
/// Waves that are constant between fronts have no error but rounding: of a front's instant, 1e-10 of the piston's
/// transit, and of a force that is computed from the motion of the faces.
const ROUNDING: f64 = 1e-9;

/// Length and area.
type Part = [f64; 2];

/// A piston strikes a bit at rest at 10 m/s.
fn struck(piston: &[Part], bit: &[Part], rock: f64) -> waves::Scene {
    let section = |&[length, area]: &Part| waves::Section {
        impedance: area * (MODULUS * DENSITY).sqrt(),
        transit: length / (MODULUS / DENSITY).sqrt(),
    };
    let bodies = [piston, bit].map(|parts| parts.iter().map(section).collect());
    waves::Scene { bodies, speed: [10.0, 0.0], ..waves::Scene::unit(rock, 1.0, 1.0) }
}

/// Force in a section, at a fraction of its length below its top.
fn force(of: &Waves, scene: &waves::Scene, [body, section]: [usize; 2], part: f64) -> f64 {
    let [down, up] = of.inside(body, section, part);
    scene.bodies[body][section].impedance * (down - up)
}

#[derive(Deserialize)]
struct Stepped {
    plateaus: Vec<Plateau>,
    impulse: f64,
}

#[derive(Deserialize)]
struct Plateau {
    from: f64,
    to: f64,
    force: f64,
}

#[test]
fn a_stepped_piston_presses_a_stepped_bit_as_the_other_program_says() {
    let other: Stepped =
        serde_json::from_str(include_str!("../data/stepped_impact.json")).expect("JSON");
    let part = |(length, width): (f64, f64)| [length, std::f64::consts::FRAC_PI_4 * width * width];
    let piston = [(0.20, 0.060), (0.15, 0.045)].map(part);
    let scene = struck(&piston, &[(0.15, 0.050), (0.10, 0.080)].map(part), 0.0);
    let mut waves = Waves::new(scene.clone(), 7);
    for Plateau { from, to, force: known } in &other.plateaus {
        waves.advance(0.5 * (from + to));
        let pressed = force(&waves, &scene, [0, 1], 1.0);
        assert!((pressed - known).abs() < ROUNDING * known, "{pressed} {known}");
    }
    let end = other.plateaus.last().expect("some").to;
    waves.advance(2.0 * end);
    let first = waves.collisions[0];
    assert!((first.push - end).abs() < ROUNDING * end, "{} {end}", first.push);
    assert!((first.impulse / other.impulse - 1.0).abs() < ROUNDING, "{}", first.impulse);
}

#[derive(Deserialize)]
struct Solved {
    rods: usize,
    piston: Part,
    shank: Part,
    rod: Part,
    coupling: Part,
    bit: Part,
    felt: Vec<Felt>,
}

#[derive(Deserialize)]
struct Felt {
    rod: usize,
    time: f64,
    force: f64,
}

/// A string on rigid rock. The indentation is `F/KR`; the force follows within `Z/KR`, 1e-5 of a step.
#[test]
fn a_blow_goes_down_drawn_strings_as_the_other_program_says() {
    let strings: Vec<Solved> =
        serde_json::from_str(include_str!("../data/strings.json")).expect("JSON");
    for Solved { rods, piston, shank, rod, coupling, bit, mut felt } in strings {
        // A sleeve covers half its length of either neighbour.
        let shorter = |[length, area]: Part, by: f64| [length - by * coupling[0], area];
        let mut string = vec![shorter(shank, 0.5)];
        for k in 1..=rods {
            string.extend([coupling, shorter(rod, if k == rods { 0.5 } else { 1.0 })]);
        }
        string.push(bit);
        let scene = struck(&[piston], &string, 1e15);
        // Cells of 10 mm.
        let mut waves = Waves::new(scene.clone(), (100.0 * piston[0]).round() as u32);
        felt.sort_by(|a, b| a.time.total_cmp(&b.time));
        for Felt { rod, time, force: known } in felt {
            waves.advance(time);
            let (section, part) = if rod == 0 { (string.len() - 1, 1.0) } else { (2 * rod, 0.5) };
            let pressed = force(&waves, &scene, [1, section], part);
            assert!((pressed - known).abs() < ROUNDING * 1e6, "{rods} {rod}: {pressed} {known}");
        }
    }
}

const ACCURACY: Accuracy = Accuracy { order: 36, tolerance: 1e-28 };

/// A small hammer of unequal, stepped bodies, undamped.
fn small() -> oracles::scene::Scene {
    let part = |length, area, elements| Section { length, area, elements };
    let body = |sections| Body { sections, velocity: 0.0 };
    oracles::scene::Scene {
        fidelity: Fidelity::Elastic,
        youngs_modulus: 2e11,
        density: 8000.0,
        damping_time: 0.0,
        bodies: vec![
            body(vec![part(0.1, 1e-3, 1), part(0.05, 2e-3, 1)]),
            body(vec![part(0.2, 2e-3, 2)]),
        ],
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
        impedance: 0.0,
        gravity: 10.0,
        inputs: [2000.0, 0.0, 0.0, 0.0],
        resolutions: [1e-14, 1e-9],
    }
}

/// A free body under a force of every order up to 4: its mean motion is the integral, to double precision.
#[test]
fn a_free_piston_follows_a_polynomial_force() {
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic, Fidelity::Spline(3)] {
        let free = oracles::scene::Scene { drive: Drive::Force, gravity: 0.0, gap: 1.0, ..small() };
        let mut scene = oracles::scene::Scene { fidelity, ..free };
        scene.bodies[0].velocity = 2.0;
        let mass = 8000.0 * (0.1 * 1e-3 + 0.05 * 2e-3);
        let derivatives = vec![100.0, -1e6, 3e10, 2e14, -5e18];
        let (begin, span) = (1e-5, 2e-4);
        let schedule = vec![(begin, Action::Set(Input::Force, derivatives.clone()))];
        let mut run = Run::<Dd>::new(&scene, ACCURACY);
        run.through(&[begin + span], &schedule).expect("a run");
        let state = &run.samples[0].state;
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
        for (found, exact) in [(mean(&state.v), speed), (mean(&state.u), place)] {
            assert!((found - exact).abs() < 1e-14 * exact.abs(), "{found} {exact}");
        }
    }
}

/// Without material damping, the balance must leave nothing for it. This checks the works, the stored energies, the
/// rock's losses and the energy of retuning, through every mode. The series of the works leave out 1e-23 of a sum at
/// a step, in some tens of steps.
#[test]
fn the_balance_leaves_nothing_to_an_undamped_material() {
    let mut scene = small();
    scene.bodies[0].velocity = 8.0;
    let tuned = RockLaw { stiffness: 4e7, ratio: 5.0, viscosity: 3e4, barrier: 0.2, ..scene.rock };
    let schedule = vec![
        (2e-5, Action::Set(Input::Feed, vec![3000.0, 1.5e7, -4.5e11])),
        (6e-5, Action::Retune(tuned, Some(1500.0))),
    ];
    let instants: Vec<f64> = (1..=20).map(|i| 2e-5 * f64::from(i)).collect();
    let mut run = Run::<Dd>::new(&scene, ACCURACY);
    run.through(&instants, &schedule).expect("a run");
    assert!(run.events.len() > 5, "{:?}", run.events);
    for sample in &run.samples {
        let e = &sample.energies;
        let play = e.stored[0].to_f64() + e.stored[1].to_f64() + e.rock.to_f64();
        assert!(e.damping.to_f64().abs() < 1e-21 * play.max(1.0), "{} {e:?}", sample.time);
    }
    assert!(run.samples[19].energies.retuned.to_f64() != 0.0);
}

fn poly(c: &[f64]) -> Vec<Dd> {
    c.iter().map(|&x| Dd::from(x)).collect()
}

#[test]
fn a_pair_between_two_samples_is_found() {
    // -(x - 0.5)^2 + 1e-8 is above zero for 2e-4 about 0.5.
    let c = poly(&[-0.25 + 1e-8, 1.0, -1.0]);
    let Outcome::Crossed(Zero::At(x)) = scan(&c, 1.3, 1e-9, false) else { panic!() };
    assert!((x.hi - (0.5 - 1e-4)).abs() < 1e-12);
    assert_eq!(scan(&c, 1.3, 2e-8, false), Outcome::Clear);
}

#[test]
fn a_low_excursion_stays_pending_and_keeps_its_zero() {
    let c = poly(&[-1e-12, 1e-12]);
    assert!(matches!(scan(&c, 2.0, 1e-9, false), Outcome::Pending(Zero::At(_))));
    // The pending guard is below zero again at the start, so this is a new zero.
    assert!(matches!(scan(&c, 2.0, 1e-9, true), Outcome::Pending(Zero::At(_))));
    let risen = poly(&[5e-10, 1e-9]);
    assert_eq!(scan(&risen, 1.0, 1e-9, true), Outcome::Crossed(Zero::Earlier));
}

#[test]
fn the_root_just_taken_and_left_downward_is_no_crossing() {
    assert_eq!(scan(&poly(&[1e-30, -1.0, 0.5]), 1.0, 1e-14, false), Outcome::Clear);
}

/// A pulse through a line of 200 cells of 0.01. Once a sampled Gaussian is wider than a cell, its variance is exact to
/// rounding; the part beyond 5.5 standard deviations weighs 3e-8.
#[test]
fn a_pulse_comes_a_transit_later_as_wide_as_damping_makes_it() {
    let mut line = Line::Spread(Spread::new(200, 0.01, 0.005, [0.0, 0.0]));
    let mut out = Vec::new();
    for k in 0..800 {
        let (start, end) = (0.01 * k as f64, 0.01 * (k + 1) as f64);
        out.push(0.5 * (line.after(start) + line.before(end)));
        let sent = if k == 300 { 1.0 } else { 0.0 };
        line.send(start, end, sent, sent);
    }
    let moment = |p: i32, about: f64| -> f64 {
        out.iter().enumerate().map(|(k, x)| x * (k as f64 - about).powi(p)).sum()
    };
    assert!((moment(0, 0.0) - 1.0).abs() < 1e-13);
    assert!((moment(1, 0.0) - 500.0).abs() < 1e-10);
    // beta T in cells squared: 0.005 * 2 / 0.01^2.
    assert!((moment(2, 500.0) - 100.0).abs() < 100.0 * 1e-6);
}
