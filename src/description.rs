//! Writes `modelDescription.xml` from the template and the table of variables.
//!
//! The library contains the committed copy, which `cargo describe` refreshes. A test fails if the copy is out of date,
//! and the packager refuses it.

use crate::capabilities;
use crate::category::{Category, LOG_ALL};
use crate::variant::START_VALUES;
use hammer::quantity::{ENUMERATIONS, Enumeration, QUANTITIES, Quantity};
use hammer::variables::{InputRow, Output, Role, STEP_SIZE, STOP_TIME, Slot, VARIABLES, Variable};
use hammer::{Domain, InputValues, Parameters};
use std::fmt::Write;

pub(crate) type Attributes = Vec<(&'static str, String)>;

/// The model description of FMI 2.0.
pub fn describe() -> String {
    let mut text = include_str!("../modelDescription.xml.in").to_owned();
    for (mark, value) in [
        ("@VERSION@", env!("CARGO_PKG_VERSION")),
        ("@AUTHOR@", env!("CARGO_PKG_AUTHORS")),
        ("@LICENSE@", env!("CARGO_PKG_LICENSE")),
    ] {
        text = text.replace(mark, &escape(value));
    }
    let claims =
        capabilities::attributes().map(|(name, value)| format!("\n    {name}=\"{value}\""));
    text = text.replace("@CAPABILITIES@", &claims.concat());
    text = text.replace("@STOP_TIME@", &STOP_TIME.to_string());
    text = text.replace("@STEP_SIZE@", &STEP_SIZE.to_string());
    text = text.replace("@TYPES@", &fragment(write_types));
    text = text.replace("@CATEGORIES@", &fragment(write_categories));
    // The schema demands one element for each tool.
    text = text.replace("@OVER_STEP@", &fragment(write_over_step));
    text = text.replace("@START_VALUES@", &fragment(write_start_values));
    text = text.replace("@VARIABLES@", &fragment(write_variables));
    text = text.replace("@STRUCTURE@", &fragment(write_structure));
    text.replace("@GUID@", &fingerprint(&text))
}

/// A hash of a text (FNV-1a of 128 bits) in the form of a UUID. Any change of the interface changes it.
pub(crate) fn fingerprint(text: &str) -> String {
    const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let hash = text.bytes().fold(BASIS, |h, byte| (h ^ u128::from(byte)).wrapping_mul(PRIME));
    let hex = format!("{hash:032x}");
    [&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]].join("-")
}

/// Writes XML elements, one on each line, indented as in the template.
pub(crate) struct Writer {
    text: String,
    depth: usize,
}

impl Writer {
    fn line(&mut self, before: &str, name: &str, attributes: &Attributes, after: &str) {
        let _ = write!(self.text, "\n{:1$}{before}{name}", "", 4 + 2 * self.depth);
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"{}\"", escape(value));
        }
        self.text += after;
    }

    pub fn leaf(&mut self, name: &str, attributes: &Attributes) {
        self.line("<", name, attributes, "/>");
    }

    pub fn open(&mut self, name: &str, attributes: &Attributes) {
        self.line("<", name, attributes, ">");
        self.depth += 1;
    }

    pub fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line("</", name, &Attributes::new(), ">");
    }
}

fn escape(text: &str) -> String {
    let marks = [('&', "&amp;"), ('<', "&lt;"), ('>', "&gt;"), ('\'', "&apos;"), ('"', "&quot;")];
    marks.iter().fold(text.to_owned(), |text, (mark, name)| text.replace(*mark, name))
}

/// The part of the document that `write` writes.
pub(crate) fn fragment(write: fn(&mut Writer)) -> String {
    let mut writer = Writer { text: String::new(), depth: 0 };
    write(&mut writer);
    writer.text.trim_start_matches('\n').to_owned()
}

fn write_types(writer: &mut Writer) {
    for quantity in QUANTITIES {
        writer.open("SimpleType", &vec![("name", quantity.name.into())]);
        let mut attributes = vec![("quantity", quantity.name.into())];
        attributes.extend(units(quantity));
        writer.leaf("Real", &attributes);
        writer.close("SimpleType");
    }
    for Enumeration { name, description, items } in ENUMERATIONS {
        let attributes = vec![("name", (*name).into()), ("description", (*description).into())];
        writer.open("SimpleType", &attributes);
        writer.open("Enumeration", &vec![("quantity", (*name).into())]);
        for (index, (item, meaning)) in items.iter().enumerate() {
            let attributes = vec![
                ("name", (*item).into()),
                ("value", (index + 1).to_string()),
                ("description", (*meaning).into()),
            ];
            writer.leaf("Item", &attributes);
        }
        writer.close("Enumeration");
        writer.close("SimpleType");
    }
}

fn write_categories(writer: &mut Writer) {
    let everything = (LOG_ALL, "All of them");
    let named = Category::ALL.iter().map(|category| (category.name(), category.description()));
    for (name, description) in named.chain([everything]) {
        let attributes = vec![("name", name.into()), ("description", description.into())];
        writer.leaf("Category", &attributes);
    }
}

/// Writes the annotation about the value references of derivatives over the last step.
pub(crate) fn write_over_step(writer: &mut Writer) {
    let attributes = vec![
        ("firstValueReference", capabilities::OVER_STEP.to_string()),
        ("description", capabilities::OVER_STEP_DESCRIPTION.into()),
    ];
    writer.leaf("Derivatives", &attributes);
}

/// Writes how the GUID of a variant with other start values is made.
fn write_start_values(writer: &mut Writer) {
    writer.leaf("StartValues", &vec![("guid", format!("@GUID@{START_VALUES}"))]);
}

fn write_variables(writer: &mut Writer) {
    for (reference, variable) in VARIABLES.iter().enumerate() {
        let [causality, variability, initial] = kind(variable);
        let mut attributes = vec![
            ("name", variable.name.into()),
            ("valueReference", reference.to_string()),
            ("description", variable.description.into()),
            ("causality", causality.into()),
            ("variability", variability.into()),
        ];
        // The schema forbids the attribute `initial` for inputs, since it follows from the causality.
        if causality != "input" {
            attributes.push(("initial", initial.into()));
        }
        writer.open("ScalarVariable", &attributes);
        let (element, attributes) = typed(variable);
        writer.leaf(element, &attributes);
        writer.close("ScalarVariable");
    }
}

pub(crate) fn kind(variable: &Variable) -> [&'static str; 3] {
    match &variable.role {
        Role::Parameter(row) if row.tunable => ["parameter", "tunable", "exact"],
        Role::Parameter(_) => ["parameter", "fixed", "exact"],
        Role::Input(_) => ["input", "continuous", "exact"],
        Role::Output(Output { discrete: false, .. }) => ["output", "continuous", "calculated"],
        Role::Output(Output { discrete: true, .. }) => ["output", "discrete", "calculated"],
        Role::Truth(_) | Role::Choice(..) => ["local", "discrete", "calculated"],
    }
}

pub(crate) fn units(quantity: &Quantity) -> Attributes {
    let mut attributes = vec![("unit", quantity.unit.into())];
    attributes.extend(quantity.display.map(|unit| ("displayUnit", unit.into())));
    attributes
}

/// Attributes of a real variable. Unit and display unit of the declared type are repeated, since some hosts read them
/// only here.
pub(crate) fn real(quantity: &Quantity) -> Attributes {
    let mut attributes = vec![("declaredType", quantity.name.into())];
    attributes.extend(units(quantity));
    attributes
}

/// Attributes of an output: its type, range and nominal value.
pub(crate) fn of_output(output: &Output) -> Attributes {
    let mut attributes = real(&output.quantity);
    attributes.extend(output.positive.then(|| ("min", number(0.0))));
    attributes.push(("nominal", number(output.nominal)));
    attributes
}

pub(crate) fn typed(variable: &Variable) -> (&'static str, Attributes) {
    match &variable.role {
        Role::Parameter(row) => typed_parameter(variable, &row.slot),
        Role::Input(InputRow { quantity, start, nominal, .. }) => {
            let mut attributes = real(quantity);
            attributes.push(("nominal", number(*nominal)));
            attributes.push(("start", number(*start(&mut InputValues::default()))));
            ("Real", attributes)
        }
        Role::Output(output) => ("Real", of_output(output)),
        Role::Truth(_) => ("Boolean", Attributes::new()),
        Role::Choice(items, _) => ("Enumeration", vec![("declaredType", items.name.into())]),
    }
}

fn typed_parameter(variable: &Variable, slot: &Slot) -> (&'static str, Attributes) {
    let start = slot.read(&Parameters::default());
    match slot {
        Slot::Real(quantity, _) => {
            let mut attributes = real(quantity);
            attributes.extend(range(variable, number));
            // The default is of the parameter's usual size, so it is the nominal value.
            attributes.extend((start != 0.0).then(|| ("nominal", number(start.abs()))));
            attributes.push(("start", number(start)));
            ("Real", attributes)
        }
        Slot::Integer(_) => {
            let mut attributes = range(variable, whole);
            attributes.push(("start", whole(start)));
            ("Integer", attributes)
        }
        Slot::Choice(items, ..) => {
            let mut attributes = vec![("declaredType", items.name.into())];
            attributes.extend(range(variable, whole));
            attributes.push(("start", whole(start)));
            ("Enumeration", attributes)
        }
    }
}

fn range(variable: &Variable, show: fn(f64) -> String) -> Attributes {
    match variable.domain() {
        Some(Domain::AtLeast(low)) => vec![("min", show(low))],
        // The attribute `min` is itself allowed, so it is the least allowed number. For "above 0" it is the least
        // normal number, since `std::stod` throws an exception for a subnormal one.
        Some(Domain::Above(low)) => {
            let least = low.next_up();
            vec![("min", show(if least.is_subnormal() { f64::MIN_POSITIVE } else { least }))]
        }
        Some(Domain::Between(low, high)) => vec![("min", show(low)), ("max", show(high))],
        Some(Domain::Any) | None => Attributes::new(),
    }
}

pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}

fn whole(value: f64) -> String {
    format!("{value:.0}")
}

fn write_structure(writer: &mut Writer) {
    writer.open("Outputs", &Attributes::new());
    for (index, output) in outputs() {
        let dependencies = inputs().filter(|(_, input)| output.feedthrough.contains(input));
        let list: Vec<String> = dependencies.map(|(index, _)| index.to_string()).collect();
        let mut attributes = vec![("index", index.to_string()), ("dependencies", list.join(" "))];
        if !list.is_empty() {
            attributes.push(("dependenciesKind", vec!["dependent"; list.len()].join(" ")));
        }
        writer.leaf("Unknown", &attributes);
    }
    writer.close("Outputs");
    writer.open("InitialUnknowns", &Attributes::new());
    for (index, output) in outputs() {
        let dependencies = at_start(output, 1);
        writer.leaf("Unknown", &vec![("index", index.to_string()), ("dependencies", dependencies)]);
    }
    writer.close("InitialUnknowns");
}

/// The dependencies of an output at the start: positions of parameters and inputs, counted from `first`. Without this
/// attribute the output would also depend on all of them, but some importers crash without it.
pub(crate) fn at_start(output: &Output, first: usize) -> String {
    let known = |(position, variable): (usize, &Variable)| {
        matches!(variable.role, Role::Parameter(_) | Role::Input(_))
            .then(|| (first + position).to_string())
    };
    let all = VARIABLES.iter().enumerate().filter(|_| !output.zero_at_start).filter_map(known);
    all.collect::<Vec<_>>().join(" ")
}

/// The outputs, each with its index, which counts from 1.
pub(crate) fn outputs() -> impl Iterator<Item = (usize, &'static Output)> {
    VARIABLES.iter().enumerate().filter_map(|(position, variable)| match &variable.role {
        Role::Output(output) => Some((position + 1, output)),
        _ => None,
    })
}

pub(crate) fn inputs() -> impl Iterator<Item = (usize, hammer::Input)> {
    VARIABLES.iter().enumerate().filter_map(|(position, variable)| match &variable.role {
        Role::Input(row) => Some((position + 1, row.input)),
        _ => None,
    })
}
