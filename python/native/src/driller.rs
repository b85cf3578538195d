//! Hammers from datasheets, rocks by name, damping by ratio: for Python.

use crate::failure::{Failure, refused};
use crate::interrupt::interruptible;
use crate::machine::guarded;
use crate::scene::scene_of;
use hammer::Input;
use hammer::datasheet::{Datasheet, DatasheetError, Entry, Quantity, Relation, Side};
use hammer::presets::{Figure, Ground, Inserts, ROCKS, RockError, RockType};
use hammer::variables::{Parameter, Role, VARIABLES, differences};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::HashMap;

/// Name, unit, unit of the trade and its size in the SI unit, range of real hammers, scatter of makers' numbers,
/// meaning.
type Number = (&'static str, &'static str, &'static str, f64, [f64; 2], f64, &'static str);

/// Every number that a datasheet may give.
#[pyfunction]
pub fn datasheet_numbers() -> Vec<Number> {
    let row = |quantity: Quantity| {
        let Entry { name, unit, field: (field, size), range, error, meaning, .. } =
            *quantity.entry();
        (name, unit, field, size, range, error, meaning)
    };
    Quantity::all().map(row).collect()
}

/// The hole (m) that suits the outside diameter of a hammer (m).
#[pyfunction]
pub fn usual_hole(od: f64) -> f64 {
    Datasheet::usual_hole(od)
}

/// Median of weighted numbers, and the ends of the range of 80 %.
#[pyfunction]
pub fn spread(values: Vec<f64>, weights: Vec<f64>) -> [f64; 3] {
    hammer::datasheet::spread(values.into_iter().zip(weights).collect())
}

/// What was given of a hammer: numbers by name, free air by pressure, the working pressure.
type Given = (HashMap<String, f64>, Vec<(f64, f64)>, Option<f64>);

fn sheet_of((given, air, at): Given, own_rock: bool) -> Datasheet {
    let known = Quantity::all()
        .filter_map(|quantity| given.get(quantity.name()).map(|value| (quantity, *value)));
    let air = air.into_iter().map(|(pressure, air)| [pressure, air]).collect();
    Datasheet { known: known.collect(), air, at, own_rock }
}

/// Why a change of a sheet is refused, if it is.
#[pyfunction]
pub fn refused_change(before: Given, after: Given) -> Option<String> {
    sheet_of(before, false).refused_change(&sheet_of(after, false))
}

/// A side of a ratio: what was given (none of a scene), the rock as it was named, members by name, weights, errors.
#[derive(FromPyObject)]
pub struct Compared(Option<Given>, String, Vec<(String, Vec<f64>)>, Vec<f64>, [f64; 2]);

impl From<Compared> for Side {
    fn from(Compared(given, rock, columns, weights, errors): Compared) -> Self {
        let sheet = given.map(|given| sheet_of(given, false));
        Self { sheet, rock, columns, weights, errors }
    }
}

/// Ratios of two hammers: name, median, and the ends of the range of 80 %; and whether they are of one hammer.
#[pyfunction]
pub fn ratios(a: Compared, b: Compared) -> (Vec<(&'static str, [f64; 3])>, bool) {
    let (a, b) = (Side::from(a), Side::from(b));
    (hammer::datasheet::ratios(&a, &b), Relation::of(&a, &b) == Relation::OneHammer)
}

/// The hammer of a datasheet, in the rock and with the feed of these numbers: its numbers, the given numbers beside
/// its own, what follows, the assumptions, and the contradictions.
#[pyfunction]
pub fn datasheet<'py>(
    py: Python<'py>,
    given: Given,
    own_rock: bool,
    numbers: HashMap<String, f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let own = scene_of(&numbers)?;
    let sheet = sheet_of(given, own_rock);
    let solved = interruptible(py, || guarded(|| Ok::<_, Failure>(sheet.solve(&own))))?;
    let solved = solved.map_err(|error| match error {
        DatasheetError::Engine(error) => PyErr::from(Failure::from(error)),
        other => refused(other.to_string()),
    })?;
    let compared = solved.compared.iter();
    let compared: Vec<_> = compared
        .map(|c| (c.quantity.name(), c.given, c.solved, c.quantity.entry().unit, c.pressure))
        .collect();
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
    let found: Vec<_> = found
        .map(|f| (f.name, f.value, f.range[0], f.range[1], f.unit, f.members.clone()))
        .collect();
    row.set_item("weights", solved.weights)?;
    row.set_item("found", found)?;
    row.set_item("assumed", solved.assumed)?;
    row.set_item("contradictions", solved.contradictions)?;
    Ok(row)
}

/// A number of a rock: name, value, least, largest, unit, source, whether it was measured.
type Row = (&'static str, f64, f64, f64, &'static str, &'static str, bool);

/// The rocks with their numbers.
#[pyfunction]
pub fn rocks() -> Vec<(&'static str, Vec<Row>)> {
    let row = |name, unit, figure: &Figure| {
        let [low, high] = figure.range;
        (name, figure.value, low, high, unit, figure.source, figure.measured)
    };
    let rows = |rock: &RockType| {
        vec![
            row("hardness", "Pa", &rock.hardness),
            row("unloading_ratio", "1", &rock.unloading_ratio),
            row("specific_energy", "J/m3", &rock.specific_energy()),
        ]
    };
    ROCKS.iter().map(|rock| (rock.name, rows(rock))).collect()
}

/// Numbers by name.
type Named = Vec<(&'static str, f64)>;

/// Usual inserts of a bit for a hole of this diameter (m): their number, and the radius of a tip (m).
#[pyfunction]
pub fn inserts(hole: f64) -> PyResult<(usize, f64)> {
    let bit = Inserts::of_hole(hole).map_err(message)?;
    Ok((bit.count, bit.radius))
}

fn message(error: RockError) -> PyErr {
    refused(error.to_string())
}

/// A rock by its name, class or strength: the numbers of its file, and the assumptions in them.
#[pyfunction]
pub fn ground(name: &str) -> PyResult<(Named, Vec<String>)> {
    let (mut rock, assumed) = Ground::named(name).map_err(message)?;
    Ok((named(&mut rock), assumed))
}

fn named(rock: &mut Ground) -> Named {
    Ground::ROWS.iter().map(|(name, _, at)| (*name, *at(rock))).collect()
}

/// The rock law's parameters of such a rock under a bit with inserts.
#[pyfunction]
pub fn ground_under(numbers: HashMap<String, f64>, inserts: usize, radius: f64) -> PyResult<Named> {
    let bit = Inserts { count: inserts, radius };
    let mut rock = Ground::of(&hammer::Parameters::default().rock, &bit);
    for (name, _, at) in Ground::ROWS {
        *at(&mut rock) = numbers.get(name).copied().unwrap_or(*at(&mut rock));
    }
    let rock = rock.under(&bit).map_err(message)?;
    let parameters = hammer::Parameters { rock, ..Default::default() };
    parameters.validate().map_err(Failure::from)?;
    // Another rock, which shows all parameters that depend on the rock.
    let mut other = Ground::of(&parameters.rock, &bit);
    for (_, _, at) in Ground::ROWS {
        *at(&mut other) = 2.0 * *at(&mut other) + 1.0;
    }
    let other = hammer::Parameters { rock: other.under(&bit).map_err(message)?, ..parameters };
    let slots = VARIABLES.iter().filter_map(|variable| match &variable.role {
        Role::Parameter(Parameter { slot, .. }) => Some((variable.name, slot)),
        _ => None,
    });
    let own = slots.map(|(name, slot)| (name, slot.read(&parameters), slot.read(&other)));
    Ok(own.filter(|(_, now, then)| now != then).map(|(name, now, _)| (name, now)).collect())
}

/// The rock of a scene, as the numbers of its file.
#[pyfunction]
pub fn ground_of(numbers: HashMap<String, f64>) -> PyResult<Named> {
    let p = scene_of(&numbers)?.parameters;
    let mut rock = Ground::of(&p.rock, &Inserts::of_hole(p.hole.diameter).map_err(message)?);
    Ok(named(&mut rock))
}

/// `beta = 2 zeta / omega` of the piston's first elastic mode, s, and its present ratio.
#[pyfunction]
pub fn damping(numbers: HashMap<String, f64>, ratio: f64) -> PyResult<(f64, f64)> {
    let parameters = scene_of(&numbers)?.parameters;
    Quantity::DampingRatio.check(ratio).map_err(|error| refused(error.to_string()))?;
    parameters.validate().map_err(Failure::from)?;
    let pair = parameters.damping_time_of(ratio).zip(parameters.damping_ratio());
    pair.ok_or_else(|| refused("the elastic modes of the piston cannot be computed"))
}
