//! Hammers that are stepped side by side on threads: for controllers that learn from many.

use crate::failure::{Failure, refused};
use crate::interrupt::interruptible;
use crate::machine::{Settable, Table, guarded, settable, table};
use crate::scene::scene_of;
use crate::session::Session;
use crate::table::{Pick, Selection};
use hammer::in_threads;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use std::sync::Mutex;

/// A hammer, or why it was refused: then nothing of it is read until it is made anew.
type Member = Result<Session, String>;

/// A row a hammer of what was read, and which were refused, and why.
type Answer<'py> = (Table<'py>, Vec<(usize, String)>);

/// Most hammers, and most threads, of a fleet: far fewer fill a machine.
const MOST: i64 = 1_000_000;
const MOST_THREADS: i64 = 1024;

/// Hammers that are stepped together.
#[pyclass(frozen, module = "dth_hammer._native")]
pub struct Fleet {
    inner: Mutex<Inner>,
    actions: Vec<Settable>,
    picks: Vec<Pick>,
    threads: usize,
}

struct Inner {
    members: Vec<Member>,
    /// What was read of each.
    rows: Vec<f64>,
}

#[pymethods]
impl Fleet {
    /// So many hammers, none of which is made yet: what is set at each step, and what is read.
    #[new]
    fn new(
        count: i64,
        actions: Vec<String>,
        selection: &Selection,
        threads: i64,
    ) -> PyResult<Self> {
        let actions: Vec<_> = actions.iter().map(|n| settable(n)).collect::<PyResult<_>>()?;
        let within = |what: &str, number: i64, most: i64| {
            let found = usize::try_from(number).ok().filter(|_| (1..=most).contains(&number));
            found.ok_or_else(|| refused(format!("{number} {what} must be 1 to {most}")))
        };
        let (count, threads) =
            (within("hammers", count, MOST)?, within("threads", threads, MOST_THREADS)?);
        if selection.picks.is_empty() {
            return Err(refused("give names to read"));
        }
        let members = (0..count).map(|_| Err("this hammer was not started".to_owned())).collect();
        let rows = vec![f64::NAN; count * selection.picks.len()];
        let inner = Mutex::new(Inner { members, rows });
        Ok(Self { inner, actions, picks: selection.picks.clone(), threads })
    }

    /// Makes hammers anew, each from its numbers by name, at time 0.
    fn restart<'py>(
        &self,
        py: Python<'py>,
        which: Vec<(usize, Vec<(String, f64)>)>,
    ) -> PyResult<Answer<'py>> {
        let scenes = which
            .into_iter()
            .map(|(k, numbers)| Ok((k, scene_of(&numbers.into_iter().collect())?)));
        let scenes: Vec<_> = scenes.collect::<PyResult<_>>()?;
        self.work(py, |k, member| {
            if let Some((_, scene)) = scenes.iter().find(|(at, _)| *at == k) {
                *member = Err(String::new());
                *member = Ok(Session::new(scene, false)?);
            }
            Ok(())
        })
    }

    /// Steps all, each with its row of values.
    fn step<'py>(
        &self,
        py: Python<'py>,
        size: f64,
        values: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Answer<'py>> {
        let values = values.as_array();
        if values.ncols() != self.actions.len() || values.iter().any(|value| !value.is_finite()) {
            return Err(refused(format!("give {} finite values a hammer", self.actions.len())));
        }
        if !(size > 0.0 && size.is_finite()) {
            return Err(refused(format!("a step of {size} s must be above 0 and finite")));
        }
        self.work(py, |k, member| {
            let Ok(session) = member else { return Ok(()) };
            let row = (k < values.nrows()).then(|| values.row(k));
            let row = row.ok_or_else(|| Failure::refused("no values were given for it"))?;
            for (action, value) in self.actions.iter().zip(row) {
                action.set(session, *value);
            }
            session.advance(session.machine.time() + size)
        })
    }
}

impl Fleet {
    /// Does some work on each hammer, on all threads, and reads them. Ctrl-C ends it.
    fn work<'py>(
        &self,
        py: Python<'py>,
        work: impl Fn(usize, &mut Member) -> Result<(), Failure> + Sync,
    ) -> PyResult<Answer<'py>> {
        let width = self.picks.len();
        let one = |k: usize, member: &mut Member, row: &mut [f64]| {
            let result = guarded(|| {
                work(k, member)?;
                let mut read = Vec::with_capacity(width);
                if let Ok(session) = member {
                    session.read(&self.picks, &mut read)?;
                    row.copy_from_slice(&read);
                }
                Ok(())
            });
            if let Err(Failure::Refused(text)) = result {
                *member = Err(text);
            }
            if member.is_err() {
                row.fill(f64::NAN);
            }
        };
        let (count, rows, why) = interruptible(py, || {
            let mut inner = self.inner.lock().map_err(|_| Failure::broken())?;
            let Inner { members, rows } = &mut *inner;
            let share = members.len().div_ceil(self.threads);
            let parts = members.chunks_mut(share).zip(rows.chunks_mut(share * width)).enumerate();
            in_threads(parts.collect(), self.threads, |(number, (members, rows))| {
                let each = members.iter_mut().zip(rows.chunks_mut(width)).enumerate();
                each.for_each(|(k, (member, row))| one(number * share + k, member, row));
            });
            let why = members.iter().enumerate();
            let why = why.filter_map(|(k, m)| m.as_ref().err().map(|text| (k, text.clone())));
            Ok((members.len(), rows.clone(), why.collect()))
        })?;
        Ok((table(py, count, width, rows)?, why))
    }
}
