//! Ctrl-C while the engine works.

use crate::failure::Failure;
use pyo3::{PyErr, Python};
use std::time::{Duration, Instant};

/// How often Python is asked for signals.
const PAUSE: Duration = Duration::from_millis(20);

/// Asks Python for signals now and then, from wherever the engine can be stopped.
pub struct Interrupt {
    next: Instant,
    raised: Option<PyErr>,
}

impl Interrupt {
    pub fn begin() -> Self {
        Self { next: Instant::now() + PAUSE, raised: None }
    }

    /// False once a signal's handler has raised.
    pub fn goes_on(&mut self) -> bool {
        if self.raised.is_none() && Instant::now() >= self.next {
            self.raised = Python::attach(|py| py.check_signals()).err();
            self.next = Instant::now() + PAUSE;
        }
        self.raised.is_none()
    }

    /// Advances a machine; what a handler raised is the error then.
    pub fn advance(&mut self, machine: &mut hammer::Machine, to: f64) -> Result<(), Failure> {
        machine.advance_while(to, || self.goes_on())?;
        self.goes_on();
        self.raised.take().map_or(Ok(()), |error| Err(Failure::Python(error)))
    }
}
