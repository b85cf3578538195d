//! Handling of Ctrl-C while the engine works.

use crate::failure::Failure;
use hammer::Interrupt;
use pyo3::{PyErr, Python};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Interval at which Python's pending signals are checked.
pub const PAUSE: Duration = Duration::from_millis(20);

/// Time of the next check for signals, and the exception that a signal handler has raised.
type SignalState = (Instant, Option<PyErr>);

/// Does long work of the engine without holding Python's lock, so that other Python threads can run.
///
/// If a signal handler raises an exception, the work stops and the exception is returned. The work also stops if the
/// interrupt of an enclosing call of the engine is set.
///
/// # Errors
/// The error of the work, or the exception of a signal handler.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let state = Arc::new(Mutex::new((Instant::now() + PAUSE, None)));
    let (shared, caller, enclosing) = (state.clone(), thread::current().id(), Interrupt::present());
    // Only the calling thread checks for signals. Python handles them on its main thread alone, and a check by another
    // thread would only postpone the next one.
    let interrupt = Interrupt::asking(move || {
        // The lock is taken already if a signal handler calls the engine itself.
        let mut guard = shared.try_lock();
        let raised =
            guard.as_mut().is_ok_and(|state| thread::current().id() == caller && poll(state));
        drop(guard);
        raised || enclosing.is_set()
    });
    let result = py.detach(|| interrupt.watch(work));
    let raised = state.lock().unwrap_or_else(PoisonError::into_inner).1.take();
    raised.map_or(result, |error| Err(Failure::Python(error)))
}

/// Checks for signals if it is time to, and returns whether a signal handler has raised an exception.
fn poll((next, raised): &mut SignalState) -> bool {
    if raised.is_none() && Instant::now() >= *next {
        *raised = Python::attach(|py| py.check_signals()).err();
        *next = Instant::now() + PAUSE;
    }
    raised.is_some()
}
