//! Access to an object by one call at a time.
//!
//! If a call finds the object in use, there are three cases:
//! * Another thread is using it. The call waits, and handles signals while it waits.
//! * Its own thread is using it. The call comes from a signal handler or from a callback of the engine and would wait
//!   for itself, so it is refused.
//! * The thread that was using it does not exist in this process, because the process was forked meanwhile. The call
//!   is refused.

use crate::failure::Failure;
use crate::interrupt::PAUSE;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Shortest and longest interval at which a waiting call tries again.
const LOOKS: [Duration; 2] = [Duration::from_micros(20), Duration::from_millis(1)];

/// Number of forks that led to this process.
static FORKS: AtomicU32 = AtomicU32::new(0);
/// Number of threads that have used an object.
static THREADS: AtomicU32 = AtomicU32::new(0);

thread_local! {
    /// This thread's number, from 1. After a fork, the child's first thread has the number of the thread that forked.
    static NUMBER: u32 = THREADS.fetch_add(1, Ordering::Relaxed) + 1;
}

/// Called by Python in the child process after a fork, to recognise objects that a missing thread was using.
#[pyfunction]
pub fn forked() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// Identifies this thread of this process.
fn present() -> u64 {
    (u64::from(FORKS.load(Ordering::Relaxed)) << 32) | u64::from(NUMBER.with(|number| *number))
}

/// An object that only one call at a time can use.
pub struct Turn<T> {
    inner: Mutex<T>,
    /// True after a panic.
    broken: AtomicBool,
    /// The thread that is using it; 0 if none is.
    user: AtomicU64,
    /// The number of forks that led to the process that created it.
    forks: u32,
}

/// Exclusive access to the object; it ends when this value is dropped.
pub struct Use<'a, T> {
    pub object: MutexGuard<'a, T>,
    turn: &'a Turn<T>,
}

impl<T: Send> Use<'_, T> {
    /// Returns a closure that does the work on the object, on any thread. A panic becomes a failure; then the object
    /// cannot be used any more.
    pub fn attempt<R>(
        &mut self,
        work: impl FnOnce(&mut T) -> Result<R, Failure> + Send,
    ) -> impl FnOnce() -> Result<R, Failure> + Send {
        let (object, broken) = (&mut *self.object, &self.turn.broken);
        move || {
            catch_unwind(AssertUnwindSafe(|| work(object))).unwrap_or_else(|payload| {
                broken.store(true, Ordering::Relaxed);
                Err(Failure::of_panic(&*payload))
            })
        }
    }
}

impl<T> Drop for Use<'_, T> {
    fn drop(&mut self) {
        self.turn.user.store(0, Ordering::Relaxed);
    }
}

impl<T: Send> Turn<T> {
    pub fn new(object: T) -> Self {
        let forks = FORKS.load(Ordering::Relaxed);
        let (broken, user) = (AtomicBool::new(false), AtomicU64::new(0));
        Self { inner: Mutex::new(object), broken, user, forks }
    }

    /// Whether this process created it. The threads of the object exist only in that process.
    pub fn is_at_home(&self) -> bool {
        self.forks == FORKS.load(Ordering::Relaxed)
    }

    /// The object itself; the exclusive reference proves that nothing else uses it.
    pub fn get_mut(&mut self) -> Option<&mut T> {
        self.inner.get_mut().ok()
    }

    /// Begins to use the object; returns `None` if it is in use.
    ///
    /// # Errors
    /// An earlier call has panicked.
    pub fn free(&self) -> Result<Option<Use<'_, T>>, Failure> {
        let Ok(object) = self.inner.try_lock() else { return Ok(None) };
        if self.broken.load(Ordering::Relaxed) {
            return Err(Failure::broken());
        }
        self.user.store(present(), Ordering::Relaxed);
        Ok(Some(Use { object, turn: self }))
    }

    /// Waits until the object is free, then begins to use it.
    ///
    /// # Errors
    /// The call would wait for ever, a signal handler raised an exception, or an earlier call has panicked.
    pub fn begin(&self, py: Python<'_>) -> Result<Use<'_, T>, Failure> {
        let (mut look, mut asked) = (LOOKS[0], Instant::now());
        loop {
            if let Some(begun) = self.free()? {
                return Ok(begun);
            }
            let (user, own) = (self.user.load(Ordering::Relaxed), present());
            if user == own {
                return Err(Failure::refused(
                    "busy: this thread is using the same object already, and a signal's handler or \
                     a callback cannot use it in between; catch this error there, and the call goes on; \
                     read or do what is wanted after it",
                ));
            }
            if user != 0 && user >> 32 != own >> 32 {
                return Err(Failure::refused(
                    "busy: a thread used this object while the process was forked, and the forked \
                     process does not have that thread; make the object after the fork",
                ));
            }
            py.detach(|| sleep(look));
            look = (2 * look).min(LOOKS[1]);
            if asked.elapsed() >= PAUSE {
                py.check_signals().map_err(Failure::Python)?;
                asked = Instant::now();
            }
        }
    }
}
