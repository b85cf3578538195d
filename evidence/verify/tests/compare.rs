//! Drawn scenes against the extended-precision reference: new ones in which everything occurs together, and stored
//! ones that disagreed once. `COMPARE_SCENES` is the number of new ones; `cargo compare --scenes 5000` is the long
//! form, and prints a scene that disagrees in the form that `compared.json` stores.

use hammer::presets::PRESETS;
use hammer::{Scene, Segment};
use serde_json::Value;
use verify::comparison::compare::compare;
use verify::comparison::known::Account;
use verify::comparison::tally::{Kind, Tally, tally};
use verify::drawn::scenes::RandomScene;
use verify::drawn::stored::scene;

/// Number of scenes asked for; none for as few as the suite has time for.
fn wanted() -> Option<u32> {
    std::env::var("COMPARE_SCENES").ok().and_then(|number| number.parse().ok())
}

#[test]
fn scenes_with_everything_agree() {
    let tally: Tally = tally((wanted().unwrap_or(20), 0), Kind::Mixed, |_| (), |_, _| ());
    // As in `cargo compare`, a difference below what a guard resolves is no disagreement.
    assert!(tally.failures.is_empty(), "{}\n{}", tally.line(), tally.failures.join("\n"));
    // If nothing could be compared, the test would show nothing.
    assert!(tally.events > tally.scenes as usize, "{}", tally.line());
    assert!(5 * tally.refused < tally.scenes, "{}", tally.line());
}

/// A blow of every preset on its own mesh, bare, in a rigid and in an elastic casing, at 9 m/s and from a distance of
/// 1 um. In 300 us the wave goes through a hammer of a metre and back. The suite runs one of the three for each
/// preset.
#[test]
fn presets_agree_on_the_meshes_that_users_get() {
    for (number, preset) in PRESETS.iter().enumerate() {
        let Scene { parameters: bare, inputs } = preset.start();
        let length = bare.piston.length + bare.bit.length;
        let mass = 3.0 * bare.bit_mass();
        let mut rigid = bare;
        (rigid.casing.mass, rigid.casing.impedance) = (mass, 100.0 * mass);
        let mut elastic = rigid;
        let area = mass / (length * bare.material.density);
        elastic.casing.segments.set(&[Segment { length, area }]);
        for (around, mut parameters) in [bare, rigid, elastic].into_iter().enumerate() {
            if wanted().is_none() && around != number % 3 {
                continue;
            }
            (parameters.piston.initial_velocity, parameters.contact.initial_gap) = (9.0, 1e-6);
            let case = RandomScene::alone(parameters, inputs, 3e-4);
            let apart = compare(&Account::over(&case, usize::MAX).unwrap()).unwrap();
            // As above, a difference below what guards resolve is no disagreement.
            let agree = apart.none() || apart.is_invisible();
            assert!(agree && apart.events > 4, "{}: {apart:?}", preset.name);
        }
    }
}

/// The reference integrates the air itself, as mass and energy, by series in extended precision.
#[test]
fn drawn_scenes_driven_by_air_agree() {
    let found = tally((wanted().map_or(14, |n| n / 10), 0), Kind::Air, |_| (), |_, _| ());
    assert!(found.failures.is_empty(), "{}", found.failures.join("\n"));
    // About half of the scenes are determined in double precision, and few are refused.
    assert!(3 * found.whole > found.scenes && 5 * found.refused < found.scenes, "{}", found.line());
}

/// The reaction of a line is in the reference's equation of motion, while the engine has a force in windows.
#[test]
fn drawn_scenes_with_a_line_at_the_piston_agree() {
    let found = tally((wanted().map_or(12, |n| n / 10), 0), Kind::Line, |_| (), |_, _| ());
    assert!(found.failures.is_empty(), "{}", found.failures.join("\n"));
    assert!(3 * found.whole > found.scenes && 5 * found.refused < found.scenes, "{}", found.line());
}

/// A scene of the other kinds ends, in the middle, after six events. These reach what a blow leaves for the next.
#[test]
fn drawn_hammers_agree_up_to_their_second_blow() {
    let found = tally((wanted().map_or(8, |n| n / 10), 0), Kind::Blows, |_| (), |_, _| ());
    assert!(found.failures.is_empty(), "{}", found.failures.join("\n"));
    assert!(2 * found.whole > found.scenes && found.refused == 0, "{}", found.line());
    assert!(found.events as u32 > 20 * found.scenes, "{}", found.line());
}

fn compared(kind: Kind, group: &str, excuse: Option<&str>) {
    let stored: Vec<Value> = serde_json::from_str(include_str!("compared.json")).expect("JSON");
    let mut tally = Tally::default();
    let mut scenes = 0;
    for object in stored.into_iter().filter(|object| object["group"] == group) {
        let name = format!("scene {scenes} (once: {})", object["wrong"]);
        tally.add(&name, kind, &scene(object), &mut |_| ());
        scenes += 1;
    }
    let lists = [("rough", &tally.rough), ("at_rest", &tally.at_rest), ("unseen", &tally.unseen)];
    let others = lists.into_iter().filter(|(name, _)| excuse != Some(name));
    let apart: Vec<_> = others.flat_map(|(_, list)| list).chain(&tally.failures).collect();
    assert!(apart.is_empty(), "{apart:#?}");
    // A hammer at rest has no events, nor has one in flight.
    let moves = tally.events > 0 || ["standing", "flying"].iter().any(|way| group.starts_with(way));
    assert!(scenes > 0 && moves && tally.instants > scenes, "{}", tally.line());
}

/// Declares a test for each group of stored scenes that must agree, except for a stated reason.
macro_rules! agree {
    ($($name:ident $(or $excuse:ident)?),* $(,)?) => {
        $(#[test] fn $name() {
            compared(Kind::Mixed, stringify!($name), None$(.or(Some(stringify!($excuse))))?);
        })*
    };
}

agree! {
    beyond_a_guard,
    back_at_its_level,
    retuned_at_rest,
    no_gain,
    steep_unloading,
    light_bit or rough,
    chaotic_joints or rough,
    rough_casing or rough,
    casing_on_a_weak_string,
    unequal_bodies or rough,
    retuned_twice_at_once,
    standing_tip_is_pushed or rough,
    air_outpaces_the_bodies,
    air_moves_an_event,
    flying_as_the_exhaust_leaps,
    standing_without_pressure,
}

/// The tip almost stands between two pushes, and the barrier is reached in the second.
#[test]
fn a_barrier_is_met_between_two_pushes() {
    compared(Kind::Blows, "between_two_pushes", None);
}
