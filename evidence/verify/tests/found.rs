//! Stored scenes that once broke the engine: found by the properties, then shrunk.

use serde_json::Value;
use verify::drawn::stored::scene;
use verify::laws::properties::PROPERTIES;

fn assert_stored(name: &str) {
    let stored: Vec<Value> = serde_json::from_str(include_str!("found.json")).expect("JSON");
    let object = stored.into_iter().find(|object| object["name"] == name);
    let object = object.expect("a scene of this name");
    let (wrong, scene) = (object["wrong"].to_string(), scene(object));
    for (property, holds) in PROPERTIES {
        assert!(holds(&scene).is_ok(), "{property} (once: {wrong}): {:?}", holds(&scene));
    }
}

/// Declares a test for each stored scene.
macro_rules! stored {
    ($($name:ident),* $(,)?) => {
        $(#[test] fn $name() { assert_stored(stringify!($name)); })*
    };
}

stored! {
    touches_in_the_precursor,
    standstill_under_a_newton,
    contact_and_rock_by_picometres,
    pushed_off_stiff_rock,
    heavy_piston_on_a_light_bit,
    heavy_piston_under_feed,
    heavy_piston_at_gamma_one,
    heavy_piston_on_soft_rock,
    light_bit_overdamped,
    forces_balance_on_a_light_bit,
}
