//! Exact waves in stepped bars against another program's, elwaspatid 2.0.1 (`data/*.py`).
//!
//! Waves that are constant between fronts are carried without error, but for rounding: of a front's
//! instant, 1e-10 of the piston's transit, which moves an impulse by as much of itself; of a force, that
//! of its contact over a step, which is read from the faces' way, known to as much.

use oracles::waves::{Rock, Scene, Section, Waves};
use serde::Deserialize;

const MODULUS: f64 = 210e9;
const DENSITY: f64 = 7850.0;
const SPEED: f64 = 10.0;
const ROUNDING: f64 = 1e-9;

/// Length and area.
type Part = [f64; 2];

/// A piston that strikes a bit at rest.
fn scene(piston: &[Part], bit: &[Part], rock: f64) -> Scene {
    let speed = (MODULUS / DENSITY).sqrt();
    let section = |&[length, area]: &Part| Section {
        impedance: area * (MODULUS * DENSITY).sqrt(),
        transit: length / speed,
    };
    let bodies = [piston, bit].map(|parts| parts.iter().map(section).collect());
    Scene { bodies, speed: [SPEED, 0.0], ..Scene::unit(rock, 1.0, 1.0) }
}

/// Force in a section, a part of its length below its top.
fn force(waves: &Waves, scene: &Scene, [body, section]: [usize; 2], part: f64) -> f64 {
    let [down, up] = waves.inside(body, section, part);
    scene.bodies[body][section].impedance * (down - up)
}

/// Each section carries the feed and the weights above it, and nothing moves.
#[test]
fn a_stepped_bit_rests_on_the_rock_under_its_weight_and_the_feed() {
    let bit = [[0.15, 2e-3], [0.05, 5e-3], [0.10, 3e-3]];
    let (gravity, feed) = (10.0, 5e3);
    let scene = Scene { gravity, feed, gap: 1e6, ..scene(&[[0.2, 1e-3]], &bit, 1e8) };
    let mut waves = Waves::new(scene.clone(), 10);
    waves.advance(1e-3);
    assert_eq!(waves.rock(), Rock::Still);
    assert!(waves.means[1].velocity.abs() < ROUNDING * SPEED, "{}", waves.means[1].velocity);
    let mut carried = feed;
    for (section, [length, area]) in bit.into_iter().enumerate() {
        let weight = DENSITY * area * length * gravity;
        let middle = force(&waves, &scene, [1, section], 0.5);
        carried += weight;
        assert!((middle - carried + 0.5 * weight).abs() < ROUNDING * feed, "{middle} {carried}");
    }
}

#[derive(Deserialize)]
struct Plateau {
    from: f64,
    to: f64,
    force: f64,
}

#[derive(Deserialize)]
struct Stepped {
    plateaus: Vec<Plateau>,
    impulse: f64,
}

#[test]
fn a_stepped_piston_presses_a_stepped_bit_as_the_other_program_says() {
    let other: Stepped =
        serde_json::from_str(include_str!("../data/stepped_impact.json")).expect("JSON");
    let part = |(length, width): (f64, f64)| [length, std::f64::consts::FRAC_PI_4 * width * width];
    let piston = [(0.20, 0.060), (0.15, 0.045)].map(part);
    let bit = [(0.15, 0.050), (0.10, 0.080)].map(part);
    let scene = scene(&piston, &bit, 0.0);
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
struct Spell {
    rod: usize,
    time: f64,
    force: f64,
}

#[derive(Deserialize)]
struct Solved {
    rods: usize,
    piston: Part,
    shank: Part,
    rod: Part,
    coupling: Part,
    bit: Part,
    felt: Vec<Spell>,
}

/// A string on rock that does not give: by `F/KR`, which its force follows within `Z/KR`, 1e-5 of a step.
#[test]
fn a_blow_goes_down_drawn_strings_as_the_other_program_says() {
    let strings: Vec<Solved> =
        serde_json::from_str(include_str!("../data/strings.json")).expect("JSON");
    for Solved { rods, piston, shank, rod, coupling, bit, felt } in strings {
        // A sleeve covers half its length of either neighbour.
        let shorter = |[length, area]: Part, by: f64| [length - by * coupling[0], area];
        let mut string = vec![shorter(shank, 0.5)];
        for k in 1..=rods {
            string.extend([coupling, shorter(rod, if k == rods { 0.5 } else { 1.0 })]);
        }
        string.push(bit);
        let scene = scene(&[piston], &string, 1e15);
        // Cells of 10 mm.
        let mut waves = Waves::new(scene.clone(), (100.0 * piston[0]).round() as u32);
        let mut felt = felt;
        felt.sort_by(|a, b| a.time.total_cmp(&b.time));
        for Spell { rod, time, force: known } in felt {
            waves.advance(time);
            let (section, part) = if rod == 0 { (string.len() - 1, 1.0) } else { (2 * rod, 0.5) };
            let pressed = force(&waves, &scene, [1, section], part);
            assert!((pressed - known).abs() < ROUNDING * 1e6, "{rods} {rod}: {pressed} {known}");
        }
    }
}
