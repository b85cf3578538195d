//! Derivatives of the results of a Python function, by differences of its runs.

use crate::failure::{Failure, refused};
use crate::interrupt::interruptible;
use crate::machine::Machine;
use crate::scene::scene_of;
use hammer::Error;
use hammer::Scene;
use hammer::sensitivity::{self, Argument, Sample};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use std::collections::HashMap;
use std::sync::Mutex;

/// The arguments of these names.
fn named(names: &[String]) -> PyResult<Vec<Argument>> {
    let refusal = |name| refused(format!("there is no derivative by {name}"));
    names.iter().map(|name| Argument::named(name).ok_or_else(|| refusal(name))).collect()
}

/// Derivatives, their errors, how far they hold, and why a derivative may hold on one side only.
type Row<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, f64, Vec<String>);

/// Derivatives of a run by arguments, one in a row. `run` is called with the changed numbers, and returns an array
/// and the machine, which records a journal, at the run's end.
#[pyfunction]
pub fn derivatives<'py>(
    py: Python<'py>,
    numbers: HashMap<String, f64>,
    by: Vec<String>,
    run: Py<PyAny>,
) -> PyResult<Vec<Row<'py>>> {
    let (scene, by) = (scene_of(&numbers)?, named(&by)?);
    let raised = Mutex::new(None);
    let sample = |at: &Scene| {
        // All arguments, not those of the derivatives alone: the engine makes the air's error smaller, too.
        let changed =
            Argument::all().filter(|argument| argument.value(at) != argument.value(&scene));
        let changed: HashMap<&str, f64> = changed.map(|a| (a.name(), a.value(at))).collect();
        // The engine refuses values outside the domain, so that derivatives know its edges.
        at.parameters.validate()?;
        let ended = Error::Cancelled;
        // After one run has raised an exception, no further run is started.
        if raised.lock().is_ok_and(|known| known.is_some()) {
            return Err(ended);
        }
        Python::attach(|py| converted(run.bind(py), changed)).map_err(|error| {
            if let Ok(mut known) = raised.lock() {
                known.get_or_insert(error);
            }
            ended
        })
    };
    let found = interruptible(py, || Ok(sensitivity::derivatives(&scene, &by, &sample)?));
    if let (Err(Failure::Refused(_)), Ok(Some(error))) = (&found, raised.into_inner()) {
        return Err(error);
    }
    let row = |d: sensitivity::Derivative| {
        let why = d.nonsmooth.iter().map(ToString::to_string).collect();
        (d.values.into_pyarray(py), d.errors.into_pyarray(py), d.reach, why)
    };
    Ok(found?.into_iter().map(row).collect())
}

/// Converts the result of a Python run.
fn converted(run: &Bound<'_, PyAny>, changed: HashMap<&str, f64>) -> PyResult<Sample> {
    let answer = run.call1((changed,))?;
    let (values, machine): (PyReadonlyArray1<'_, f64>, Bound<'_, Machine>) = answer.extract()?;
    let events = machine.get().events(run.py())?;
    Ok(Sample { values: values.as_array().to_vec(), events, ..Sample::default() })
}
