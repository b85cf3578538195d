//! The presets: damping, mesh, and names that no longer exist.

use hammer::Scene;
use hammer::presets::{PRESETS, Preset};
use hammer::{Body, Reading};

/// The scene of a preset, with its own start values of inputs.
fn scene(preset: &Preset) -> Scene {
    preset.start()
}

/// Half a per cent of critical damping in the piston's first elastic mode, to the three digits of the damping time;
/// the reference's own time is less than a fifth of that.
#[test]
fn a_hammer_of_stepped_bodies_has_the_assumed_damping() {
    for preset in PRESETS.iter().filter(|preset| preset.name.contains("hammer")) {
        if scene(preset).parameters.drill.rods > 0 {
            continue;
        }
        let mut parameters = scene(preset).parameters;
        let ratio = parameters.damping_ratio().expect("modes");
        assert!((ratio / 0.005 - 1.0).abs() < 5e-3, "{}: {ratio}", preset.name);
        parameters.material.damping_time = 2e-8;
        assert!(parameters.damping_ratio().expect("modes") < 1e-3, "{}", preset.name);
    }
}

/// `omega = pi c / L` of a uniform free bar, up to the mesh's error `theta^2 / 24`.
#[test]
fn the_first_elastic_frequency_is_that_of_a_free_bar() {
    let p = Scene::default().parameters;
    let exact = std::f64::consts::PI * p.wave_speed() / p.piston.length;
    let theta = std::f64::consts::PI / p.piston.elements as f64;
    let found = p.first_elastic_frequency().expect("modes");
    assert!((found / exact - 1.0).abs() < theta * theta / 20.0, "{found} {exact}");
    let rigid = hammer::Parameters { fidelity: hammer::Fidelity::Rigid, ..p };
    assert_eq!(rigid.first_elastic_frequency(), Some(found));
}

/// A rate has an error of a hundredth, and no finer mesh is used.
#[test]
fn a_hammer_of_stepped_bodies_has_the_mesh_that_a_rate_needs() {
    for preset in PRESETS.iter().filter(|preset| preset.name.contains("hammer")) {
        let p = scene(preset).parameters;
        let mesh = p.mesh_for(Reading::Rate, 0.01).expect("a mesh");
        let mut advised = p;
        mesh.apply(&mut advised);
        assert_eq!(p, advised, "{}", preset.name);
        if p.drill.rods > 0 {
            continue;
        }
        let force = p.mesh_for(Reading::Force, 0.05).expect("a mesh");
        let [coarse, fine] = [&mesh, &force].map(|mesh| mesh.of(Body::Piston));
        assert!(fine > coarse && p.force_error() > 0.05, "{}", preset.name);
    }
}

/// Names of presets that were rocks say what to use instead; other names do not.
#[test]
fn a_preset_that_went_says_what_to_take() {
    for name in ["granite", "medium_rock", "hammer_3_inch", "hammer_8_inch"] {
        assert!(Preset::named(name).is_none() && Preset::instead_of(name).is_some(), "{name}");
    }
    assert!(PRESETS.iter().all(|preset| Preset::instead_of(preset.name).is_none()));
}
