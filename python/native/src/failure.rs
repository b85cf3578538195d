//! What goes wrong, as exceptions of Python.

use pyo3::PyErr;
use std::any::Any;

pyo3::import_exception!(dth_hammer.errors, DomainError);
pyo3::import_exception!(dth_hammer.errors, RefusedError);
pyo3::import_exception!(dth_hammer.errors, UnknownNameError);

/// Why a call is refused; made an exception when the interpreter is held again.
pub enum Failure {
    /// What the engine says.
    Refused(String),
    /// What Python raised meanwhile: `KeyboardInterrupt`.
    Python(PyErr),
}

impl Failure {
    /// What a caught panic says of itself.
    pub fn of_panic(payload: &(dyn Any + Send)) -> Self {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
        Self::Refused(format!("internal error: {text}"))
    }

    pub fn refused(text: &str) -> Self {
        Self::Refused(text.to_owned())
    }

    /// After a panic on the same object.
    pub fn broken() -> Self {
        Self::Refused("an internal error has ended this hammer: make another".into())
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Refused(text) => RefusedError::new_err(text),
            Failure::Python(error) => error,
        }
    }
}

/// An argument that makes no sense.
pub fn refused(text: impl Into<String>) -> PyErr {
    DomainError::new_err(text.into())
}
