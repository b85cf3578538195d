//! Stored scenes that failed once.

use crate::drawn::scenes::RandomScene;
use hammer::Parameters;
use serde_json::Value;

/// Overwrites the values of the same names with the `stored` ones.
fn overlay(value: &mut Value, stored: Value) {
    match (value, stored) {
        (Value::Object(all), Value::Object(stored)) => {
            for (name, own) in stored {
                overlay(all.get_mut(&name).expect("a parameter of this name"), own);
            }
        }
        (value, stored) => *value = stored,
    }
}

/// The scene of a stored object. Parameters that are newer than the object have their defaults.
///
/// # Panics
/// If the object is not a scene.
pub fn scene(mut object: Value) -> RandomScene {
    let mut all = serde_json::to_value(Parameters::default()).expect("plain data");
    overlay(&mut all, object["parameters"].take());
    object["parameters"] = all;
    serde_json::from_value(object).expect("a scene")
}
