//! Ctrl-C while the engine works.

use crate::failure::Failure;
use hammer::Interrupt;
use pyo3::{PyErr, Python};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How often Python is asked for signals.
pub const PAUSE: Duration = Duration::from_millis(20);

/// When Python is asked next, and what a signal's handler has raised.
type Heard = (Instant, Option<PyErr>);

/// Does long work of the engine while other threads of Python run. A signal whose handler raises ends
/// it, and what was raised is the failure then; so does what ends the work that this is a part of.
///
/// # Errors
/// What the work fails with.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let heard = Arc::new(Mutex::new((Instant::now() + PAUSE, None)));
    let (asked, own, whole) = (heard.clone(), thread::current().id(), Interrupt::present());
    // Another thread that listens would take the turn of the one that may hear.
    let interrupt = Interrupt::asking(move || {
        // In a signal's handler that does work of the engine itself, it is being asked already.
        let mut turn = asked.try_lock();
        let raised = turn.as_mut().is_ok_and(|heard| thread::current().id() == own && asks(heard));
        drop(turn);
        raised || whole.is_set()
    });
    let done = py.detach(|| interrupt.watch(work));
    let raised = heard.lock().unwrap_or_else(PoisonError::into_inner).1.take();
    raised.map_or(done, |error| Err(Failure::Python(error)))
}

/// True once a signal's handler has raised.
fn asks((next, raised): &mut Heard) -> bool {
    if raised.is_none() && Instant::now() >= *next {
        *raised = Python::attach(|py| py.check_signals()).err();
        *next = Instant::now() + PAUSE;
    }
    raised.is_some()
}
