//! The named hammers: they settle.

use hammer::periodic::{Search, find};
use hammer::presets::PRESETS;
use hammer::sensitivity::Scene;
use hammer::variables::{Role, Variable};

/// The scene of a preset, with its own start values of inputs.
fn scene(differences: &[(&str, f64)]) -> Scene {
    let mut scene = Scene::default();
    for (name, value) in differences {
        let (_, variable) = Variable::named(name).expect("a variable");
        let Role::Parameter { slot, .. } = &variable.role else { panic!("{name} is no parameter") };
        slot.write(&mut scene.parameters, *value);
    }
    scene
}

/// Each repeats exactly, after one return of its drive or, in granite, two; and what is a little off
/// comes back.
#[test]
fn every_preset_has_a_stationary_cycle_that_attracts() {
    for preset in PRESETS {
        let scene = scene(&preset.differences());
        let mut found = (1..=2).map(|returns| {
            let search = Search { returns, settle: 80 / returns, ..Search::default() };
            find(&scene, &search, &[])
        });
        let stable = found.find(|cycle| cycle.as_ref().is_ok_and(|cycle| cycle.is_stable()));
        assert!(stable.is_some(), "{} does not settle", preset.name);
    }
}

/// Half a per cent of critical damping in the piston's first elastic mode, to the three digits that
/// are kept of the damping time; the reference's own time is less than a fifth of that.
#[test]
fn the_hammers_named_by_size_have_the_assumed_damping() {
    for preset in PRESETS.iter().filter(|preset| preset.name.contains("hammer")) {
        let mut parameters = scene(&preset.differences()).parameters;
        let ratio = parameters.damping_ratio().expect("modes");
        assert!((ratio / 0.005 - 1.0).abs() < 5e-3, "{}: {ratio}", preset.name);
        parameters.material.damping_time = 2e-8;
        assert!(parameters.damping_ratio().expect("modes") < 1e-3, "{}", preset.name);
    }
}

/// `omega = pi c / L` of a uniform free bar, but for the mesh's error `theta^2 / 24`.
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
