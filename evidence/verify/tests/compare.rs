//! Drawn scenes against the extended-precision reference: fresh ones in which everything occurs together,
//! and those that disagreed once. `COMPARE_SCENES` sets how many; `cargo compare --scenes 5000` is the
//! long form, and tells a scene that disagrees as `compared.json` stores it.

use serde_json::Value;
use verify::stored::scene;
use verify::tally::{Kind, Tally, tally};

#[test]
fn scenes_with_everything_agree() {
    let wanted = std::env::var("COMPARE_SCENES").ok().and_then(|n| n.parse().ok());
    let tally: Tally = tally(wanted.unwrap_or(60), 0, Kind::Mixed, |_| ());
    // As `cargo compare` counts: what differs by less than a guard resolves is no disagreement.
    assert!(tally.failures.is_empty(), "{}\n{}", tally.line(), tally.failures.join("\n"));
    // Scenes in which nothing could be compared would say nothing.
    assert!(tally.events > tally.scenes as usize, "{}", tally.line());
    assert!(5 * tally.refused < tally.scenes, "{}", tally.line());
}

fn compared(group: &str) -> Tally {
    let stored: Vec<Value> = serde_json::from_str(include_str!("compared.json")).expect("JSON");
    let mut tally = Tally::default();
    let mut scenes = 0;
    for object in stored.into_iter().filter(|object| object["group"] == group) {
        let name = format!("scene {scenes} (once: {})", object["wrong"]);
        tally.add(&name, &scene(object), &mut |_| ());
        scenes += 1;
    }
    let apart = [&tally.failures[..], &tally.at_rest, &tally.unseen].concat();
    assert!(apart.is_empty(), "{}", apart.join("\n"));
    // A hammer that stands has no event.
    let moves = tally.events > 0 || group.starts_with("standing");
    assert!(scenes > 0 && moves && tally.instants > scenes, "{}", tally.line());
    tally
}

/// Declares a test a group of scenes that agree now, rough bases included where that is said.
macro_rules! agree {
    ($($name:ident $(or $rough:ident)?),* $(,)?) => {
        $(#[test] fn $name() {
            let tally = compared(stringify!($name));
            let rough_bases = false $(|| stringify!($rough) == "rough")?;
            assert!(rough_bases || tally.rough.is_empty(), "{}", tally.rough.join("\n"));
        })*
    };
}

agree! {
    beyond_a_guard,
    back_at_its_level,
    retuned_at_rest,
    no_gain,
    steep_unloading,
    light_bit,
    chaotic_joints or rough,
    rough_casing or rough,
    standing_in_a_light_casing,
}

/// Open: the tip stands 4e-7 m deep beside a casing that stands 27 mm deep, whose rounding is what its force
/// is off by; a restart that the reference does not resolve is taken.
#[test]
#[ignore = "disagrees: the tip's static force lacks ten digits beside the casing's displacement"]
fn standing_in_a_casing_of_grams() {
    compared("standing_in_a_casing_of_grams");
}
