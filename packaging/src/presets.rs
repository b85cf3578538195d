//! Parameter sets for `resources/`: each lists only what differs from the defaults.

use crate::Failure;
use crate::archive::File;
use crate::hammers;
use hammer::Parameters;
use hammer::variables::{Role, Slot, VARIABLES};
use quick_xml::escape::escape;
use serde::Serialize;
use serde_json::{Map, Number, Value};
use std::collections::BTreeMap;

/// A parameter set.
pub struct Preset {
    /// File name without extension.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    change: fn(&mut Parameters),
}

/// The parameter sets. But for the first they are illustrations: plausible beside it, taken
/// from no measurement.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "reference",
        description: "The reference hammer of Depouhon, Denoël and Detournay: all start values as they are",
        change: |_| {},
    },
    Preset {
        name: "medium_rock",
        description: "Reference hammer in stiffer, more viscous rock; illustrative, not measured",
        change: |p| {
            p.rock.stiffness = 2.4e8;
            p.rock.viscosity = 2.2e5;
            p.rock.energy_barrier = 8.0;
        },
    },
    Preset {
        name: "granite",
        description: "Reference hammer in much stiffer rock, as granite is; illustrative, not measured",
        change: |p| {
            p.rock.stiffness = 5e8;
            p.rock.unloading_ratio = 6.0;
            p.rock.viscosity = 3e5;
            p.rock.energy_barrier = 15.0;
        },
    },
    Preset {
        name: "long_bit",
        description: "A bit of twice the length, with elements of the same size: longer waves; illustrative",
        change: |p| {
            p.bit.length *= 2.0;
            p.bit.elements *= 2;
        },
    },
    Preset {
        name: "hammer_2_inch",
        description: "A 2-inch hammer of stepped bodies, 64 mm hole; made up in the style of its class",
        change: hammers::two_inch,
    },
    Preset {
        name: "hammer_3_inch",
        description: "A 3-inch hammer, 90 mm hole: the piston's areas are those of Drillco's Puma 3.1, the rest is made up",
        change: hammers::three_inch,
    },
    Preset {
        name: "hammer_4_inch",
        description: "A 4-inch hammer of stepped bodies, 115 mm hole; made up in the style of its class",
        change: hammers::four_inch,
    },
    Preset {
        name: "hammer_6_inch",
        description: "A 6-inch hammer of stepped bodies, 165 mm hole; made up in the style of its class",
        change: hammers::six_inch,
    },
    Preset {
        name: "hammer_8_inch",
        description: "An 8-inch hammer of stepped bodies, 215 mm hole; made up in the style of its class",
        change: hammers::eight_inch,
    },
    Preset {
        name: "water_hammer",
        description: "A 4-inch water hammer, 115 mm hole: slender piston, short stroke, 60 Hz; made up in the style of its class",
        change: hammers::water,
    },
];

#[derive(Serialize)]
struct Content {
    description: &'static str,
    start_values: Map<String, Value>,
}

impl Preset {
    /// Names and values that differ from the defaults.
    pub fn differences(&self) -> Vec<(&'static str, f64)> {
        let (before, mut after) = (Parameters::default(), Parameters::default());
        (self.change)(&mut after);
        let changed = VARIABLES.iter().filter_map(|variable| {
            let Role::Parameter { slot, .. } = &variable.role else { return None };
            let value = slot.read(&after);
            (value != slot.read(&before)).then_some((variable.name, value))
        });
        changed.collect()
    }

    /// The file's text.
    ///
    /// # Errors
    /// None that is known; the encoder could refuse.
    fn json(&self) -> Result<String, Failure> {
        Ok(serde_json::to_string_pretty(&self.content())? + "\n")
    }

    fn content(&self) -> Content {
        let values = self.differences().into_iter().filter_map(|(name, value)| {
            let whole = value.fract() == 0.0 && value.abs() < 1e6;
            let number =
                if whole { Some(Number::from(value as i64)) } else { Number::from_f64(value) };
            number.map(|number| (name.to_owned(), Value::Number(number)))
        });
        Content { description: self.description, start_values: values.collect() }
    }
}

impl Preset {
    /// The same as a parameter set of SSP 1.0, for hosts that read those.
    fn ssv(&self) -> String {
        let parameter = |(name, value): (&str, f64)| {
            let typed = match VARIABLES.iter().find(|v| v.name == name).map(|v| v.role) {
                Some(Role::Parameter { slot: Slot::Real(..), .. }) => {
                    format!("<ssv:Real value=\"{value:?}\"/>")
                }
                _ => format!("<ssv:Integer value=\"{value:.0}\"/>"),
            };
            format!("    <ssv:Parameter name=\"{name}\">{typed}</ssv:Parameter>\n")
        };
        let list: String = self.differences().into_iter().map(parameter).collect();
        let (name, description) = (self.name, escape(self.description));
        format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssv="{SSV}" version="1.0" name="{name}" description="{description}">
  <ssv:Parameters>
{list}  </ssv:Parameters>
</ssv:ParameterSet>
"#
        )
    }
}

/// Namespace of parameter sets in SSP 1.0.
const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";

/// The files for the archive: each set as JSON and as SSV.
///
/// # Errors
/// None that is known; the encoder could refuse.
pub fn files() -> Result<Vec<File>, Failure> {
    let mut files = Vec::new();
    for preset in PRESETS {
        files.push(File::new(format!("resources/{}.json", preset.name), preset.json()?));
        files.push(File::new(format!("resources/{}.ssv", preset.name), preset.ssv()));
    }
    Ok(files)
}

/// All of them by name, as one text.
///
/// # Errors
/// None that is known; the encoder could refuse.
pub fn all() -> Result<String, Failure> {
    let contents: BTreeMap<_, _> = PRESETS.iter().map(|p| (p.name, p.content())).collect();
    Ok(serde_json::to_string(&contents)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quick_xml::Reader;
    use quick_xml::events::{BytesStart, Event};

    /// What a reader of the XML finds is what the JSON has.
    #[test]
    fn a_preset_is_the_same_in_both_forms() {
        for preset in PRESETS {
            let text = preset.ssv();
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

    #[test]
    fn presets_lie_in_their_domains_and_list_only_what_differs() {
        for preset in PRESETS {
            let mut parameters = Parameters::default();
            (preset.change)(&mut parameters);
            assert_eq!(parameters.validate(), Ok(()), "{}", preset.name);
            assert_eq!(preset.differences().is_empty(), preset.name == "reference");
        }
    }
}
