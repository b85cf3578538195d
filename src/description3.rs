//! Writes the model description of FMI 3.0 from that of FMI 2.0 and the same table.

use crate::capabilities;
use crate::description::{
    Attributes, Writer, at_start, fingerprint, fragment, inputs, kind, number, of_output, outputs,
    real, typed, units, write_over_step,
};
use crate::events::{Extra, Length, MAX_LENGTH, MAX_POSITIONS};
use crate::variant::{ARRAYS, START_VALUES};
use hammer::Input;
use hammer::quantity::{COUNT, ENUMERATIONS, LENGTH, QUANTITIES, Quantity, TIME};
use hammer::variables::{ALONG, OF_BLOW, Role, VARIABLES};

/// The model description of FMI 3.0. It has the content of `two`, the description of FMI 2.0, and everything that only
/// FMI 3.0 has.
pub fn describe(two: &str) -> String {
    let between = |from: &str, to: &str| {
        let tail = &two[two.find(from).unwrap_or_default()..];
        let end = tail.find(to).map_or(tail.len(), |end| end + to.len());
        tail[..end].to_owned()
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
        format!("  <TypeDefinitions>\n{}\n  </TypeDefinitions>", fragment(write_types)),
        format!("  {}", between("<LogCategories>", "</LogCategories>")),
        format!("  {}", between("<DefaultExperiment", "/>")),
        format!("  <ModelVariables>\n{}\n  </ModelVariables>", fragment(write_variables)),
        format!("  <ModelStructure>\n{}\n  </ModelStructure>", fragment(write_structure)),
        format!("  <Annotations>\n{}\n  </Annotations>", fragment(write_annotations)),
        "</fmiModelDescription>\n".to_owned(),
    ]
    .join("\n");
    text.replace("@TOKEN@", &fingerprint(&text))
}

/// Writes how the token of a variant is formed: for other start values, and for arrays.
fn write_annotations(writer: &mut Writer) {
    writer.open("Annotation", &vec![("type", "dth_hammer.start_values".into())]);
    writer.leaf("StartValues", &vec![("token", format!("@TOKEN@{START_VALUES}"))]);
    writer.close("Annotation");
    writer.open("Annotation", &vec![("type", "dth_hammer.derivatives_over_step".into())]);
    write_over_step(writer);
    writer.close("Annotation");
    writer.open("Annotation", &vec![("type", "dth_hammer.arrays".into())]);
    writer.open("Arrays", &vec![("token", format!("@TOKEN@{ARRAYS}"))]);
    for extra in Extra::all().filter(|extra| extra.is_of_arrays()) {
        let (kind, mut attributes, length) = described(extra);
        attributes.insert(0, ("type", kind.into()));
        attributes.extend(length.map(|of| ("length", Extra::Length(of).reference().to_string())));
        writer.leaf("Row", &attributes);
    }
    writer.close("Arrays");
    writer.close("Annotation");
}

fn write_types(writer: &mut Writer) {
    for quantity in QUANTITIES {
        let mut attributes =
            vec![("name", quantity.name.into()), ("quantity", quantity.name.into())];
        attributes.extend(units(quantity));
        writer.leaf("Float64Type", &attributes);
    }
    for list in ENUMERATIONS {
        // The description is left out, since some importers cannot read it here.
        let attributes = vec![("name", list.name.into()), ("quantity", list.name.into())];
        writer.open("EnumerationType", &attributes);
        for (index, (item, meaning)) in list.items.iter().enumerate() {
            let attributes = vec![
                ("name", (*item).into()),
                ("value", (index + 1).to_string()),
                ("description", (*meaning).into()),
            ];
            writer.leaf("Item", &attributes);
        }
        writer.close("EnumerationType");
    }
}

fn write_variables(writer: &mut Writer) {
    for (reference, variable) in VARIABLES.iter().enumerate() {
        let [causality, variability, initial] = kind(variable);
        let mut attributes = vec![
            ("name", variable.name.into()),
            ("valueReference", reference.to_string()),
            ("description", variable.description.to_string()),
            ("causality", causality.into()),
            ("variability", variability.into()),
        ];
        if causality != "input" {
            attributes.push(("initial", initial.into()));
        }
        let (element, type_attributes) = typed(variable);
        attributes.extend(type_attributes);
        let element = match element {
            "Real" => "Float64",
            "Integer" => "Int32",
            same => same,
        };
        writer.leaf(element, &attributes);
    }
    for extra in Extra::all().filter(|extra| !extra.is_of_arrays()) {
        let (kind, attributes, _) = described(extra);
        writer.leaf(kind, &attributes);
    }
}

/// Type and attributes of a variable that only FMI 3.0 has and, for an array, the origin of its length. Variables of
/// the same kind have numbered names and value references.
fn described(extra: Extra) -> (&'static str, Attributes, Option<Length>) {
    let name = match extra {
        Extra::Position(index) => format!("{}[{}]", extra.name(), index + 1),
        _ => extra.name().into(),
    };
    let row = |causality: &str, variability: &str, more: Attributes| {
        let mut attributes = vec![
            ("name", name),
            ("valueReference", extra.reference().to_string()),
            ("description", extra.description()),
            ("causality", causality.into()),
            ("variability", variability.into()),
        ];
        if causality == "output" {
            attributes.push(("initial", "calculated".into()));
        }
        attributes.extend(more);
        attributes
    };
    let whole = |low: &str, high: u64| vec![("min", low.into()), ("max", high.to_string())];
    let starting = |start: u64, mut more: Attributes| {
        more.insert(0, ("start", start.to_string()));
        more
    };
    match extra {
        Extra::Time => ("Float64", row("independent", "continuous", real(&TIME)), None),
        Extra::EventBlow => {
            ("Boolean", row("parameter", "fixed", vec![("start", "true".into())]), None)
        }
        Extra::Positions => {
            let attributes = starting(0, whole("0", MAX_POSITIONS as u64));
            ("Int32", row("parameter", "fixed", attributes), None)
        }
        Extra::Length(length) => {
            let attributes = starting(Length::START[length as usize], whole("1", MAX_LENGTH));
            ("UInt64", row("structuralParameter", "fixed", attributes), None)
        }
        Extra::Position(_) => {
            let mut attributes = real(&LENGTH);
            attributes.push(("start", number(0.0)));
            ("Float64", row("parameter", "fixed", attributes), None)
        }
        Extra::Slope(input) => {
            let unit = format!("{}/s", of_input(input).unit);
            let attributes = vec![("unit", unit), ("start", number(0.0))];
            ("Float64", row("input", "continuous", attributes), None)
        }
        Extra::EventKind => ("Float64", row("output", "discrete", whole("0", 2)), None),
        Extra::EventPosition => {
            ("Float64", row("output", "discrete", whole("0", MAX_POSITIONS as u64)), None)
        }
        Extra::Along(family) => {
            let mut attributes = real(&ALONG[family].quantity);
            attributes.push(("nominal", number(ALONG[family].nominal)));
            ("Float64", row("output", "continuous", attributes), Some(Length::Stations))
        }
        Extra::BlowCount => ("Float64", row("output", "discrete", real(&COUNT)), None),
        Extra::OfBlow(figure) => {
            let attributes = OF_BLOW[figure].row().map(of_output).unwrap_or_default();
            ("Float64", row("output", "discrete", attributes), Some(Length::Blows))
        }
    }
}

fn of_input(input: Input) -> Quantity {
    let quantity = |role: &Role| match role {
        Role::Input(row) if row.input == input => Some(row.quantity),
        _ => None,
    };
    VARIABLES.iter().find_map(|variable| quantity(&variable.role)).unwrap_or(LENGTH)
}

fn write_structure(writer: &mut Writer) {
    let extra_outputs = || {
        let listed = |extra: &Extra| extra.is_output() && !extra.is_of_arrays();
        Extra::all().filter(listed).map(|extra| {
            vec![("valueReference", extra.reference().to_string()), ("dependencies", String::new())]
        })
    };
    for (index, output) in outputs() {
        let dependencies = inputs().filter(|(_, input)| output.feedthrough.contains(input));
        let list: Vec<String> = dependencies.map(|(index, _)| (index - 1).to_string()).collect();
        let reference = (index - 1).to_string();
        let mut attributes = vec![("valueReference", reference), ("dependencies", list.join(" "))];
        if !list.is_empty() {
            attributes.push(("dependenciesKind", vec!["dependent"; list.len()].join(" ")));
        }
        writer.leaf("Output", &attributes);
    }
    extra_outputs().for_each(|attributes| writer.leaf("Output", &attributes));
    for (index, output) in outputs() {
        let (reference, known) = ((index - 1).to_string(), at_start(output, 0));
        let attributes = vec![("valueReference", reference), ("dependencies", known)];
        writer.leaf("InitialUnknown", &attributes);
    }
    extra_outputs().for_each(|attributes| writer.leaf("InitialUnknown", &attributes));
}
