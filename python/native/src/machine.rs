//! The hammer as a Python object.

use crate::failure::{Failure, refused};
use crate::interrupt::interruptible;
use crate::response::{Asked, response_numbers, wanted_of};
use crate::scene::scene_of;
use crate::session::Session;
use crate::snapshot::Snapshot;
use crate::table::{Selection, blow_columns, row};
use crate::turn::Turn;
use hammer::means::{Simulation, Waiting, steady_of};
use hammer::variables::Role;
use hammer::{Blow, Input, MAX_INPUT_ORDER, Stops};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A table of numbers.
pub type Table<'py> = Bound<'py, PyArray2<f64>>;

/// A hammer in motion, made from numbers by name. The others are those of the reference hammer.
#[pyclass(frozen, module = "dth_hammer._native")]
pub struct Machine {
    session: Turn<Session>,
}

impl Machine {
    /// Works on the session, while other threads run.
    fn long<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Session) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let mut turn = self.session.begin(py)?;
        Ok(interruptible(py, turn.attempt(work))?)
    }

    /// The same for work that takes less time than letting other threads run.
    fn short<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Session) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let mut turn = self.session.begin(py)?;
        Ok(turn.attempt(work)()?)
    }

    /// The events since the last call, if a journal is kept.
    pub fn events(&self, py: Python<'_>) -> PyResult<Vec<hammer::Record>> {
        self.short(py, |session| Ok(session.machine.take_journal()))
    }
}

/// Turns a panic into a failure.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| Err(Failure::of_panic(&*payload)))
}

/// A quantity that can be set while a hammer runs.
enum Settable {
    Input(Input),
    /// A tunable parameter, by its row.
    Parameter(usize),
}

impl Settable {
    fn set(&self, session: &mut Session, value: f64) {
        match self {
            Self::Input(input) => session.set_input(*input, Some(value), &[]),
            Self::Parameter(row) => session.tune(*row, value),
        }
    }
}

fn settable(name: &str) -> PyResult<Settable> {
    let (position, variable) = row(name)?;
    match &variable.role {
        Role::Input(row) => Ok(Settable::Input(row.input)),
        Role::Parameter(row) if row.tunable => Ok(Settable::Parameter(position)),
        _ => Err(refused(format!("{name} cannot be set while a hammer runs"))),
    }
}

/// Values that are set at each point of a run.
struct Signal {
    what: Settable,
    /// Values at the start, then at each instant.
    values: Vec<f64>,
}

/// All blows, one in a row.
fn blow_table<'py>(py: Python<'py>, blows: &[Blow]) -> PyResult<Table<'py>> {
    let row = |blow| blow_columns().map(move |figure| (figure.value)(blow));
    table(py, blows.len(), blow_columns().count(), blows.iter().flat_map(row).collect())
}

fn table(py: Python<'_>, rows: usize, columns: usize, values: Vec<f64>) -> PyResult<Table<'_>> {
    let array = Array2::from_shape_vec((rows, columns), values);
    Ok(array.map_err(|error| refused(error.to_string()))?.into_pyarray(py))
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (numbers, journal=false, record=false))]
    fn new(
        py: Python<'_>,
        numbers: HashMap<String, f64>,
        journal: bool,
        record: bool,
    ) -> PyResult<Self> {
        let scene = scene_of(&numbers)?;
        let mut session = interruptible(py, || guarded(|| Session::new(&scene, journal)))?;
        if record {
            session.machine.record_blows();
        }
        Ok(Self { session: Turn::new(session) })
    }

    /// Present time, s.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.short(py, |session| Ok(session.machine.time()))
    }

    /// Warnings of the engine about the scene.
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.short(py, |session| Ok(session.machine.warnings()))
    }

    /// A new warning of the exchange with what drives the hammer.
    fn news(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.short(py, |session| Ok(session.news()))
    }

    /// Sets inputs and tunable parameters, from now on.
    fn set(&self, py: Python<'_>, numbers: HashMap<String, f64>) -> PyResult<()> {
        let mut rows = Vec::with_capacity(numbers.len());
        for (name, value) in &numbers {
            if !value.is_finite() {
                return Err(refused(format!("{name} must be finite, not {value}")));
            }
            rows.push((settable(name)?, *value));
        }
        self.short(py, |session| {
            rows.iter().for_each(|(what, value)| what.set(session, *value));
            Ok(())
        })
    }

    /// Sets derivatives of an input, orders from 1, from now on.
    fn set_derivatives(&self, py: Python<'_>, name: &str, derivatives: Vec<f64>) -> PyResult<()> {
        let Settable::Input(input) = settable(name)? else {
            return Err(refused(format!("{name} is not an input")));
        };
        if derivatives.len() > MAX_INPUT_ORDER || derivatives.iter().any(|d| !d.is_finite()) {
            return Err(refused(format!(
                "{name} takes up to {MAX_INPUT_ORDER} derivatives, all finite"
            )));
        }
        self.short(py, |session| {
            session.set_input(input, None, &derivatives);
            Ok(())
        })
    }

    /// One communication step up to an instant, or to the event that ends it. Returns the instant reached.
    fn advance(&self, py: Python<'_>, to: f64) -> PyResult<f64> {
        self.long(py, |session| {
            session.advance(to)?;
            Ok(session.machine.time())
        })
    }

    /// From now on, ends steps where the piston passes one of these positions, m, and at blows.
    fn stop_at(&self, py: Python<'_>, positions: Vec<f64>, blows: bool) -> PyResult<()> {
        if let Some(wrong) = positions.iter().find(|at| !at.is_finite()) {
            return Err(refused(format!("a position must be finite, not {wrong}")));
        }
        self.short(py, |session| {
            let wanted = blows || !positions.is_empty();
            let stops = wanted.then(|| Stops::new(&session.machine, blows, &positions));
            session.pending.stops = stops;
            Ok(())
        })
    }

    /// Present values as numbers; those of enumerations count from 1.
    fn read(&self, py: Python<'_>, selection: &Selection) -> PyResult<Vec<f64>> {
        self.short(py, |session| {
            let mut values = Vec::with_capacity(selection.picks.len());
            session.read(&selection.picks, &mut values)?;
            Ok(values)
        })
    }

    /// Time derivative of an output, in its unit per s.
    fn rate(&self, py: Python<'_>, name: &str) -> PyResult<f64> {
        let row = row(name)?.0;
        let rate = self.short(py, |session| session.rate(row))?;
        rate.ok_or_else(|| refused(format!("{name} is not an output, so it has no rate")))
    }

    /// All blows of the last step, one in a row.
    fn step_blows<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let blows = self.short(py, |session| Ok(session.machine.step_blows().clone()))?;
        blow_table(py, &Vec::from(blows))
    }

    /// The long-run response of this hammer as `step` goes on with it, in the form of [`Batch::steady`]; `tell` is
    /// told the number of blows and the error over the one wanted.
    fn steady(
        slf: Py<Self>,
        py: Python<'_>,
        step: Py<PyAny>,
        wanted: Asked,
        tell: Py<PyAny>,
    ) -> PyResult<Vec<f64>> {
        let wanted = wanted_of(wanted)?;
        let waiting =
            slf.get().short(py, |session| Ok(Waiting::new(&mut session.machine, wanted.limit)))?;
        let mut refused = None;
        let found =
            steady_of(Stepped { machine: slf, step, waiting }, &wanted, &mut |blows, error| {
                refused = Python::attach(|py| tell.call1(py, (blows, error)).err());
                refused.is_none()
            })?;
        refused.map_or(Ok(response_numbers(&found)), Err)
    }

    /// Steps from instant to instant and reads at each. Returns rows of the selected values, and the records of all blows. A signal
    /// has given values at the start and at each instant; between these, an input is a straight line, and a parameter
    /// constant.
    fn run<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
        selection: &Selection,
        signals: HashMap<String, PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<(Table<'py>, Table<'py>)> {
        let times = times.as_array().to_vec();
        let signals = signals.iter().map(|(name, values)| signal(name, values, times.len()));
        let signals: Vec<Signal> = signals.collect::<PyResult<_>>()?;
        let (rows, blows) = self.long(py, |session| {
            let (mut rows, mut blows) = (Vec::new(), Vec::new());
            for (k, to) in times.iter().enumerate() {
                if *to > 0.0 {
                    signals.iter().for_each(|signal| signal.set(session, k, *to));
                    session.advance(*to)?;
                }
                session.read(&selection.picks, &mut rows)?;
                blows.extend(session.machine.step_blows());
            }
            Ok((rows, blows))
        })?;
        let rows = table(py, times.len(), selection.picks.len(), rows)?;
        Ok((rows, blow_table(py, &blows)?))
    }

    /// The state now.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Snapshot> {
        self.short(py, |session| Ok(Snapshot::of(session)))
    }

    /// Goes to a state, earlier or later, of the same hammer.
    fn restore(&self, py: Python<'_>, snapshot: &Snapshot) -> PyResult<()> {
        self.short(py, |session| session.resume(&snapshot.state, &snapshot.pending))
    }
}

/// A hammer that Python steps.
struct Stepped {
    machine: Py<Machine>,
    step: Py<PyAny>,
    waiting: Waiting,
}

impl Simulation for Stepped {
    type Error = PyErr;

    fn go_on(&mut self, blows: &mut Vec<Blow>) -> PyResult<bool> {
        Python::attach(|py| {
            self.step.call0(py)?;
            let waiting = &mut self.waiting;
            self.machine.get().short(py, |session| Ok(waiting.collect(&mut session.machine, blows)))
        })
    }
}

fn signal(name: &str, values: &PyReadonlyArray1<'_, f64>, points: usize) -> PyResult<Signal> {
    let values = values.as_array().to_vec();
    if values.len() != points + 1 || values.iter().any(|value| !value.is_finite()) {
        return Err(refused(format!("{name} needs {} finite values", points + 1)));
    }
    Ok(Signal { what: settable(name)?, values })
}

impl Signal {
    /// Sets the values for the step to the instant `k`.
    fn set(&self, session: &mut Session, k: usize, to: f64) {
        let (value, end, size) = (self.values[k], self.values[k + 1], to - session.machine.time());
        match self.what {
            Settable::Input(input) if size > 0.0 => {
                session.set_input(input, Some(value), &[(end - value) / size]);
            }
            _ => self.what.set(session, value),
        }
    }
}
