//! Loads under which a hammer does not drill cause a warning, and no others do. Runs show the effect, independently
//! of the warning's arithmetic.

use hammer::Scene;
use hammer::presets::PRESETS;
use hammer::{Fidelity, Source};

/// Blows and work to the rock between 4 s, when every start is forgotten, and 8 s.
fn late(scene: &Scene) -> (usize, f64) {
    let mut machine = scene.machine().expect("a scene");
    machine.advance(4.0).expect("a run");
    let before = (machine.counters().blows, machine.energies().rock_dissipated);
    machine.advance(8.0).expect("a run");
    let (blows, work) = (machine.counters().blows, machine.energies().rock_dissipated);
    ((blows - before.0) as usize, work - before.1)
}

fn warned(scene: &Scene, of: &str) -> bool {
    scene.machine().expect("a scene").warnings().iter().any(|text| text.contains(of))
}

fn rigid() -> Scene {
    let mut scene = Scene::default();
    scene.parameters.fidelity = Fidelity::Rigid;
    scene
}

/// `F` lifts the piston if it exceeds `m g`; in an overhead hammer it throws the piston.
#[test]
fn a_drive_weaker_than_the_piston_s_weight_never_moves_it() {
    for gravity in [9.81, -9.81] {
        for (part, strikes) in [(0.95, false), (1.05, true)] {
            let mut scene = rigid();
            scene.parameters.gravity = gravity;
            let weight = scene.parameters.piston_mass() * gravity.abs();
            scene.parameters.drive.amplitude = part * weight;
            // The piston rests on the bit at the start, so that no bounce can reach the relay's stroke. The slowest
            // overhead throw has 0.05 g over the stroke of 50 mm: 0.22 m/s.
            scene.parameters.contact.initial_gap = 0.0;
            scene.parameters.blow.minimum_speed = 0.15;
            assert_eq!(late(&scene).0 > 0, strikes, "{gravity} {part}");
            assert_eq!(
                warned(&scene, "a piston at rest stays at rest"),
                !strikes,
                "{gravity} {part}"
            );
        }
    }
}

/// A supply at the exhaust's pressure has no effect.
#[test]
fn air_without_pressure_does_not_lift_the_piston() {
    for (supply, moves) in [(1.2e5, false), (1.5e6, true)] {
        let mut scene = rigid();
        scene.parameters.drive.source = Source::Air;
        (scene.inputs.supply_pressure, scene.inputs.exhaust_pressure) = (supply, 1e5);
        assert_eq!(late(&scene).0 > 0, moves, "{supply}");
        assert_eq!(warned(&scene, "stays at rest"), !moves, "{supply}");
    }
}

/// In a casing the drive's force is internal: only feed and weight press on the rock.
#[test]
fn a_feed_that_lifts_the_hammer_gives_the_rock_nothing() {
    let mut cased = rigid();
    (cased.parameters.casing.mass, cased.parameters.casing.impedance) = (20.0, 4e3);
    let p = &cased.parameters;
    let weight = (p.piston_mass() + p.bit_mass() + 20.0) * p.gravity;
    for (part, drills) in [(1.05, false), (0.9, true)] {
        cased.inputs.feed_force = -part * weight;
        assert_eq!(late(&cased).1 > 0.0, drills, "{part}");
        assert_eq!(warned(&cased, "lifts the hammer off the rock"), !drills, "{part}");
    }
    let mut bare = rigid();
    bare.inputs.feed_force = -5e4;
    assert_eq!(late(&bare).1, 0.0);
    assert!(warned(&bare, "feed_force = -50000.0 N lifts the hammer off the rock"));
}

#[test]
fn no_preset_is_warned_of() {
    for preset in PRESETS {
        let scene = preset.start();
        for text in ["stays at rest", "lifts the hammer"] {
            assert!(!warned(&scene, text), "{} {text}", preset.name);
        }
    }
}
