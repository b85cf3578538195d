//! The table of quantities for Python, and selections from it.

use crate::failure::UnknownNameError;
use hammer::presets::{PRESETS, Preset};
use hammer::quantity::{Enumeration, Quantity};
use hammer::variables::{
    ALONG, InputRow, OF_BLOW, OF_RECORD, OfBlow, Parameter, Role, Slot, VARIABLES, Variable,
};
use hammer::{Domain, InputValues, Parameters};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::collections::HashMap;

/// The figures of a blow, a column each.
pub fn blow_columns() -> impl Iterator<Item = &'static OfBlow> {
    OF_BLOW.iter().chain(&OF_RECORD)
}

/// The row of a name, of any kind.
pub fn row(name: &str) -> PyResult<(usize, &'static Variable)> {
    let found = VARIABLES.iter().enumerate().find(|(_, variable)| variable.name == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = VARIABLES.iter().map(|variable| variable.name).collect();
        UnknownNameError::new_err(("variable", name.to_owned(), names))
    })
}

/// A value that is read of a machine.
#[derive(Clone, Copy)]
pub enum Pick {
    /// A row of the table.
    Row(usize),
    /// A member of one of [`ALONG`], counted from 0.
    Wave(usize, usize),
}

impl Pick {
    fn of(name: &str) -> PyResult<Self> {
        let wave = || {
            let (family, index) = name.strip_suffix(']')?.split_once('[')?;
            let family = ALONG.iter().position(|f| f.name == family)?;
            let index: usize = index.parse().ok().filter(|index| *index > 0)?;
            Some(Self::Wave(family, index - 1))
        };
        match wave() {
            Some(pick) => Ok(pick),
            None => row(name).map(|(row, _)| Self::Row(row)),
        }
    }
}

/// Names that are read together.
#[pyclass(frozen, module = "dth_hammer._native")]
pub struct Selection {
    pub picks: Vec<Pick>,
}

#[pymethods]
impl Selection {
    #[new]
    fn new(names: Vec<String>) -> PyResult<Self> {
        Ok(Self { picks: names.iter().map(|name| Pick::of(name)).collect::<PyResult<_>>()? })
    }
}

/// Every variable in order, as the arguments of `dth_hammer.Variable`.
#[pyfunction]
pub fn variables(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let rows = VARIABLES.iter().enumerate();
    PyList::new(
        py,
        rows.map(|(position, v)| described(py, position, v)).collect::<PyResult<Vec<_>>>()?,
    )
}

fn described<'py>(py: Python<'py>, position: usize, v: &Variable) -> PyResult<Bound<'py, PyDict>> {
    let row = PyDict::new(py);
    row.set_item("name", v.name)?;
    row.set_item("reference", position)?;
    row.set_item("description", v.description)?;
    let [kind, causality, variability] = match &v.role {
        Role::Parameter(Parameter { slot, tunable, .. }) => {
            row.set_item("start", slot.read(&Parameters::default()))?;
            let kind = match slot {
                Slot::Real(quantity, _) => measured(&row, quantity).map(|()| "Real")?,
                Slot::Integer(_) => "Integer",
                Slot::Choice(items, ..) => chosen(&row, items).map(|()| "Enumeration")?,
            };
            [kind, "parameter", if *tunable { "tunable" } else { "fixed" }]
        }
        Role::Input(InputRow { quantity, start, .. }) => {
            row.set_item("start", *start(&mut InputValues::default()))?;
            measured(&row, quantity)?;
            ["Real", "input", "continuous"]
        }
        Role::Output(output) => {
            measured(&row, &output.quantity)?;
            if output.positive {
                row.set_item("minimum", 0.0)?;
            }
            ["Real", "output", if output.discrete { "discrete" } else { "continuous" }]
        }
        Role::Truth(_) => ["Boolean", "local", "discrete"],
        Role::Choice(items, _) => {
            chosen(&row, items)?;
            ["Enumeration", "local", "discrete"]
        }
    };
    row.set_item("kind", kind)?;
    row.set_item("causality", causality)?;
    row.set_item("variability", variability)?;
    match v.domain() {
        Some(Domain::AtLeast(low)) => row.set_item("minimum", low)?,
        // A minimum is itself allowed, so it is the least allowed number.
        Some(Domain::Above(low)) => row.set_item("minimum", low.next_up())?,
        Some(Domain::Between(low, high)) => {
            row.set_item("minimum", low)?;
            row.set_item("maximum", high)?;
        }
        Some(Domain::Any) | None => {}
    }
    Ok(row)
}

fn measured(row: &Bound<'_, PyDict>, quantity: &Quantity) -> PyResult<()> {
    row.set_item("quantity", quantity.name)?;
    row.set_item("unit", quantity.unit)?;
    row.set_item("display_unit", quantity.display.unwrap_or_default())
}

fn chosen(row: &Bound<'_, PyDict>, items: &Enumeration) -> PyResult<()> {
    let labels = PyDict::new(row.py());
    for (position, (label, _)) in items.items.iter().enumerate() {
        labels.set_item(position + 1, label)?;
    }
    row.set_item("quantity", items.name)?;
    row.set_item("labels", labels)
}

/// The presets: name, description, and the numbers in which each differs from the reference.
#[pyfunction]
pub fn presets() -> Vec<(&'static str, &'static str, HashMap<&'static str, f64>)> {
    let numbers = |preset: &Preset| preset.differences().into_iter().collect();
    PRESETS.iter().map(|p| (p.name, p.description, numbers(p))).collect()
}

/// What to use instead of a preset that no longer exists.
#[pyfunction]
pub fn instead_of(name: &str) -> Option<&'static str> {
    Preset::instead_of(name)
}
