//! Errors as Python exceptions.

use pyo3::PyErr;
use std::any::Any;

pyo3::import_exception!(dth_hammer.errors, DomainError);
pyo3::import_exception!(dth_hammer.errors, RefusedError);
pyo3::import_exception!(dth_hammer.errors, UnknownNameError);

/// Why a call failed. It is converted to a Python exception once the interpreter's lock is held again.
pub enum Failure {
    /// An error of the engine.
    Refused(String),
    /// An exception that Python raised during the call, such as `KeyboardInterrupt`.
    Python(PyErr),
}

impl Failure {
    /// The message of a caught panic.
    pub fn of_panic(payload: &(dyn Any + Send)) -> Self {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
        Self::Refused(format!("internal error: {text}"))
    }

    pub fn refused(text: &str) -> Self {
        Self::Refused(text.to_owned())
    }

    /// The error of every call on an object after a call on it has panicked.
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

/// The exception for an invalid argument.
pub fn refused(text: impl Into<String>) -> PyErr {
    DomainError::new_err(text.into())
}
