//! Hammers from datasheets, rocks by name, damping by ratio: for Python.

use crate::failure::{Failure, refused};
use crate::interrupt::interruptible;
use crate::machine::guarded;
use crate::scene::scene_of;
use hammer::Input;
use hammer::datasheet::{Datasheet, DatasheetError, Quantity};
use hammer::presets::{Figure, Inserts, ROCKS, RockType};
use hammer::variables::differences;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::HashMap;

/// Of each number that a datasheet may give: name, unit, unit of the trade and how many of the SI unit
/// that is, meaning.
#[pyfunction]
pub fn datasheet_numbers() -> Vec<(&'static str, &'static str, &'static str, f64, &'static str)> {
    let row = |quantity: Quantity| {
        let (field, size) = quantity.field_unit();
        (quantity.name(), quantity.unit(), field, size, quantity.meaning())
    };
    Quantity::all().map(row).collect()
}

/// The hole (m) that suits the outside diameter of a hammer (m).
#[pyfunction]
pub fn usual_hole(od: f64) -> f64 {
    Datasheet::usual_hole(od)
}

/// The hammer that fits a datasheet best, in the rock and with the feed of these numbers: its numbers,
/// what was given beside what it gives, what it gives else, what was assumed, what contradicts.
#[pyfunction]
pub fn datasheet<'py>(
    py: Python<'py>,
    given: HashMap<String, f64>,
    own_rock: bool,
    numbers: HashMap<String, f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let own = scene_of(&numbers)?;
    let known = Quantity::all()
        .filter_map(|quantity| given.get(quantity.name()).map(|value| (quantity, *value)));
    let sheet = Datasheet { known: known.collect(), own_rock };
    let solved = interruptible(py, || guarded(|| Ok::<_, Failure>(sheet.solve(&own))))?;
    let solved = solved.map_err(|error| match error {
        DatasheetError::Engine(error) => PyErr::from(Failure::from(error)),
        other => refused(other.to_string()),
    })?;
    let compared = solved.compared.iter();
    let compared: Vec<_> =
        compared.map(|c| (c.quantity.name(), c.given, c.solved, c.quantity.unit())).collect();
    let row = PyDict::new(py);
    let mut parameters = differences(&solved.scene.parameters);
    let (inputs, usual) = (solved.scene.inputs, own.inputs);
    for (input, found, own) in [
        (Input::FeedForce, inputs.feed_force, usual.feed_force),
        (Input::SupplyPressure, inputs.supply_pressure, usual.supply_pressure),
    ] {
        parameters.extend((found != own).then(|| (input.name(), found)));
    }
    row.set_item("parameters", parameters)?;
    row.set_item("compared", compared)?;
    let found = solved.found.iter();
    let found: Vec<_> = found.map(|f| (f.name, f.value, f.range[0], f.range[1], f.unit)).collect();
    row.set_item("found", found)?;
    row.set_item("assumed", solved.assumed)?;
    row.set_item("contradictions", solved.contradictions)?;
    Ok(row)
}

/// A number of a rock: name, value, least, largest, unit, source, whether it was measured.
type Row = (&'static str, f64, f64, f64, &'static str, &'static str, bool);

/// The rocks: name, and what is known of it.
#[pyfunction]
pub fn rocks() -> Vec<(&'static str, Vec<Row>)> {
    let row = |name, unit, figure: &Figure| {
        let [low, high] = figure.range;
        (name, figure.value, low, high, unit, figure.source, figure.measured)
    };
    let rows = |rock: &RockType| {
        let mut list = vec![
            row("hardness", "Pa", &rock.hardness),
            row("unloading_ratio", "1", &rock.unloading_ratio),
        ];
        list.extend(rock.specific_energy.iter().map(|f| row("specific_energy", "J/m3", f)));
        list
    };
    ROCKS.iter().map(|rock| (rock.name, rows(rock))).collect()
}

/// Numbers by name.
type Named = Vec<(&'static str, f64)>;

/// Inserts of a bit by the hole's diameter (m): how many, and the radius of each one's tip (m).
#[pyfunction]
pub fn inserts(hole: f64) -> PyResult<(usize, f64)> {
    let bit = Inserts::of_hole(hole).map_err(|error| refused(error.to_string()))?;
    Ok((bit.count, bit.radius))
}

/// The rock law's parameters under a bit of inserts, and what is assumed in them.
#[pyfunction]
pub fn rock(name: &str, inserts: usize, radius: f64) -> PyResult<(Named, Vec<String>)> {
    let message = |error: hammer::presets::RockError| refused(error.to_string());
    let kind = RockType::named(name).map_err(message)?;
    let rock = kind.under(&Inserts { count: inserts, radius }).map_err(message)?;
    let parameters = hammer::Parameters { rock, ..Default::default() };
    Ok((differences(&parameters), kind.assumptions()))
}

/// `beta = 2 zeta / omega` of the piston's first elastic mode, s, and the ratio that it has now.
#[pyfunction]
pub fn damping(numbers: HashMap<String, f64>, ratio: f64) -> PyResult<(f64, f64)> {
    let parameters = scene_of(&numbers)?.parameters;
    Quantity::DampingRatio.check(ratio).map_err(|error| refused(error.to_string()))?;
    parameters.validate().map_err(Failure::from)?;
    let pair = parameters.damping_time_of(ratio).zip(parameters.damping_ratio());
    pair.ok_or_else(|| refused("the elastic modes of the piston cannot be computed"))
}
