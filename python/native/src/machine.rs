//! The hammer as a Python object.

use crate::failure::{Failure, refused};
use crate::interrupt::interruptible;
use crate::scene::scene_of;
use crate::session::Session;
use crate::snapshot::Snapshot;
use crate::table::{BLOW_WIDTH, Selection, of_blow, row};
use crate::turn::Turn;
use hammer::variables::Role;
use hammer::{Input, MAX_INPUT_ORDER, Stops};
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

/// Recorded rows of a run: of what was read, and of blows.
#[derive(Default)]
struct Record {
    rows: Vec<f64>,
    blows: Vec<f64>,
}

impl Record {
    /// All blows, one in a row.
    fn blows(py: Python<'_>, values: Vec<f64>) -> PyResult<Table<'_>> {
        table(py, values.len() / BLOW_WIDTH, BLOW_WIDTH, values)
    }

    fn note(&mut self, session: &mut Session, selection: &Selection) -> Result<(), Failure> {
        session.read(&selection.picks, &mut self.rows)?;
        for blow in session.machine.step_blows() {
            self.blows.extend(of_blow(blow));
        }
        Ok(())
    }
}

fn table(py: Python<'_>, rows: usize, columns: usize, values: Vec<f64>) -> PyResult<Table<'_>> {
    let array = Array2::from_shape_vec((rows, columns), values);
    Ok(array.map_err(|error| refused(error.to_string()))?.into_pyarray(py))
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (numbers, journal=false))]
    fn new(py: Python<'_>, numbers: HashMap<String, f64>, journal: bool) -> PyResult<Self> {
        let scene = scene_of(&numbers)?;
        let session = interruptible(py, || guarded(|| Session::new(&scene, journal)))?;
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
        let none = Selection { picks: Vec::new() };
        let record = self.short(py, |session| {
            let mut record = Record::default();
            record.note(session, &none).map(|()| record)
        })?;
        Record::blows(py, record.blows)
    }

    /// Steps from instant to instant and reads at each. Returns rows of the selected values, and all blows. A signal
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
        let record = self.long(py, |session| {
            let mut record = Record::default();
            for (k, to) in times.iter().enumerate() {
                if *to > 0.0 {
                    signals.iter().for_each(|signal| signal.set(session, k, *to));
                    session.advance(*to)?;
                }
                record.note(session, selection)?;
            }
            Ok(record)
        })?;
        let rows = table(py, times.len(), selection.picks.len(), record.rows)?;
        Ok((rows, Record::blows(py, record.blows)?))
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
