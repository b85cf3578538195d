//! Ctrl-C while the engine works.

use crate::failure::Failure;
use hammer::Interrupt;
use pyo3::{PyErr, Python};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How often Python is asked about signals.
pub const PAUSE: Duration = Duration::from_millis(20);

/// Time of the next question to Python, and the exception that a signal's handler has raised.
type Heard = (Instant, Option<PyErr>);

/// Does long work of the engine while other Python threads run. An exception from a signal's handler ends it, and
/// becomes its failure; so does whatever ends the enclosing work.
///
/// # Errors
/// Those of the work.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let heard = Arc::new(Mutex::new((Instant::now() + PAUSE, None)));
    let (asked, own, whole) = (heard.clone(), thread::current().id(), Interrupt::present());
    // Another thread that waits here could take the turn of the only thread that handles signals.
    let interrupt = Interrupt::asking(move || {
        // The lock is held if a signal's handler itself does work of the engine.
        let mut turn = asked.try_lock();
        let raised = turn.as_mut().is_ok_and(|heard| thread::current().id() == own && asks(heard));
        drop(turn);
        raised || whole.is_set()
    });
    let done = py.detach(|| interrupt.watch(work));
    let raised = heard.lock().unwrap_or_else(PoisonError::into_inner).1.take();
    raised.map_or(done, |error| Err(Failure::Python(error)))
}

/// True after a signal's handler has raised an exception.
fn asks((next, raised): &mut Heard) -> bool {
    if raised.is_none() && Instant::now() >= *next {
        *raised = Python::attach(|py| py.check_signals()).err();
        *next = Instant::now() + PAUSE;
    }
    raised.is_some()
}
