//! Writes the model description of FMI 3.0 from that of 2.0 and the same table. Runs in
//! `build.rs` only.

use crate::capabilities;
use crate::description::{
    Attributes, close, fingerprint, fragment, inputs, kind, leaf, number, of_output, open, outputs,
    real, typed, units,
};
use crate::events::{Clock, Extra, Length, MAX_LENGTH, MAX_POSITIONS, changes_at_blows};
use crate::variant::START_VALUES;
use hammer::Input;
use hammer::families::{ALONG, OF_BLOW};
use hammer::quantity::{COUNT, ENUMERATIONS, LENGTH, QUANTITIES, Quantity, TIME};
use hammer::variables::{Role, VARIABLES};
use quick_xml::Writer;
use std::io::Result;

/// The description of FMI 3.0 with the content of `two` and what only FMI 3.0 has; and its token.
pub fn describe(two: &str) -> Result<(String, String)> {
    let between = |from: &str, to: &str| {
        let rest = &two[two.find(from).unwrap_or_default()..];
        let end = rest.find(to).map_or(rest.len(), |end| end + to.len());
        rest[..end].to_owned()
    };
    let (begin, end) = ("<fmiModelDescription", "structured\">");
    let guid = between("guid=\"", "\"\n");
    let head = between(begin, end).replace("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\"");
    let head = head.replace(guid.trim_end(), "instantiationToken=\"@TOKEN@\"");
    let claims = capabilities::attributes_3();
    let claims: String =
        claims.iter().map(|(name, value)| format!("\n    {name}=\"{value}\"")).collect();
    let text = [
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>".to_owned(),
        head,
        format!("  <CoSimulation modelIdentifier=\"dth_hammer\"{claims}/>"),
        format!("  {}", between("<UnitDefinitions>", "</UnitDefinitions>")),
        format!("  <TypeDefinitions>\n{}\n  </TypeDefinitions>", fragment(write_types)?),
        format!("  {}", between("<LogCategories>", "</LogCategories>")),
        format!("  {}", between("<DefaultExperiment", "/>")),
        format!("  <ModelVariables>\n{}\n  </ModelVariables>", fragment(write_variables)?),
        format!("  <ModelStructure>\n{}\n  </ModelStructure>", fragment(write_structure)?),
        format!("  <Annotations>\n{}\n  </Annotations>", fragment(write_start_values)?),
        "</fmiModelDescription>\n".to_owned(),
    ]
    .join("\n");
    let token = fingerprint(&text);
    Ok((text.replace("@TOKEN@", &token), token))
}

/// The parts of a variant with other start values.
fn write_start_values(writer: &mut Writer<Vec<u8>>) -> Result<()> {
    open(writer, "Annotation", &vec![("type", "dth_hammer.start_values".into())])?;
    leaf(writer, "StartValues", &vec![("token", format!("@TOKEN@{START_VALUES}"))])?;
    close(writer, "Annotation")
}

fn write_types(writer: &mut Writer<Vec<u8>>) -> Result<()> {
    for quantity in QUANTITIES {
        let mut attributes =
            vec![("name", quantity.name.into()), ("quantity", quantity.name.into())];
        attributes.extend(units(quantity));
        leaf(writer, "Float64Type", &attributes)?;
    }
    for list in ENUMERATIONS {
        let attributes = vec![
            ("name", list.name.into()),
            ("description", list.description.into()),
            ("quantity", list.name.into()),
        ];
        open(writer, "EnumerationType", &attributes)?;
        for (index, (item, meaning)) in list.items.iter().enumerate() {
            let attributes = vec![
                ("name", (*item).into()),
                ("value", (index + 1).to_string()),
                ("description", (*meaning).into()),
            ];
            leaf(writer, "Item", &attributes)?;
        }
        close(writer, "EnumerationType")?;
    }
    Ok(())
}

fn write_variables(writer: &mut Writer<Vec<u8>>) -> Result<()> {
    for (reference, variable) in VARIABLES.iter().enumerate() {
        let [causality, variability, initial] = kind(variable);
        let name = variable.name;
        let mut attributes = vec![
            ("name", name.into()),
            ("valueReference", reference.to_string()),
            ("description", variable.description.to_string()),
            ("causality", causality.into()),
            ("variability", variability.into()),
        ];
        if causality != "input" {
            attributes.push(("initial", initial.into()));
        }
        if changes_at_blows(name) {
            let clock = Extra::Clock(Clock::Blow).reference();
            attributes.push(("clocks", clock.to_string()));
        }
        let (element, more) = typed(variable);
        attributes.extend(more);
        let element = match element {
            "Real" => "Float64",
            "Integer" => "Int32",
            same => same,
        };
        leaf(writer, element, &attributes)?;
    }
    Extra::all().try_for_each(|extra| write_extra(writer, extra))
}

/// Names and value references of an extra variable, which is of a kind.
fn write_extra(writer: &mut Writer<Vec<u8>>, extra: Extra) -> Result<()> {
    let name = match extra {
        Extra::Position(index) => format!("{}[{}]", extra.name(), index + 1),
        _ => extra.name().into(),
    };
    let row = |causality: &str, variability: &str, more: Attributes| {
        let mut attributes = vec![
            ("name", name.clone()),
            ("valueReference", extra.reference().to_string()),
            ("description", extra.description()),
            ("causality", causality.into()),
            ("variability", variability.into()),
        ];
        attributes.extend(more);
        attributes
    };
    let whole = |start: String, [low, high]: [String; 2]| {
        vec![("start", start), ("min", low), ("max", high)]
    };
    match extra {
        Extra::Time => leaf(writer, "Float64", &row("independent", "continuous", real(&TIME))),
        Extra::EventBlow => {
            leaf(writer, "Boolean", &row("parameter", "fixed", vec![("start", "true".into())]))
        }
        Extra::Positions => {
            let range = ["0".into(), MAX_POSITIONS.to_string()];
            leaf(writer, "Int32", &row("parameter", "fixed", whole("0".into(), range)))
        }
        Extra::Length(length) => {
            let range = ["1".into(), MAX_LENGTH.to_string()];
            let more = whole(Length::START[length as usize].to_string(), range);
            leaf(writer, "UInt64", &row("structuralParameter", "fixed", more))
        }
        Extra::Position(_) => {
            let mut more = real(&LENGTH);
            more.push(("start", number(0.0)));
            leaf(writer, "Float64", &row("parameter", "fixed", more))
        }
        Extra::Slope(input) => {
            let unit = format!("{}/s", of_input(input).unit);
            let more = vec![("unit", unit), ("start", number(0.0))];
            leaf(writer, "Float64", &row("input", "continuous", more))
        }
        Extra::Clock(_) => {
            let more = vec![("intervalVariability", "triggered".into())];
            leaf(writer, "Clock", &row("output", "discrete", more))
        }
        Extra::Along(family) => {
            let mut more = real(&ALONG[family].quantity);
            more.push(("nominal", number(ALONG[family].nominal)));
            write_array(writer, Length::Stations, row("output", "continuous", more))
        }
        Extra::BlowCount => {
            let mut more = real(&COUNT);
            more.push(("initial", "calculated".into()));
            leaf(writer, "Float64", &row("output", "discrete", more))
        }
        Extra::OfBlow(figure) => {
            let more = OF_BLOW[figure].row().map(of_output).unwrap_or_default();
            write_array(writer, Length::Blows, row("output", "discrete", more))
        }
    }
}

fn write_array(
    writer: &mut Writer<Vec<u8>>,
    length: Length,
    mut attributes: Attributes,
) -> Result<()> {
    attributes.push(("initial", "calculated".into()));
    open(writer, "Float64", &attributes)?;
    let reference = Extra::Length(length).reference().to_string();
    leaf(writer, "Dimension", &vec![("valueReference", reference)])?;
    close(writer, "Float64")
}

fn of_input(wanted: Input) -> Quantity {
    let quantity = |role: &Role| match role {
        Role::Input { input, quantity, .. } if *input == wanted => Some(*quantity),
        _ => None,
    };
    VARIABLES.iter().find_map(|variable| quantity(&variable.role)).unwrap_or(LENGTH)
}

fn write_structure(writer: &mut Writer<Vec<u8>>) -> Result<()> {
    let is_output = |e: &Extra| e.is_array() || matches!(e, Extra::Clock(_) | Extra::BlowCount);
    let more = || Extra::all().filter(is_output);
    for (index, output) in outputs() {
        let fed = inputs().filter(|(_, input)| output.feedthrough.contains(input));
        let list: Vec<String> = fed.map(|(index, _)| (index - 1).to_string()).collect();
        let reference = (index - 1).to_string();
        let mut attributes = vec![("valueReference", reference), ("dependencies", list.join(" "))];
        if !list.is_empty() {
            attributes.push(("dependenciesKind", vec!["dependent"; list.len()].join(" ")));
        }
        leaf(writer, "Output", &attributes)?;
    }
    for extra in more() {
        let reference = extra.reference().to_string();
        let attributes = vec![("valueReference", reference), ("dependencies", String::new())];
        leaf(writer, "Output", &attributes)?;
    }
    for (index, output) in outputs() {
        let name = VARIABLES[index - 1].name;
        if changes_at_blows(name) {
            continue; // What is clocked is no unknown of the initialization.
        }
        let mut attributes = vec![("valueReference", (index - 1).to_string())];
        attributes.extend(output.zero_at_start.then(|| ("dependencies", String::new())));
        leaf(writer, "InitialUnknown", &attributes)?;
    }
    for extra in more() {
        let mut attributes = vec![("valueReference", extra.reference().to_string())];
        let along = matches!(extra, Extra::Along(_));
        attributes.extend((!along).then(|| ("dependencies", String::new())));
        leaf(writer, "InitialUnknown", &attributes)?;
    }
    Ok(())
}
