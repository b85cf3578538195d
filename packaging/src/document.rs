//! `documentation/index.html`, from its template and the variable table.

use crate::Standard;
use crate::binary::Binary;
use crate::licenses::License;
use dth_hammer::category::Category;
use dth_hammer::{CAPACITY, GUID, TOKEN};
use hammer::presets::{PRESETS, Preset};
use hammer::quantity::{ENUMERATIONS, Quantity};
use hammer::variables::{InputRow, Parameter, Role, Slot, VARIABLES, Variable};
use hammer::{Domain, InputValues, MAX_INPUT_ORDER, Parameters};
use quick_xml::escape::escape;

const TEMPLATE: &str = include_str!("../index.html.in");

/// The page.
pub fn write(standard: Standard, libraries: &[Binary], licenses: &[License]) -> String {
    let (mark, other, version, label, token, suffix) = match standard {
        Standard::Two => ("@2@", "@3@", "2.0", "GUID", GUID, ""),
        Standard::Three => ("@3@", "@2@", "3.0", "instantiation token", TOKEN, "_fmi3"),
    };
    let platform = |library: &Binary| {
        let row = |place: String| vec![name(&place), text(&library.runs_on)];
        library.places(standard).into_iter().map(row).collect::<Vec<_>>()
    };
    let marks = [
        ("@VERSION@", env!("CARGO_PKG_VERSION").to_owned()),
        ("@LICENSE@", env!("CARGO_PKG_LICENSE").to_owned()),
        ("@STANDARD@", version.to_owned()),
        ("@LABEL@", label.to_owned()),
        ("@GUID@", token.to_owned()),
        ("@FILE@", format!("dth_hammer{suffix}.fmu")),
        ("@ORDER@", MAX_INPUT_ORDER.to_string()),
        ("@CAPACITY@", CAPACITY.to_string()),
        ("@CATEGORIES@", rows(Category::ALL.map(|c| vec![name(c.name()), text(c.description())]))),
        ("@PARAMETERS@", rows(VARIABLES.iter().filter_map(parameter))),
        ("@INPUTS@", rows(VARIABLES.iter().filter_map(input))),
        ("@OUTPUTS@", rows(VARIABLES.iter().filter_map(output))),
        ("@ENUMERATIONS@", rows(enumerations())),
        ("@PRESETS@", rows(presets())),
        ("@PLATFORMS@", rows(libraries.iter().flat_map(platform))),
        ("@LICENSES@", rows(licenses.iter().map(|l| vec![text(&l.name), text(&l.terms)]))),
    ];
    // Lines of only one standard begin with its mark.
    let lines = TEMPLATE.lines().filter(|line| !line.starts_with(other));
    let page: String = lines.flat_map(|l| [l.strip_prefix(mark).unwrap_or(l), "\n"]).collect();
    marks.iter().fold(page, |page, (mark, value)| page.replace(mark, value))
}

/// A cell of the table, as HTML.
type Cell = String;

fn rows(rows: impl IntoIterator<Item = Vec<Cell>>) -> String {
    let row = |cells: Vec<Cell>| format!("<tr>{}</tr>", cells.concat());
    rows.into_iter().map(row).collect::<Vec<_>>().join("\n")
}

fn text(text: &str) -> Cell {
    format!("<td>{}</td>", escape(text))
}

fn number(value: impl ToString) -> Cell {
    format!("<td class=\"n\">{}</td>", escape(value.to_string()))
}

fn name(name: &str) -> Cell {
    format!("<td class=\"n\"><code>{}</code></td>", escape(name))
}

fn unit(quantity: &Quantity) -> Cell {
    number(match quantity.unit {
        "1" => "",
        unit => unit,
    })
}

fn parameter(variable: &Variable) -> Option<Vec<Cell>> {
    let Role::Parameter(Parameter { slot, tunable, .. }) = variable.role else { return None };
    let start = slot.read(&Parameters::default());
    let (unit, start) = match slot {
        Slot::Real(quantity, _) => (unit(quantity), number(rounded(start))),
        Slot::Integer(_) => (number("count"), number(start)),
        Slot::Choice(items, ..) => {
            let item = items.items.get((start as usize).saturating_sub(1));
            (name(items.name), name(item.map_or("", |(item, _)| item)))
        }
    };
    let range = match (slot, variable.domain()) {
        (Slot::Choice(..), _) | (_, None | Some(Domain::Any)) => String::new(),
        (_, Some(Domain::AtLeast(low))) => format!("≥ {low}"),
        (_, Some(Domain::Above(low))) => format!("> {low}"),
        (_, Some(Domain::Between(low, high))) => format!("{low} to {high}"),
    };
    let when = if *tunable { "tunable" } else { "" };
    let cells = [name(variable.name), unit, start, number(range), text(when)];
    Some(cells.into_iter().chain([text(variable.description)]).collect())
}

/// A number as people write it: with a power of ten where it is large or small.
fn rounded(value: f64) -> String {
    let written = value == 0.0 || (1e-3..1e6).contains(&value.abs());
    if written { format!("{value}") } else { format!("{value:e}") }
}

fn input(variable: &Variable) -> Option<Vec<Cell>> {
    let Role::Input(InputRow { quantity, start, .. }) = &variable.role else { return None };
    let start = *start(&mut InputValues::default());
    Some(vec![name(variable.name), unit(quantity), number(start), text(variable.description)])
}

fn output(variable: &Variable) -> Option<Vec<Cell>> {
    let (unit, orders) = match &variable.role {
        Role::Output(output) => {
            let orders = if output.second.is_some() { "1, 2" } else { "1" };
            (unit(&output.quantity), orders)
        }
        Role::Truth(_) => (number("Boolean"), ""),
        Role::Choice(items, _) => (name(items.name), ""),
        Role::Parameter(_) | Role::Input(_) => return None,
    };
    Some(vec![name(variable.name), unit, text(orders), text(variable.description)])
}

fn enumerations() -> Vec<Vec<Cell>> {
    let items = ENUMERATIONS.iter().flat_map(|list| {
        list.items.iter().enumerate().map(|(index, (item, meaning))| {
            vec![name(list.name), number(index + 1), name(item), text(meaning)]
        })
    });
    items.collect()
}

fn presets() -> Vec<Vec<Cell>> {
    let row = |preset: &Preset| {
        let list = preset.differences();
        let line = |(name, value): &(&str, f64)| {
            format!("<code>{} = {}</code>", escape(*name), rounded(*value))
        };
        let list: Vec<String> = list.iter().map(line).collect();
        let cell = format!("<td>{}</td>", list.join("<br>"));
        vec![name(preset.name), text(preset.description), cell]
    };
    PRESETS.iter().map(row).collect()
}
