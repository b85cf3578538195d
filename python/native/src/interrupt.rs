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
type Heard = (Instant, Option<PyErr>);

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
    let heard = Arc::new(Mutex::new((Instant::now() + PAUSE, None)));
    let (asked, own, whole) = (heard.clone(), thread::current().id(), Interrupt::present());
    // Only the calling thread checks for signals. Python handles them on its main thread alone, and a check by another
    // thread would only postpone the next one.
    let interrupt = Interrupt::asking(move || {
        // The lock is taken already if a signal handler calls the engine itself.
        let mut turn = asked.try_lock();
        let raised = turn.as_mut().is_ok_and(|heard| thread::current().id() == own && asks(heard));
        drop(turn);
        raised || whole.is_set()
    });
    let done = py.detach(|| interrupt.watch(work));
    let raised = heard.lock().unwrap_or_else(PoisonError::into_inner).1.take();
    raised.map_or(done, |error| Err(Failure::Python(error)))
}

/// Checks for signals if it is time to, and returns whether a signal handler has raised an exception.
fn asks((next, raised): &mut Heard) -> bool {
    if raised.is_none() && Instant::now() >= *next {
        *raised = Python::attach(|py| py.check_signals()).err();
        *next = Instant::now() + PAUSE;
    }
    raised.is_some()
}
