//! The engine's presets as files for `resources/`.

use crate::Failure;
use crate::archive::File;
use hammer::presets::{PRESETS, Preset};
use hammer::variables::{Parameter, Role, Slot, VARIABLES};
use quick_xml::escape::escape;
use serde::Serialize;
use serde_json::{Map, Number, Value};
use std::collections::BTreeMap;

#[derive(Serialize)]
struct Content {
    description: &'static str,
    start_values: Map<String, Value>,
}

/// A preset as JSON.
fn json(preset: &Preset) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(&content(preset))? + "\n")
}

fn content(preset: &Preset) -> Content {
    let values = preset.differences().into_iter().filter_map(|(name, value)| {
        let whole = value.fract() == 0.0 && value.abs() < 1e6;
        let number = if whole { Some(Number::from(value as i64)) } else { Number::from_f64(value) };
        number.map(|number| (name.to_owned(), Value::Number(number)))
    });
    Content { description: preset.description, start_values: values.collect() }
}

/// The same as a parameter set of SSP 1.0, for hosts that read those.
fn ssv(preset: &Preset) -> String {
    let parameter = |(name, value): (&str, f64)| {
        let typed = match VARIABLES.iter().find(|v| v.name == name).map(|v| v.role) {
            Some(Role::Input(_) | Role::Parameter(Parameter { slot: Slot::Real(..), .. })) => {
                format!("<ssv:Real value=\"{value:?}\"/>")
            }
            _ => format!("<ssv:Integer value=\"{value:.0}\"/>"),
        };
        format!("    <ssv:Parameter name=\"{name}\">{typed}</ssv:Parameter>\n")
    };
    let list: String = preset.differences().into_iter().map(parameter).collect();
    let (name, description) = (preset.name, escape(preset.description));
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssv="{SSV}" version="1.0" name="{name}" description="{description}">
  <ssv:Parameters>
{list}  </ssv:Parameters>
</ssv:ParameterSet>
"#
    )
}

/// Namespace of parameter sets in SSP 1.0.
const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";

/// The files for the archive: each set as JSON and as SSV.
pub fn files() -> Result<Vec<File>, Failure> {
    let mut files = Vec::new();
    for preset in PRESETS {
        files.push(File::new(format!("resources/{}.json", preset.name), json(preset)?));
        files.push(File::new(format!("resources/{}.ssv", preset.name), ssv(preset)));
    }
    Ok(files)
}

/// All presets by name, as one text.
pub fn all() -> Result<String, Failure> {
    let contents: BTreeMap<_, _> = PRESETS.iter().map(|p| (p.name, content(p))).collect();
    Ok(serde_json::to_string(&contents)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quick_xml::Reader;
    use quick_xml::events::{BytesStart, Event};

    /// The XML has the same numbers as the JSON.
    #[test]
    fn a_preset_is_the_same_in_both_forms() {
        for preset in PRESETS {
            let text = ssv(preset);
            let (mut reader, mut found) = (Reader::from_str(&text), Vec::new());
            let mut name = String::new();
            loop {
                match reader.read_event().unwrap() {
                    Event::Start(tag) if tag.name().as_ref() == "ssv:Parameter" => {
                        name = attribute(&tag, "name");
                    }
                    Event::Empty(tag) => {
                        found.push((name.clone(), attribute(&tag, "value").parse().unwrap()));
                    }
                    Event::Eof => break,
                    _ => {}
                }
            }
            let expected: Vec<(String, f64)> =
                preset.differences().into_iter().map(|(n, v)| (n.to_owned(), v)).collect();
            assert_eq!(found, expected, "{}", preset.name);
        }
    }

    fn attribute(tag: &BytesStart, name: &str) -> String {
        let found = tag.try_get_attribute(name).unwrap().unwrap();
        found.value.into_owned()
    }
}
