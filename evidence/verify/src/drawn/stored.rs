//! Scenes that failed once, stored as themselves.

use crate::drawn::scenes::RandomScene;
use hammer::Parameters;
use serde_json::Value;

/// Writes what is `stored` over the values of the same names.
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

/// The scene that an object holds: its parameters are those that the scene had, and younger ones have
/// their defaults.
///
/// # Panics
/// If it holds none.
pub fn scene(mut object: Value) -> RandomScene {
    let mut all = serde_json::to_value(Parameters::default()).expect("plain data");
    overlay(&mut all, object["parameters"].take());
    object["parameters"] = all;
    serde_json::from_value(object).expect("a scene")
}
