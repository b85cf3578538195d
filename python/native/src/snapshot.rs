//! The complete state of a hammer, in memory or as bytes with a checksum.

use crate::failure::{RefusedError, refused};
use crate::session::{Pending, Session};
use hammer::State;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};

/// First bytes: the kind of data, the version of this package and that of the engine's state.
fn magic() -> Vec<u8> {
    format!("dth-hammer {} {}\n", env!("CARGO_PKG_VERSION"), State::FORMAT).into_bytes()
}

/// The state of a hammer at an instant, for any hammer with the same parameters.
#[pyclass(frozen, module = "dth_hammer._native")]
#[derive(Serialize, Deserialize)]
pub struct Snapshot {
    pub state: State,
    pub pending: Pending,
    /// Present time, s.
    #[pyo3(get)]
    time: f64,
}

impl Snapshot {
    pub fn of(session: &Session) -> Self {
        let (state, pending) = (session.machine.state(), session.pending.clone());
        Self { state, pending, time: session.machine.time() }
    }
}

#[pymethods]
impl Snapshot {
    /// The state as bytes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let content =
            postcard::to_stdvec(self).map_err(|_| refused("the state cannot be encoded"))?;
        let sum = crc32fast::hash(&content).to_le_bytes();
        Ok(PyBytes::new(py, &[&magic()[..], &sum, &content].concat()))
    }

    /// A state from bytes.
    #[staticmethod]
    fn from_bytes(data: &[u8]) -> PyResult<Self> {
        let wrong =
            |what: &str| RefusedError::new_err(format!("the stored state cannot be used: {what}"));
        let rest = data
            .strip_prefix(&magic()[..])
            .ok_or_else(|| wrong("it is not of this version of dth-hammer"))?;
        let (sum, content) = rest.split_first_chunk().ok_or_else(|| wrong("it is too short"))?;
        if crc32fast::hash(content) != u32::from_le_bytes(*sum) {
            return Err(wrong("its checksum is wrong"));
        }
        postcard::from_bytes(content).map_err(|_| wrong("its content cannot be decoded"))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let make = slf.get_type().getattr("from_bytes")?;
        Ok((make, (slf.get().to_bytes(slf.py())?,)))
    }

    fn __repr__(&self) -> String {
        format!("<Snapshot at {} s>", self.time)
    }
}
